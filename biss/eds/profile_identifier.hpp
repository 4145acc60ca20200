// The bits of a profile identifier, registers 0x42 (upper byte) and 0x43.
//
//   BP0   000 LLLLL | A aaaaaaa    L data length, A = 1 actuator, a the application's
//   BP1   001 ..... | ........     division not known
//   BP3   0110 VVV C | 0 DDDDDDD   V version, C, D = DL
//   BP3S  0111 VVV C | 0 DDDDDDD   by the same shape (NXP's driver; the document was not available)
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace biss {

enum class Profile : std::uint8_t { none, bp0, bp1, bp3, bp3s, unknown };

/// "BP3", …; "none" for 0x0000.
constexpr std::string_view name_of(Profile profile) {
  constexpr std::array<std::string_view, 6> names{"none", "BP0", "BP1", "BP3", "BP3S", "unknown"};
  return names[static_cast<std::size_t>(profile)];
}

/// An identifier, taken apart. What a member means depends on profile().
struct ProfileIdentifier {
  std::uint16_t raw = 0;

  constexpr bool operator==(const ProfileIdentifier&) const = default;

  constexpr Profile profile() const {
    if (raw == 0) return Profile::none;
    switch (raw >> 12U) {
      case 0b0000:
      case 0b0001:
        return Profile::bp0;
      case 0b0010:
      case 0b0011:
        return Profile::bp1;
      case 0b0110:
        return Profile::bp3;
      case 0b0111:
        return Profile::bp3s;
      default:
        return Profile::unknown;
    }
  }
  /// BP3, BP3S: 1 is the only one known.
  constexpr unsigned version() const { return (raw >> 9U) & 0b111U; }
  /// BP3, BP3S: bit C, the CRC's bits are data to the master, which does not check them.
  constexpr bool crc_is_data() const { return (raw & 0x100U) != 0; }
  constexpr bool bit7() const { return (raw & 0x80U) != 0; }
  /// BP0: data bits, 0 = no channel. BP3, BP3S: DL.
  constexpr unsigned data_length() const {
    return profile() == Profile::bp0 ? (raw >> 8U) & 0x1FU : raw & 0x7FU;
  }
  /// BP0: data go to the device.
  constexpr bool actuator() const { return bit7(); }
  /// BP0: the application's number.
  constexpr unsigned application() const { return raw & 0x7FU; }
};

/// Whether this reads as a BP3 identifier with its two bytes the wrong way round. It would be one
/// of BP0's or BP1's otherwise; those with 0x62 or 0x63 in their low byte are not known to exist.
constexpr bool is_swapped_bp3(std::uint16_t raw) {
  const unsigned length = raw >> 8U;
  return (raw & 0xFEU) == 0x62 && length >= 2 && length <= 63;
}

/// A BP1 identifier whose frame a source gives: position, nE, nW and CRC6.
struct Bp1Seen {
  std::uint16_t identifier = 0;
  std::uint8_t position_bits = 0;
};

/// Lika's manual of the SMA1 ("variant 0-24"), and the capture of an iC-MH in iC-Haus' application
/// note AN22. Two examples do not tell how the identifier divides.
inline constexpr std::array<Bp1Seen, 2> bp1_seen{{{0x2814, 24}, {0x2C0C, 12}}};

/// Why a format made from this identifier is not beyond doubt, without a full stop; empty for BP3
/// with C = 0.
constexpr std::string_view doubt_of(ProfileIdentifier id) {
  switch (id.profile()) {
    case Profile::bp0:
      return "BP0 does not say what its bits mean: carried as padding";
    case Profile::bp1:
      return "BP1: seen on one device, the identifier's division is not known";
    case Profile::bp3:
      return id.crc_is_data()
                 ? "C = 1: that DL counts the 6 CRC bits is deduced, the master does not check them"
                 : std::string_view{};
    case Profile::bp3s:
      return "BP3S: the document was not available, the identifier's division is BP3's";
    default:
      return {};
  }
}

}  // namespace biss
