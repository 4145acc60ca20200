// biss eds show: a data sheet field by field.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "biss/eds/image.hpp"
#include "cli/common/verb.hpp"
#include "cli/eds/description.hpp"
#include "cli/eds/eds.hpp"
#include "cli/eds/entries.hpp"
#include "cli/eds/source.hpp"
#include "cli/eds/summary.hpp"

namespace biss::cli {
namespace {

struct ShowOptions {
  EdsArguments arguments;
  std::string to = "table";
  bool all = false;
  std::string output;
};

const std::vector<std::string> show_formats{"table", "csv", "jsonl", "description"};

std::string part_name(const EdsEntry& entry) {
  return entry.channel.value_or(0) == 0 ? std::string(entry.part)
                                        : fmt::format("{} {}", entry.part, *entry.channel);
}

bool write_table(const EdsSource& source, const ShowOptions& options, Output& output) {
  using report::Kind;
  const std::vector<report::Column> columns = {
      {.name = "part"},   {.name = "address"},
      {.name = "symbol"}, {.name = "stored", .kind = Kind::unsigned_integer},
      {.name = "means"},  {.name = "what"}};
  const auto table =
      report::make_table_writer(report::Format::table, columns, output, output.table_options());
  for (const EdsEntry& entry : eds_entries(source.sheet)) {
    if (entry.unused && entry.value.value_or(0) == 0 && !options.all) continue;
    const std::string part = part_name(entry);
    const std::string address = fmt::format("0x{:02X}", entry.address);
    const report::Cell means = entry.means.empty() ? report::Cell() : report::Cell(entry.means);
    const report::Cell cells[] = {part, address, entry.symbol, entry.value, means, entry.meaning};
    if (!table->row(cells)) return false;
  }
  return table->finish();
}

bool write_csv(const EdsSource& source, Output& output) {
  using report::Kind;
  const std::vector<report::Column> columns = {{.name = "part"},
                                               {.name = "channel", .kind = Kind::unsigned_integer},
                                               {.name = "bank", .kind = Kind::unsigned_integer},
                                               {.name = "address", .kind = Kind::unsigned_integer},
                                               {.name = "symbol"},
                                               {.name = "value", .kind = Kind::unsigned_integer},
                                               {.name = "means"}};
  const auto table = report::make_table_writer(report::Format::csv, columns, output);
  for (const EdsEntry& entry : eds_entries(source.sheet)) {
    const report::Cell cells[] = {entry.part,   entry.channel, entry.bank, entry.address,
                                  entry.symbol, entry.value,   entry.means};
    if (!table->row(cells)) return false;
  }
  return table->finish();
}

// An object a part: the documents' symbols, then which part it is.
bool write_object(const EdsPartEntry& part, Output& output) {
  using report::Kind;
  std::vector<report::Column> columns{{.name = "part"}};
  std::vector<report::Cell> cells{name_of(part.part)};
  const auto add = [&](std::string_view name, Kind kind, report::Cell cell) {
    columns.push_back({.name = std::string(name), .kind = kind});
    cells.push_back(cell);
  };
  for (const EdsField& field : fields_of(part.part)) {
    if (field.kind == EdsKind::reserved || field.kind == EdsKind::unnamed) continue;
    add(field.symbol, Kind::unsigned_integer, known_value(*part.found, field));
  }
  add("channel", Kind::unsigned_integer, part.channel);
  add("bank", Kind::unsigned_integer, part.found->bank);
  std::string bytes;
  for (const auto& byte : part.found->bytes) {
    bytes += byte ? fmt::format("{:02X}", *byte) : std::string("--");
  }
  add("bytes", Kind::text, bytes);
  const auto table = report::make_table_writer(report::Format::jsonl, columns, output);
  return table->row(cells) && table->finish();
}

bool write_objects(const EdsSource& source, Output& output) {
  const auto parts = eds_parts(source.sheet);
  return std::all_of(parts.begin(), parts.end(),
                     [&](const EdsPartEntry& part) { return write_object(part, output); });
}

dump::RegisterDump overridden_dump(const EdsSource& source) {
  dump::RegisterDump dump = source.dump;
  if (source.overrides.empty()) return dump;
  for (const EdsPartEntry& part : eds_parts(source.sheet)) {
    if (part.found->whole) dump.set_bank(part.found->bank, part.found->filled);
  }
  return dump;
}

ExitStatus run_show(const ShowOptions& options) {
  const bool description = options.to == "description";
  // A description can say anything that a dump holds, also of a device without data sheet.
  const LoadedEds loaded =
      description ? load_eds(options.arguments) : load_eds_with_part(options.arguments);
  if (!loaded.source) return loaded.status;
  const EdsSource& source = *loaded.source;
  for (const EdsPartEntry& part : eds_parts(source.sheet)) {
    if (part.found->whole) continue;
    warn(fmt::format("bank {} is not whole: its {} part is shown, not used", part.found->bank,
                     name_of(part.part)));
  }
  Output output;
  if (!output.open(options.output)) return output.status();
  bool written = false;
  if (options.to == "table") {
    written = write_table(source, options, output);
  } else if (options.to == "csv") {
    written = write_csv(source, output);
  } else if (options.to == "jsonl") {
    written = write_objects(source, output);
  } else {
    written = output.write(write_description(overridden_dump(source), source.sheet));
  }
  if (!written || !output.finish()) return output.status();
  if (options.to == "table") print_summary(eds_summary(source));
  return ExitStatus::done;
}

}  // namespace

Run add_eds_show(Verb verb) {
  const auto options = std::make_shared<ShowOptions>();
  add_eds_file(verb, options->arguments.file);
  add_eds_options(verb, options->arguments);
  verb.add_flag("--all", options->all, "In the table reserved bytes and unused channels too");
  add_name_option(verb, "--to", options->to, show_formats, "Output format; table by default");
  add_output_option(verb, options->output);
  return [options] { return run_show(*options); };
}

}  // namespace biss::cli
