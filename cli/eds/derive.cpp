#include "cli/eds/derive.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "biss/control/register_map.hpp"
#include "biss/eds/bp3_part.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/profile.hpp"

namespace biss::cli {
namespace {

constexpr unsigned default_eds_bank = 1;

const EdsField& common_field(std::string_view symbol) { return *find_field(common_fields, symbol); }
const EdsField& bp3_field(std::string_view symbol) { return *find_field(bp3_fields, symbol); }

void seal(PartInWork& part) { part.fill(bp3_field("CHKSUM"), eds_checksum(part.bank)); }

void fill_profile(PartInWork& part) {
  const Bp3Part usual;  // versions, feedback bits, polynomial as the profile has them
  part.fill(bp3_field("BP_VER"), usual.bp_ver);
  part.fill(bp3_field("BP_LEN"), usual.bp_len);
  part.fill(bp3_field("FB1"), usual.fb1);
  part.fill(bp3_field("FB2"), usual.fb2);
  part.fill(bp3_field("POS_NUM"), usual.pos_num);
  part.fill(bp3_field("CPOLY"), usual.cpoly);
  const unsigned length = parse_bp3_part(part.bank).position_bits() + 2;
  part.fill(bp3_field("BP_ID"), 0x6200U | (length & 0x7FU));
  seal(part);
}

std::size_t channels_of(const PartsInWork& parts) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < max_channels; ++i) {
    const bool mentioned =
        parts.common && std::any_of(parts.common->given.begin() + common_channel_address(i),
                                    parts.common->given.begin() + common_channel_address(i) + 4,
                                    [](bool given) { return given; });
    if (parts.profiles[i] || mentioned) count = i + 1;
  }
  return count;
}

void fill_channel(PartInWork& common, std::size_t i, unsigned eds_bank, const PartInWork& profile) {
  const auto& symbols = eds_detail::channel_symbols[i];
  const Bp3Part part = parse_bp3_part(profile.bank);
  common.fill(common_field(symbols[0]), (eds_bank + 1 + static_cast<unsigned>(i)) & 0xFFU);
  common.fill(common_field(symbols[1]), (part.position_bits() + 2) & 0xFFU);
  // A wider polynomial does not fit; 0 leaves it to the profile's part.
  common.fill(common_field(symbols[3]), part.cpoly <= 0xFF ? part.cpoly : 0);
}

unsigned last_bank(const PartsInWork& parts, unsigned eds_bank) {
  const CommonPart common = parse_common_part(parts.common->bank);
  unsigned last = eds_bank;
  for (std::size_t i = 0; i < max_channels; ++i) {
    if (parts.profiles[i]) last = std::max<unsigned>(last, common.channels[i].bank);
  }
  return last;
}

void fill_common(PartsInWork& parts, unsigned eds_bank) {
  PartInWork& common = *parts.common;
  common.fill(common_field("EDS_VER"), 1);
  common.fill(common_field("DC_NUM"), static_cast<std::uint32_t>(channels_of(parts)));
  common.fill(common_field("SL_NUM"), 1);
  for (std::size_t i = 0; i < max_channels; ++i) {
    if (parts.profiles[i]) fill_channel(common, i, eds_bank, *parts.profiles[i]);
  }
  common.fill(common_field("EDS_LEN"), (last_bank(parts, eds_bank) - eds_bank + 1) & 0xFFU);
  seal(common);
}

std::string put(PartsInWork& parts, unsigned bank, const PartInWork& part, std::string_view name) {
  if (parts.dump.known_bytes(bank) != 0) {
    return fmt::format("{} belongs in bank {}, which is given otherwise", name, bank);
  }
  parts.dump.set_bank(bank, part.bank);
  return {};
}

void fill_register(PartsInWork& parts, unsigned address, std::uint32_t value) {
  auto& place = parts.dump.at(0, address);
  if (!place) place = static_cast<std::uint8_t>(value);
}

// What the lengths make of it, so that a BP_ID that was given wrong is not borne out by a copy.
std::uint32_t identifier_due(const Bp3Part& part) {
  const ProfileIdentifier given{part.bp_id};
  const unsigned length = part.position_bits() + 2;
  if (given.profile() != Profile::bp3) return 0x6200U | (length & 0x7FU);
  const unsigned crc_bits = given.crc_is_data() ? crc6.width_bits : 0U;
  return (given.raw & 0xFF80U) | ((length + crc_bits) & 0x7FU);
}

// The registers that lead to the data sheet.
void fill_registers(PartsInWork& parts, unsigned eds_bank) {
  fill_register(parts, reg::eds_bank, eds_bank);
  const std::size_t own = parse_common_part(parts.common->bank).sl_off;
  if (own >= max_channels || !parts.profiles[own]) return;
  const std::uint32_t identifier = identifier_due(parse_bp3_part(parts.profiles[own]->bank));
  const bool any = parts.dump.direct_byte(reg::bp_id) || parts.dump.direct_byte(reg::bp_id + 1);
  if (any) return;
  fill_register(parts, reg::bp_id, identifier >> 8U);
  fill_register(parts, reg::bp_id + 1, identifier & 0xFFU);
}

}  // namespace

void PartInWork::set(const EdsField& field, std::uint32_t value) {
  static_cast<void>(set_field(bank, field, value));
  std::fill_n(given.begin() + field.address, field.bytes, true);
}

bool PartInWork::fill(const EdsField& field, std::uint32_t value) {
  if (given[field.address]) return false;
  return set_field(bank, field, value);
}

std::string fill_in(PartsInWork& parts) {
  for (auto& profile : parts.profiles) {
    if (profile) fill_profile(*profile);
  }
  CommonPart common;
  if (parts.common) {
    const unsigned eds_bank = parts.dump.direct_byte(reg::eds_bank).value_or(default_eds_bank);
    fill_common(parts, eds_bank);
    fill_registers(parts, eds_bank);
    common = parse_common_part(parts.common->bank);
    std::string error = put(parts, eds_bank, *parts.common, "[common]");
    if (!error.empty()) return error;
  }
  for (std::size_t i = 0; i < max_channels; ++i) {
    if (!parts.profiles[i]) continue;
    const unsigned bank = parts.common ? common.channels[i].bank : static_cast<unsigned>(i);
    std::string error = put(parts, bank, *parts.profiles[i], fmt::format("[bp3 {}]", i));
    if (!error.empty()) return error;
  }
  return {};
}

}  // namespace biss::cli
