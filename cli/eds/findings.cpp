#include "cli/eds/findings.hpp"

#include <fmt/format.h>

#include "biss/eds/check.hpp"
#include "cli/eds/entries.hpp"

namespace biss::cli {
namespace {

// Problems whose finding knows the right value.
bool knows_better(const EdsFinding& found) {
  switch (found.problem) {
    case EdsProblem::checksum:
    case EdsProblem::little_endian:
    case EdsProblem::polynomial_full_form:
    case EdsProblem::identifier:
    case EdsProblem::channel_count:
    case EdsProblem::encoder_type:
    case EdsProblem::data_length_differs:
    case EdsProblem::polynomial_differs:
      return true;
    case EdsProblem::lengths:
    case EdsProblem::version:
    case EdsProblem::polynomial:
      return found.expected != 0;
    default:
      return false;
  }
}

std::optional<std::uint32_t> expected_of(const EdsFinding& found) {
  const bool contradicted = !found.against.empty() && found.problem != EdsProblem::lengths;
  return knows_better(found) || contradicted ? std::optional(found.expected) : std::nullopt;
}

void add_incomplete(std::vector<EdsFindingRow>& rows, const EdsPartEntry& part) {
  for (const EdsField& field : fields_of(part.part)) {
    if (known_value(*part.found, field)) continue;
    rows.push_back({.part = name_of(part.part),
                    .channel = part.channel,
                    .symbol = field.symbol,
                    .problem = "incomplete",
                    .value = {},
                    .against = {},
                    .expected = {},
                    .text = "bytes are missing from the dump, the part is not judged"});
    return;
  }
}

}  // namespace

std::vector<EdsFindingRow> eds_findings(const dump::DataSheet& sheet,
                                        const EdsCheckOptions& rules) {
  std::vector<EdsFindingRow> rows;
  for (const EdsPartEntry& part : eds_parts(sheet)) {
    if (!part.found->whole) add_incomplete(rows, part);
  }
  const EdsImage image = sheet.image();
  check_eds(
      image,
      [&](const EdsFinding& found) {
        const bool common = found.part == EdsPart::common;
        rows.push_back({.part = name_of(found.part),
                        .channel = common ? std::nullopt : std::optional<unsigned>(found.channel),
                        .symbol = found.symbol,
                        .problem = name_of(found.problem),
                        .value = found.value,
                        .against = found.against,
                        .expected = expected_of(found),
                        .certain = knows_better(found),
                        .text = std::string(text_of(found.problem))});
      },
      rules);
  return rows;
}

std::string finding_line(const EdsFindingRow& row) {
  std::string out = fmt::format("{}: {}", row.symbol, row.text);
  if (row.value) out += fmt::format(" ({}", *row.value);
  if (row.value && row.expected) {
    out += row.certain ? fmt::format(", expected {}", *row.expected)
                       : fmt::format(", {} {}", row.against, *row.expected);
  }
  if (row.value) out += ')';
  return out;
}

bool write_findings(const std::vector<EdsFindingRow>& rows, report::Format format, Output& output) {
  using report::Kind;
  if (rows.empty() && format == report::Format::table) return true;
  std::vector<report::Column> columns = {{.name = "part"},
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

}  // namespace biss::cli
