// Profile identifiers (registers 0x42 and 0x43), in which an encoder describes its frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/base/result.hpp"
#include "biss/frame/format.hpp"

namespace biss {

// ---- The bits of an identifier, register 0x42 in the upper byte
//
//   BP0   000 LLLLL | A aaaaaaa    L data length, A = 1 actuator, a application
//   BP1   001 ..... | ........     division unknown
//   BP3   0110 VVV C | 0 DDDDDDD   V version, C, D = DL
//   BP3S  0111 VVV C | 0 DDDDDDD   by analogy (NXP's driver; the document was not available)

enum class Profile : std::uint8_t { none, bp0, bp1, bp3, bp3s, unknown };

/// "BP3", …; "none" for 0x0000.
constexpr std::string_view name_of(Profile profile) {
  constexpr std::array<std::string_view, 6> names{"none", "BP0", "BP1", "BP3", "BP3S", "unknown"};
  return names[static_cast<std::size_t>(profile)];
}

/// The parts of an identifier. Their meaning depends on profile().
struct ProfileIdentifier {
  std::uint16_t raw = 0;

  constexpr bool operator==(const ProfileIdentifier&) const = default;

  constexpr Profile profile() const {
    using enum Profile;
    if (raw == 0) return none;
    constexpr Profile by_upper_bits[] = {bp0, bp0, bp1, bp1, unknown, unknown, bp3, bp3s};
    return raw < 0x8000 ? by_upper_bits[raw >> 12U] : unknown;
  }
  /// BP3, BP3S: only version 1 is known.
  constexpr unsigned version() const { return (raw >> 9U) & 0b111U; }
  /// BP3, BP3S: bit C; the bus master passes the CRC on with the data, and the user of the position
  /// checks it. Mandatory within a safety encoder (BP3 Rev A3, table 5).
  constexpr bool crc_is_data() const { return (raw & 0x100U) != 0; }
  constexpr bool bit7() const { return (raw & 0x80U) != 0; }
  /// BP0: data bits, 0 = no channel. BP3, BP3S: DL.
  constexpr unsigned data_length() const {
    return profile() == Profile::bp0 ? (raw >> 8U) & 0x1FU : raw & 0x7FU;
  }
  /// BP3, BP3S: the same identifier with another DL.
  constexpr ProfileIdentifier with_length(unsigned length) const {
    return {static_cast<std::uint16_t>((raw & 0xFF80U) | (length & 0x7FU))};
  }
  /// BP0: the data go to the device.
  constexpr bool actuator() const { return bit7(); }
};

/// Whether this is a BP3 identifier with its two bytes swapped. Otherwise it would be an identifier
/// of BP0 or BP1; none of these with 0x62 or 0x63 in the low byte is known.
constexpr bool is_swapped_bp3(std::uint16_t raw) {
  const unsigned length = raw >> 8U;
  return (raw & 0xFEU) == 0x62 && length >= 2 && length <= 63;
}

/// A BP1 identifier whose frame is known from a source: position, nE, nW and CRC6.
struct Bp1Seen {
  std::uint16_t identifier = 0;
  std::uint8_t position_bits = 0;
};

/// Lika's manual of the SMA1 ("variant 0-24"), and the capture of an iC-MH in iC-Haus' application
/// note AN22. Two examples do not show how the identifier is divided.
inline constexpr std::array<Bp1Seen, 2> bp1_seen{{{0x2814, 24}, {0x2C0C, 12}}};

/// Why a format derived from this identifier is not certain, without a full stop; empty for BP3
/// with C = 0.
constexpr std::string_view doubt_of(ProfileIdentifier id) {
  switch (id.profile()) {
    case Profile::bp0:
      return "BP0 does not define its bits: carried as padding";
    case Profile::bp1:
      return "BP1: seen on one device, the identifier's division is not known";
    case Profile::bp3:
      return id.crc_is_data() ? "C = 1: that DL counts the CRC is deduced (BP3, table 5); table 6 "
                                "says \"without CRC\""
                              : std::string_view{};
    case Profile::bp3s:
      return "BP3S: the document was not available; BP3's identifier is assumed, and a DL that "
             "counts nE, nW, 6 bits of sign of life and, with C = 1, CRC16";
    default:
      return {};
  }
}

/// Why a profile identifier gives no format, or a format no identifier.
enum class ProfileError : std::uint8_t {
  none_given,        ///< 0x0000: the device has no profile
  unknown_profile,   ///< not BP0, BP1, BP3 or BP3S
  bp1_layout,        ///< BP1: how its identifier divides was not found
  version,           ///< BP3 or BP3S in another version than 1
  reserved_bit,      ///< bit 7 is set
  data_length,       ///< BP3: DL is not 2…57, with C = 1 not 2…63; BP3S: longer than an SPW
  crc_does_not_fit,  ///< C = 1 and DL too short for flags and CRC
  no_channel,        ///< BP0 without data channel
  actuator,          ///< BP0, data to the device and not from it
  other_bits,        ///< a format whose bits differ from the profile
};

inline constexpr std::size_t profile_error_count = 10;

/// The message for a user, without a full stop.
constexpr std::string_view text_of(ProfileError error) {
  constexpr std::array<std::string_view, profile_error_count> texts{
      "0x0000 means that the device has no profile",
      "only the profiles BP0, BP1, BP3 and BP3S are known",
      "BP1: how its identifier divides is not known; write the format itself",
      "only version 1 of BP3 and BP3S is known",
      "bit 7 must be 0",
      "no such data length in this profile",
      "the data length leaves no room for the flags and the CRC",
      "BP0 with length 0: the device has no data channel",
      "BP0 actuator: it sends no data of its own",
      "the profile has other bits than this format"};
  return texts[static_cast<std::size_t>(error)];
}

/// Options for facts that the documents leave open.
struct ProfileOptions {
  /// C = 1: whether DL counts the CRC's bits. BP3's table 5 says that they are added to the data
  /// length, and 63 is 57 plus 6; table 6 says "data length without CRC". Assumed for BP3S, too.
  bool length_counts_crc = true;
  /// The CRC, if a source other than the identifier states it; otherwise the CRC of the profile.
  CrcSpec crc{};
};

/// BP3's data length with C = 0: position and two flags. 57 data bits and 6 of CRC are the longest
/// word in which CRC6 detects every two wrong bits (BP3 Rev A3, table 6; the EDS row that begins at
/// 1 contradicts it).
inline constexpr unsigned bp3_min_data_bits = 2;
inline constexpr unsigned bp3_max_data_bits = 57;
/// The longest DL with C = 1.
inline constexpr unsigned bp3_max_length_crc_is_data = 63;
/// The longest safety position word, its CRC included (SC-A5).
inline constexpr unsigned max_spw_bits = 64;

// ---- Assumptions about BP3S, whose document was not available: its identifier is divided like
// BP3's (NXP's driver), and DL counts position, nE, nW, the sign-of-life counter and, with C = 1, the
// CRC, as they are on the line (Safety Concept A5).

/// The sign-of-life counter of the safety position word.
inline constexpr unsigned bp3s_counter_bits = safety_counter_bits;
/// The CRC of the safety position word: 0x190D9, start value 0 (Safety Concept A5).
inline constexpr CrcSpec bp3s_crc = crc16;

/// BP0 (NXP's driver, the association's list of profiles).
inline constexpr CrcSpec bp0_crc{.polynomial = 0x25, .width_bits = 5};

namespace eds_detail {

// nE and nW, and below them `counter` bits of counter.
constexpr ChannelFormat position_channel(unsigned position_bits, unsigned counter,
                                         const CrcSpec& crc) {
  const auto byte = [](unsigned value) { return static_cast<std::uint8_t>(value); };
  ChannelFormat channel;
  channel.data_bits = byte(position_bits + 2 + counter);
  if (position_bits != 0) channel.position = {byte(counter + 2), byte(position_bits)};
  channel.error = {.shift = byte(counter + 1), .present = true};
  channel.warning = {.shift = byte(counter), .present = true};
  if (counter != 0) channel.life_counter = {0, byte(counter)};
  channel.crc = crc;
  return channel;
}

constexpr CrcSpec stated_or(const ProfileOptions& options, const CrcSpec& of_profile) {
  return options.crc.present() ? options.crc : of_profile;
}

// BP3 and BP3S have one shape and differ in counter and CRC.
constexpr Result<ChannelFormat, ProfileError> standard_channel(ProfileIdentifier id,
                                                               const ProfileOptions& options) {
  const bool safety = id.profile() == Profile::bp3s;
  const CrcSpec crc = stated_or(options, safety ? bp3s_crc : crc6);
  const unsigned counter = safety ? bp3s_counter_bits : 0;
  if (id.version() != 1) return failure(ProfileError::version);
  if (id.bit7()) return failure(ProfileError::reserved_bit);
  const bool counted = id.crc_is_data() && options.length_counts_crc;
  const unsigned most = !safety ? (counted ? bp3_max_length_crc_is_data : bp3_max_data_bits)
                                : max_spw_bits - (counted ? 0U : crc.width_bits);
  const unsigned length = id.data_length();
  if (length < bp3_min_data_bits || length > most) return failure(ProfileError::data_length);
  const unsigned around = 2 + counter + (counted ? crc.width_bits : 0U);
  if (length < around) return failure(ProfileError::crc_does_not_fit);
  return position_channel(length - around, counter, crc);
}

constexpr Result<ChannelFormat, ProfileError> universal_channel(ProfileIdentifier id,
                                                                const ProfileOptions& options) {
  if (id.data_length() == 0) return failure(ProfileError::no_channel);
  if (id.actuator()) return failure(ProfileError::actuator);
  ChannelFormat channel;
  channel.data_bits = static_cast<std::uint8_t>(id.data_length());
  channel.crc = stated_or(options, bp0_crc);
  return channel;
}

constexpr Result<ChannelFormat, ProfileError> bp1_channel(ProfileIdentifier id,
                                                          const ProfileOptions& options) {
  for (const Bp1Seen& seen : bp1_seen) {
    if (seen.identifier == id.raw) {
      return position_channel(seen.position_bits, 0, stated_or(options, crc6));
    }
  }
  return failure(ProfileError::bp1_layout);
}

// The position as one run of bits, whether or not it is divided.
constexpr Field whole_position(const ChannelFormat& channel) {
  if (channel.position.present()) return channel.position;
  const Field& low = channel.singleturn.present() ? channel.singleturn : channel.multiturn;
  const bool joined = !channel.multiturn.present() || !channel.singleturn.present() ||
                      channel.multiturn.shift == low.shift + low.bits;
  if (!joined || channel.coded()) return {};
  return {low.shift, static_cast<std::uint8_t>(channel.position_bits())};
}

constexpr bool same_bits(const ChannelFormat& a, const ChannelFormat& b) {
  return a.data_bits == b.data_bits && whole_position(a) == whole_position(b) &&
         a.error == b.error && a.warning == b.warning && a.life_counter == b.life_counter &&
         a.crc == b.crc;
}

}  // namespace eds_detail

/// The data channel of a device with this identifier, register 0x42 in the upper byte. The
/// identifier does not contain the division of the position into turns. BP0's data are padding: the
/// application defines its bits. doubt_of() names the assumptions if the source is not a
/// document.
constexpr Result<ChannelFormat, ProfileError> profile_channel(std::uint16_t identifier,
                                                              const ProfileOptions& options = {}) {
  const ProfileIdentifier id{identifier};
  switch (id.profile()) {
    case Profile::none:
      return failure(ProfileError::none_given);
    case Profile::bp0:
      return eds_detail::universal_channel(id, options);
    case Profile::bp1:
      return eds_detail::bp1_channel(id, options);
    case Profile::bp3:
    case Profile::bp3s:
      return eds_detail::standard_channel(id, options);
    case Profile::unknown:
      break;
  }
  return failure(ProfileError::unknown_profile);
}

/// The frame of a device that sends only this channel. A length of 2, which BP3 allows, gives a
/// channel without a position.
constexpr Result<FrameFormat, ProfileError> profile_format(std::uint16_t identifier,
                                                           const ProfileOptions& options = {}) {
  const auto channel = profile_channel(identifier, options);
  if (!channel.ok()) return failure(channel.error());
  FrameFormat format;
  format.channel_count = 1;
  format.channel_list[0] = *channel;
  return format;
}

/// The identifier of a BP3 or BP3S device that sends this channel; with `crc_is_data` the one with
/// C = 1. Adjacent turns and singleturn count as one position. ProfileError::unknown_profile for
/// another profile.
constexpr Result<std::uint16_t, ProfileError> profile_identifier(const ChannelFormat& channel,
                                                                 Profile profile,
                                                                 bool crc_is_data) {
  if (profile != Profile::bp3 && profile != Profile::bp3s) {
    return failure(ProfileError::unknown_profile);
  }
  const unsigned width = profile == Profile::bp3s ? bp3s_crc.width_bits : crc6.width_bits;
  unsigned length = channel.data_bits;
  if (crc_is_data) length += width;
  const unsigned kind = profile == Profile::bp3 ? 0x6200U : 0x7200U;
  if (length > 0x7F) return failure(ProfileError::data_length);
  const auto identifier = static_cast<std::uint16_t>(kind | (crc_is_data ? 0x100U : 0U) | length);
  const auto expected = profile_channel(identifier);
  if (!expected.ok()) return failure(expected.error());
  if (!eds_detail::same_bits(*expected, channel)) return failure(ProfileError::other_bits);
  return identifier;
}

}  // namespace biss
