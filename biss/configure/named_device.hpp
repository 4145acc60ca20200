// The device that a text names. All names, profiles and formats are looked up here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/base/result.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/eds/profile.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/safety/configurations.hpp"

namespace biss {

/// An encoder: the meaning of its bits, and its behaviour in time.
struct Device {
  FrameFormat format;
  /// The timing of the catalogue or of the safety configuration; without one, the widest limits
  /// that BiSS C allows.
  DeviceTiming timing;
  /// Null unless the text is a name of the catalogue. Lives as long as the program.
  const CatalogueEntry* entry = nullptr;
  /// Null unless the text is the name of a safety configuration and not a name of the catalogue.
  /// Lives as long as the program.
  const SafetyConfiguration* configuration = nullptr;

  /// Whether the text names a device with its own timing, not only the limits of BiSS C.
  constexpr bool timing_known() const {
    return entry != nullptr ||
           (configuration != nullptr && configuration->timing != DeviceTiming{});
  }
};

/// Why a text is not a device.
enum class DeviceMistake : std::uint8_t {
  item,           ///< of the grammar of formats: FormatTextError
  name,           ///< one word that is not a name
  identifier,     ///< no number after `bp3:`
  profile,        ///< the profile gives no format: ProfileError
  other_profile,  ///< neither BP3 nor BP3S
  no_position,    ///< the data length leaves no position
};

struct DeviceTextError {
  DeviceMistake mistake{};
  FormatTextError item{};
  ProfileError profile{};
  /// The profile identifier, if the text is a number.
  ProfileIdentifier identifier{};
};

/// The message for a user, without a full stop; it ends with a zero.
constexpr std::string_view text_of(const DeviceTextError& error) {
  switch (error.mistake) {
    case DeviceMistake::item:
      break;
    case DeviceMistake::name:
      return "no such name or item";
    case DeviceMistake::identifier:
      return "the identifier is a number like bp3:0x621E, at most 0xFFFF";
    case DeviceMistake::profile:
      return text_of(error.profile);
    case DeviceMistake::other_profile:
      return "this identifier is not of profile BP3 or BP3S";
    case DeviceMistake::no_position:
      return "the data length leaves no position";
  }
  return text_of(error.item.mistake);
}

namespace configure_detail {

inline constexpr std::string_view profile_prefix = "bp3:";

// Decimal, or hexadecimal after 0x; at most 0xFFFF.
constexpr Result<std::uint16_t, DeviceTextError> identifier_of(std::string_view digits) {
  const bool hexadecimal = digits.starts_with("0x") || digits.starts_with("0X");
  const std::uint32_t base = hexadecimal ? 16 : 10;
  std::uint32_t value = 0;
  std::size_t at = hexadecimal ? 2 : 0;
  bool good = at < digits.size();
  for (; good && at < digits.size(); ++at) {
    const std::uint32_t digit = frame_detail::digit_of(digits[at]);
    value = value * base + digit;
    good = digit < base && value <= UINT16_MAX;
  }
  if (!good) {
    return failure(DeviceTextError{.mistake = DeviceMistake::identifier,
                                   .item = {.at = profile_prefix.size()}});
  }
  return static_cast<std::uint16_t>(value);
}

constexpr Result<Device, DeviceTextError> device_of_profile(std::string_view digits) {
  // Not substr(): its range check would bring exceptions into firmware.
  digits.remove_prefix(profile_prefix.size());
  const auto identifier = identifier_of(digits);
  if (!identifier.ok()) return failure(identifier.error());
  DeviceTextError wrong{.identifier = {*identifier}};
  const auto format = profile_format(*identifier);
  const Profile profile = wrong.identifier.profile();
  if (!format.ok()) {
    wrong.mistake = DeviceMistake::profile;
    wrong.profile = format.error();
  } else if (profile != Profile::bp3 && profile != Profile::bp3s) {
    wrong.mistake = DeviceMistake::other_profile;
  } else if (format->channel_list[0].position_bits() == 0) {
    wrong.mistake = DeviceMistake::no_position;
  } else {
    return Device{*format, {}, nullptr, nullptr};
  }
  return failure(wrong);
}

}  // namespace configure_detail

/// Reads a profile identifier (`bp3:0x621E`), a name of the catalogue (`resolute-26`) or of a safety
/// configuration (`rsm`), or a format (`pos26,nE,nW,crc6`), in this order.
constexpr Result<Device, DeviceTextError> read_device(std::string_view text) {
  if (text.starts_with(configure_detail::profile_prefix)) {
    return configure_detail::device_of_profile(text);
  }
  if (const CatalogueEntry* entry = find_encoder(text)) {
    return Device{entry->frame_format(), entry->timing, entry, nullptr};
  }
  if (const SafetyConfiguration* known = find_safety_configuration(text)) {
    return Device{known->frame_format(), known->timing, nullptr, known};
  }
  const auto format = parse_format(text);
  if (format.ok()) return Device{*format, {}, nullptr, nullptr};
  const FormatTextError error = format.error();
  // One word without a separator is a name rather than the grammar.
  const bool is_name = error.mistake == FormatMistake::unknown_item && error.at == 0 &&
                       text.find_first_of(",+;") == std::string_view::npos;
  return failure(DeviceTextError{.mistake = is_name ? DeviceMistake::name : DeviceMistake::item,
                                 .item = error});
}

}  // namespace biss
