#include "cli/eds/entries.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "biss/eds/image.hpp"
#include "cli/eds/value.hpp"

namespace biss::cli {
namespace {

using dump::FoundPart;

void add_raw(std::vector<EdsEntry>& entries, const EdsPartEntry& part) {
  for (unsigned i = 0; i < eds_bank_bytes; ++i) {
    const auto& byte = part.found->bytes[i];
    EdsEntry entry;
    entry.part = name_of(EdsPart::raw);
    entry.channel = part.channel;
    entry.bank = part.found->bank;
    entry.address = i;
    entry.symbol = fmt::format("0x{:02X}", i);
    if (byte) entry.value = *byte;
    entry.unused = !byte || *byte == 0;
    entries.push_back(std::move(entry));
  }
}

bool is_unused(const EdsField& field, const EdsPartEntry& part) {
  if (field.kind == EdsKind::reserved || field.kind == EdsKind::unnamed) return true;
  if (part.part != EdsPart::common || field.address < common_channel_address(0)) return false;
  const unsigned channel = (field.address - common_channel_address(0)) / 4U;
  return channel < max_channels && channel >= parse_common_part(part.found->filled).dc_num;
}

void add_fields(std::vector<EdsEntry>& entries, const EdsPartEntry& part) {
  const bool linear = part.part == EdsPart::bp3 && parse_bp3_part(part.found->filled).linear();
  for (const EdsField& field : fields_of(part.part)) {
    const auto value = known_value(*part.found, field);
    entries.push_back({.part = name_of(part.part),
                       .channel = part.channel,
                       .bank = part.found->bank,
                       .address = field.address,
                       .symbol = std::string(field.symbol),
                       .value = value,
                       .means = value ? eds_meaning(field, *value, linear) : std::string(),
                       .meaning = field.meaning,
                       .unused = is_unused(field, part)});
  }
}

}  // namespace

std::optional<std::uint32_t> known_value(const FoundPart& part, const EdsField& field) {
  for (unsigned i = 0; i < field.bytes; ++i) {
    if (!part.bytes[field.address + i]) return std::nullopt;
  }
  return field_value(part.filled, field);
}

std::vector<EdsPartEntry> eds_parts(const dump::DataSheet& sheet) {
  std::vector<EdsPartEntry> parts;
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

std::vector<EdsEntry> eds_entries(const dump::DataSheet& sheet) {
  std::vector<EdsEntry> entries;
  for (const EdsPartEntry& part : eds_parts(sheet)) {
    if (part.part == EdsPart::raw) {
      add_raw(entries, part);
    } else {
      add_fields(entries, part);
    }
  }
  return entries;
}

}  // namespace biss::cli
