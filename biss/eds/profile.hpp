// Profile identifiers (registers 0x42 and 0x43): what an encoder says of its own frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/base/result.hpp"
#include "biss/frame/format.hpp"

namespace biss {

/// Why a profile identifier gives no format.
enum class ProfileError : std::uint8_t {
  none_given,       ///< 0x0000: the device has no profile
  unknown_profile,  ///< not BP3 (bits 15…12 are not 0110)
  version,          ///< BP3 in another version than 1
  reserved_bit,     ///< bit 7 is set
  crc_is_data,      ///< C = 1: the CRC travels as data, the identifier does not say which
  data_length,      ///< DL is not 2…57
};

inline constexpr std::size_t profile_error_count = 6;

/// What a user is told, without a full stop.
constexpr std::string_view text_of(ProfileError error) {
  constexpr std::array<std::string_view, profile_error_count> texts{
      "0x0000 means that the device has no profile",
      "only BP3 identifiers (0x6202 to 0x6239) give a format",
      "only version 1 of BP3 is known",
      "bit 7 must be 0",
      "C = 1, the CRC travels as data: write the format itself",
      "the data length must be 2 to 57 bits"};
  return texts[static_cast<std::size_t>(error)];
}

/// BP3's data length with C = 0: position and two flags. 57 data bits and 6 of CRC are the longest
/// word in which CRC6 finds every two wrong bits (BP3 Rev A3, table 6).
inline constexpr unsigned bp3_min_data_bits = 2;
inline constexpr unsigned bp3_max_data_bits = 57;

/// The frame of a device with this profile identifier, register 0x42 in the upper byte: for BP3
/// position, nE, nW and CRC6. How the position divides into turns is not in the identifier.
/// A length of 2, which the profile allows, gives a channel without a position.
constexpr Result<FrameFormat, ProfileError> profile_format(std::uint16_t identifier) {
  constexpr unsigned bp3 = 0b0110;
  if (identifier == 0) return failure(ProfileError::none_given);
  if (identifier >> 12U != bp3) return failure(ProfileError::unknown_profile);
  if (((identifier >> 9U) & 0b111U) != 1) return failure(ProfileError::version);
  if ((identifier & 0x80U) != 0) return failure(ProfileError::reserved_bit);
  if ((identifier & 0x100U) != 0) return failure(ProfileError::crc_is_data);
  const unsigned data_bits = identifier & 0x7FU;
  if (data_bits < bp3_min_data_bits || data_bits > bp3_max_data_bits) {
    return failure(ProfileError::data_length);
  }
  FrameFormat format;
  format.channel_count = 1;
  ChannelFormat& channel = format.channel_list[0];
  channel.data_bits = static_cast<std::uint8_t>(data_bits);
  if (data_bits > 2) channel.position = {2, static_cast<std::uint8_t>(data_bits - 2)};
  channel.error = {.shift = 1, .present = true};
  channel.warning = {.shift = 0, .present = true};
  channel.crc = crc6;
  return format;
}

}  // namespace biss
