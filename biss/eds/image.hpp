// EdsImage: the parts of a device's data sheet that were read.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "biss/eds/bank.hpp"
#include "biss/eds/bp3_part.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/field.hpp"
#include "biss/eds/profile.hpp"
#include "biss/frame/format.hpp"

namespace biss {

/// The table of a part; empty for EdsPart::raw.
constexpr std::span<const EdsField> fields_of(EdsPart part) {
  if (part == EdsPart::common) return common_fields;
  if (part == EdsPart::bp3) return bp3_fields;
  return {};
}

/// The banks of one data sheet, in memory that the caller owns and that must outlive the image.
/// Parts that were not read are null or empty; every function that takes an image works with the
/// parts that are present.
struct EdsImage {
  const EdsBank* common = nullptr;
  /// The profile's part of data channel i, from bank BANK_i.
  std::array<const EdsBank*, max_channels> profiles{};
  /// Registers 0x42 (upper byte) and 0x43 of the slave that sends data channel i.
  std::array<std::optional<std::uint16_t>, max_channels> identifiers{};
  /// Register 0x41: the bank of the common part.
  std::optional<std::uint8_t> eds_bank{};
};

/// How to read the profile's part of a channel: with BP3's layout, unless registers or bank name a
/// profile whose layout is unknown and neither names BP3. \pre the bank was read
constexpr EdsPart profile_part(const EdsImage& image, std::size_t channel) {
  const EdsBank& bank = *image.profiles[channel];
  const auto stored = static_cast<std::uint16_t>(bank[2] << 8U | bank[3]);
  const auto stated = image.identifiers[channel].value_or(stored);
  if (is_swapped_bp3(stored)) return EdsPart::bp3;
  bool raw = false;
  for (const std::uint16_t identifier : {stored, stated}) {
    const Profile profile = ProfileIdentifier{identifier}.profile();
    if (profile == Profile::bp3) return EdsPart::bp3;
    raw = raw || profile == Profile::bp1 || profile == Profile::bp3s;
  }
  return raw ? EdsPart::raw : EdsPart::bp3;
}

/// The number of data channels: DC_NUM, at most 8; without common part, up to the last channel of
/// which anything was read.
constexpr std::size_t channel_count(const EdsImage& image) {
  if (image.common != nullptr) {
    const std::size_t stated = parse_common_part(*image.common).dc_num;
    return stated < max_channels ? stated : max_channels;
  }
  std::size_t count = 0;
  for (std::size_t i = 0; i < max_channels; ++i) {
    if (image.profiles[i] != nullptr || image.identifiers[i].has_value()) count = i + 1;
  }
  return count;
}

}  // namespace biss
