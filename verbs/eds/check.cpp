// biss eds check: the findings of a data sheet.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "biss/eds/check.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/eds/eds.hpp"
#include "verbs/eds/rows.hpp"
#include "verbs/eds/source.hpp"

namespace biss::verbs {
namespace {

struct CheckArguments {
  EdsArguments arguments;
  EdsCheckOptions rules;
  bool strict = false;
  report::Format to = report::Format::table;
  std::string output;
};

// A profile part without any byte in the dump is a finding, and so is a part with a missing byte.
void add_missing(std::vector<EdsFindingRow>& rows, const dump::DataSheet& sheet, Host& host) {
  if (!sheet.common) {
    host.warn("the common part is not in the dump: the profile part is judged alone");
    return;
  }
  const CommonPart common = parse_common_part(sheet.common->filled);
  for (std::size_t i = 0; i < std::min<std::size_t>(common.dc_num, max_channels); ++i) {
    const unsigned bank = common.channels[i].bank;
    const bool stated = bank != 0 && bank != 0xFF;
    if (sheet.profiles[i] || !stated || bank == sheet.common->bank) continue;
    EdsFindingRow& row = rows.emplace_back();
    row.part = name_of(EdsPart::common);
    row.symbol = find_field(common_fields, fmt::format("BANK_{}", i))->symbol;
    row.problem = "incomplete";
    row.value = bank;
    row.text =
        fmt::format("the bank of channel {} is not in the dump, so the part is not judged", i);
  }
}

// Nothing at all for a table without rows.
bool write_findings(const std::vector<EdsFindingRow>& rows, report::Format format, Output& output) {
  using report::Kind;
  if (rows.empty() && format == report::Format::table) return true;
  const std::vector<report::Column> columns = {{.name = "part"},
                                               {.name = "symbol"},
                                               {.name = "problem"},
                                               {.name = "value", .kind = Kind::unsigned_integer},
                                               {.name = "channel", .kind = Kind::unsigned_integer},
                                               {.name = "against"},
                                               {.name = "expected", .kind = Kind::unsigned_integer},
                                               {.name = "text"}};
  const auto table = report::make_table_writer(format, columns, output, output.table_options());
  for (const EdsFindingRow& row : rows) {
    const report::Cell against = row.against.empty() ? report::Cell() : report::Cell(row.against);
    const report::Cell cells[] = {row.part,    row.symbol, row.problem,  row.value,
                                  row.channel, against,    row.expected, row.text};
    if (!table->row(cells)) return false;
  }
  return table->finish();
}

// A remark, not a finding: the value can mean that the delay is not given.
void warn_of_power_on_delay(const EdsSource& source, Host& host) {
  const EdsField& field = *find_field(bp3_fields, "PON_PDL");
  for (const EdsPartRow& part : eds_parts(source.sheet)) {
    const EdsBank& bank = part.found->filled;
    const bool is_empty = is_filled_with(bank, 0x00) || is_filled_with(bank, 0xFF);
    if (part.part != EdsPart::bp3 || !part.found->whole || is_empty) continue;
    const std::uint32_t value = field_value(bank, field);
    if (field.in_range(value)) continue;
    host.warn(fmt::format(
        "{} of channel {} is {}, outside {} to {} ms: the delay from power-on is not given",
        field.symbol, part.channel.value_or(0), value, field.min, field.max));
  }
}

ExitStatus run_check(const CheckArguments& options, Host& host) {
  const auto source = load_eds_with_part(options.arguments, host);
  if (!source) return source.error();
  EdsCheckOptions rules = options.rules;
  if (options.strict) {
    rules.zero_is_absent = false;
    rules.ones_are_absent = false;
    rules.unnamed_zero = true;
  }
  std::vector<EdsFindingRow> findings = eds_findings(source->sheet, rules);
  add_missing(findings, source->sheet, host);
  if (!options.strict) warn_of_power_on_delay(*source, host);
  Output output(host);
  if (!output.open(options.output)) return output.status();
  if (!write_findings(findings, options.to, output) || !output.finish()) return output.status();
  if (options.to == report::Format::table) {
    host.print_summary(findings.empty() ? "nothing wrong found\n"
                                        : fmt::format("\n{} finding{}\n", findings.size(),
                                                      findings.size() == 1 ? "" : "s"));
  }
  return findings.empty() ? ExitStatus::done : ExitStatus::data_failed;
}

}  // namespace

Run add_eds_check(Verb verb) {
  const auto options = std::make_shared<CheckArguments>();
  add_eds_file(verb, options->arguments.file);
  add_eds_options(verb, options->arguments);
  verb.add_flag("--strict", options->strict,
                "Also report values left out (0, all ones) and bytes that no source names");
  add_to_option(verb, options->to);
  add_output_option(verb, options->output);
  return [options](Host& host) { return run_check(*options, host); };
}

}  // namespace biss::verbs
