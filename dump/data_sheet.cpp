#include "dump/data_sheet.hpp"

#include <algorithm>

#include "biss/control/register_map.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/profile.hpp"

namespace biss::dump {
namespace {

// A profile part begins with version, length and identifier. EDS_VER, EDS_LEN and two user banks
// could have the same values; no known data sheet has its user area there.
bool may_be_profile(const EdsBank& bank) {
  const ProfileIdentifier id{static_cast<std::uint16_t>(bank[2] << 8U | bank[3])};
  const bool shaped = id.profile() == Profile::bp3 || id.profile() == Profile::bp3s;
  return bank[0] == 1 && bank[1] == 1 && shaped;
}

bool may_be_common(const RegisterDump& dump, unsigned number) {
  const auto bank = dump.whole_bank(number);
  if (!bank || is_filled_with(*bank, 0x00) || is_filled_with(*bank, 0xFF)) return false;
  const CommonPart part = parse_common_part(*bank);
  return part.chksum == eds_checksum(*bank) && part.eds_ver != 0 && part.eds_len != 0 &&
         part.dc_num <= max_channels && !may_be_profile(*bank);
}

FoundPart part_in(const RegisterDump& dump, unsigned number) {
  FoundPart part;
  part.bank = static_cast<std::uint8_t>(number);
  part.bytes = dump.bank(number);
  part.whole = dump.known_bytes(number) == bank_bytes;
  for (std::size_t i = 0; i < bank_bytes; ++i) part.filled[i] = part.bytes[i].value_or(0);
  return part;
}

// The bank of the common part, if registers, options or contents show it.
std::optional<unsigned> common_bank(const RegisterDump& dump, const FindOptions& options) {
  if (options.eds_bank) return options.eds_bank;
  if (const auto stated = dump.direct_byte(reg::eds_bank)) {
    if (eds_presence(*stated) == EdsPresence::present) return stated;
    // 0xFF is a bank, or means that there is none (iC-MU).
    if (*stated == 0 || !may_be_common(dump, *stated)) return std::nullopt;
    return stated;
  }
  for (unsigned number = 0; number < bank_count; ++number) {
    if (may_be_common(dump, number)) return number;
  }
  return std::nullopt;
}

}  // namespace

bool DataSheet::empty() const {
  return !common && std::none_of(profiles.begin(), profiles.end(),
                                 [](const auto& part) { return part.has_value(); });
}

EdsImage DataSheet::image() const {
  EdsImage image;
  if (common && common->whole) image.common = &common->filled;
  for (std::size_t i = 0; i < max_channels; ++i) {
    if (profiles[i] && profiles[i]->whole) image.profiles[i] = &profiles[i]->filled;
  }
  image.identifiers = identifiers;
  image.eds_bank = eds_bank;
  return image;
}

DataSheet find_data_sheet(const RegisterDump& dump, const FindOptions& options) {
  DataSheet sheet;
  auto identifier = options.identifier;
  if (const auto stated = dump.direct_number(reg::bp_id, 2); !identifier && stated) {
    identifier = static_cast<std::uint16_t>(*stated);
  }
  std::size_t own_channel = 0;
  const auto range = dump.banks();
  if (const auto number = common_bank(dump, options); number && dump.known_bytes(*number) != 0) {
    sheet.common = part_in(dump, *number);
    sheet.eds_bank = sheet.common->bank;
    const CommonPart part = parse_common_part(sheet.common->filled);
    for (std::size_t i = 0; i < std::min<std::size_t>(part.dc_num, max_channels); ++i) {
      const unsigned bank = part.channels[i].bank;
      if (bank == *number || dump.known_bytes(bank) == 0) continue;
      sheet.profiles[i] = part_in(dump, bank);
    }
    if (part.sl_off < max_channels) own_channel = part.sl_off;
  } else if (!dump.direct_byte(reg::eds_bank) && !options.eds_bank && range &&
             range->first == range->last) {
    // A single bank without a hint at its kind; its checksum may be wrong.
    const FoundPart lone = part_in(dump, range->first);
    (may_be_profile(lone.filled) ? sheet.profiles[0] : sheet.common) = lone;
  }
  if (identifier && *identifier != 0) sheet.identifiers[own_channel] = identifier;
  return sheet;
}

}  // namespace biss::dump
