// biss eds check: the findings of a data sheet.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "biss/eds/check.hpp"
#include "report/summary.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/eds/rows.hpp"
#include "verbs/eds/source.hpp"

namespace biss::verbs {
namespace {

struct SheetCheckOptions {
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
    rows.push_back(
        {.part = name_of(EdsPart::common),
         .symbol = find_field(common_fields, fmt::format("BANK_{}", i))->symbol,
         .problem = "incomplete",
         .value = bank,
         .text = fmt::format("the bank of channel {} is not in the dump, so the part is not judged",
                             i)});
  }
}

FieldRow finding_fields(const EdsFindingRow& row) {
  return {{"part", row.part},         {"symbol", row.symbol},
          {"problem", row.problem},   {"value", row.value},
          {"channel", row.channel},   {"against", unless_empty(row.against)},
          {"expected", row.expected}, {"text", row.text}};
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

ExitStatus run_check(const SheetCheckOptions& options, Host& host) {
  const EdsSource source = load_eds_with_part(options.arguments, host);
  EdsCheckOptions rules = options.rules;
  if (options.strict) {
    rules.zero_is_absent = false;
    rules.ones_are_absent = false;
    rules.unnamed_zero = true;
  }
  std::vector<EdsFindingRow> findings = eds_findings(source.sheet, rules);
  add_missing(findings, source.sheet, host);
  if (!options.strict) warn_of_power_on_delay(source, host);
  const ExitStatus written = write_output(host, options.output, [&](Output& output) {
    return write_rows(findings, options.to, output, finding_fields);
  });
  if (written != ExitStatus::done) return written;
  if (options.to == report::Format::table) {
    host.print_summary(findings.empty()
                           ? "nothing wrong found\n"
                           : fmt::format("\n{}\n", report::counted(findings.size(), "finding")));
  }
  return findings.empty() ? ExitStatus::done : ExitStatus::data_failed;
}

}  // namespace

Run add_eds_check(Verb verb) {
  const auto options = std::make_shared<SheetCheckOptions>();
  add_eds_file(verb, options->arguments.file);
  add_eds_options(verb, options->arguments);
  verb.add_flag("--strict", options->strict,
                "Also report values left out (0, all ones) and bytes that no source names");
  add_to_option(verb, options->to);
  add_output_option(verb, options->output);
  return [options](Host& host) { return run_check(*options, host); };
}

}  // namespace biss::verbs
