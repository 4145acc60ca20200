#include "verbs/eds/rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "biss/eds/check.hpp"
#include "biss/eds/image.hpp"
#include "verbs/eds/value.hpp"

namespace biss::verbs {
namespace {

using dump::FoundPart;

void add_raw(std::vector<EdsFieldRow>& rows, const EdsPartRow& part) {
  for (unsigned i = 0; i < eds_bank_bytes; ++i) {
    const auto& byte = part.found->bytes[i];
    rows.push_back({.part = name_of(EdsPart::raw),
                    .channel = part.channel,
                    .bank = part.found->bank,
                    .address = i,
                    .symbol = fmt::format("0x{:02X}", i),
                    .value = byte,
                    .unused = byte.value_or(0) == 0});
  }
}

void add_fields(std::vector<EdsFieldRow>& rows, const EdsPartRow& part) {
  const bool linear = part.part == EdsPart::bp3 && parse_bp3_part(part.found->filled).linear();
  for (const EdsField& field : fields_of(part.part)) {
    const auto value = known_value(*part.found, field);
    rows.push_back({.part = name_of(part.part),
                    .channel = part.channel,
                    .bank = part.found->bank,
                    .address = field.address,
                    .bytes = field.bytes,
                    .symbol = std::string(field.symbol),
                    .value = value,
                    .means = value ? eds_meaning(field, *value, linear) : std::string(),
                    .meaning = field.meaning,
                    .unused = is_unused(field, part.part, part.found->filled)});
  }
}

// Problems whose finding states the right value.
bool states_right_value(const EdsFinding& found) {
  using enum EdsProblem;
  constexpr EdsProblem always[] = {checksum,          little_endian, polynomial_full_form,
                                   identifier,        channel_count, encoder_type,
                                   length_reading,    alignment,     data_length_differs,
                                   polynomial_differs};
  constexpr EdsProblem if_known[] = {lengths, version, polynomial};
  const auto is_of = [&](const auto& problems) {
    return std::find(std::begin(problems), std::end(problems), found.problem) != std::end(problems);
  };
  return is_of(always) || (is_of(if_known) && found.expected != 0);
}

void add_incomplete(std::vector<EdsFindingRow>& rows, const EdsPartRow& part) {
  for (const EdsField& field : fields_of(part.part)) {
    if (known_value(*part.found, field)) continue;
    rows.push_back({.part = name_of(part.part),
                    .channel = part.channel,
                    .symbol = field.symbol,
                    .problem = "incomplete",
                    .text = "bytes are missing from the dump, so the part is not judged"});
    return;
  }
}

}  // namespace

std::vector<EdsPartRow> eds_parts(const dump::DataSheet& sheet) {
  std::vector<EdsPartRow> parts;
  if (sheet.common) parts.push_back({EdsPart::common, std::nullopt, &*sheet.common});
  EdsImage image;
  image.identifiers = sheet.identifiers;
  for (unsigned i = 0; i < max_channels; ++i) {
    if (!sheet.profiles[i]) continue;
    image.profiles[i] = &sheet.profiles[i]->filled;
    parts.push_back({profile_part(image, i), i, &*sheet.profiles[i]});
  }
  return parts;
}

std::string part_text(std::string_view part, std::optional<unsigned> channel) {
  return channel.value_or(0) == 0 ? std::string(part) : fmt::format("{} {}", part, *channel);
}

std::vector<EdsFieldRow> eds_fields(const dump::DataSheet& sheet) {
  std::vector<EdsFieldRow> rows;
  for (const EdsPartRow& part : eds_parts(sheet)) {
    part.part == EdsPart::raw ? add_raw(rows, part) : add_fields(rows, part);
  }
  return rows;
}

std::optional<std::uint32_t> known_value(const FoundPart& part, const EdsField& field) {
  for (unsigned i = 0; i < field.bytes; ++i) {
    if (!part.bytes[field.address + i]) return std::nullopt;
  }
  return field_value(part.filled, field);
}

bool is_unused(const EdsField& field, EdsPart part, const EdsBank& bank) {
  if (field.kind == EdsKind::reserved || field.kind == EdsKind::unnamed) return true;
  if (part != EdsPart::common || field.address < common_channel_address(0)) return false;
  const unsigned channel = (field.address - common_channel_address(0)) / 4U;
  return channel < max_channels && channel >= parse_common_part(bank).dc_num;
}

EdsFindingRow finding_row(const EdsFinding& found) {
  EdsFindingRow row{.part = name_of(found.part),
                    .symbol = found.symbol,
                    .problem = name_of(found.problem),
                    .value = found.value,
                    .against = found.against,
                    .certain = states_right_value(found),
                    .text = std::string(text_of(found.problem))};
  if (found.part != EdsPart::common) row.channel = found.channel;
  const bool contradicted = !found.against.empty() && found.problem != EdsProblem::lengths;
  if (row.certain || contradicted) row.expected = found.expected;
  return row;
}

std::string finding_line(const EdsFindingRow& row) {
  std::string out = fmt::format("{}: {}", row.symbol, row.text);
  if (!row.value) return out;
  out += fmt::format(" ({}", *row.value);
  if (row.expected) {
    out += row.certain ? fmt::format(", expected {}", *row.expected)
                       : fmt::format(", {} {}", row.against, *row.expected);
  }
  return out + ')';
}

std::vector<EdsFindingRow> eds_findings(const dump::DataSheet& sheet,
                                        const EdsCheckOptions& rules) {
  std::vector<EdsFindingRow> rows;
  for (const EdsPartRow& part : eds_parts(sheet)) {
    if (!part.found->whole) add_incomplete(rows, part);
  }
  const EdsImage image = sheet.image();
  check_eds(
      image, [&rows](const EdsFinding& found) { rows.push_back(finding_row(found)); }, rules);
  return rows;
}

}  // namespace biss::verbs
