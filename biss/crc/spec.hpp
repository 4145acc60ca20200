// CRC as data: polynomial, width, start value, inversion.
#pragma once

#include <bit>
#include <cstdint>

#include "biss/base/language.hpp"

namespace biss {

/// A checksum of a BiSS word. The polynomial is always in full form, top and bottom bit included
/// (0x43 = x^6 + x + 1). A `width_bits` of 0 means no checksum.
struct CrcSpec {
  std::uint32_t polynomial = 0;
  std::uint16_t start = 0;
  std::uint8_t width_bits = 0;
  /// Sent with every bit inverted, as BiSS does (protocol description D2).
  bool inverted : 1 = true;
  /// Deviations of some encoders: the lowest bit is sent first; nE and nW are left out; CDS is
  /// covered too, before the data; the CRC belongs to the previous frame. The engines ignore them;
  /// FrameCodec::crc() applies all except the last one.
  bool reversed : 1 = false;
  bool without_flags : 1 = false;
  bool with_cds : 1 = false;
  bool of_previous : 1 = false;

  constexpr bool operator==(const CrcSpec&) const = default;
  constexpr bool present() const { return width_bits != 0; }
  /// The checksum has an error of the encoder's maker.
  constexpr bool deviates() const { return reversed || without_flags || with_cds || of_previous; }
  constexpr std::uint16_t mask() const {
    return static_cast<std::uint16_t>((std::uint32_t{1} << width_bits) - 1U);
  }
};

inline constexpr unsigned min_crc_bits = 3;
inline constexpr unsigned max_crc_bits = 16;
inline constexpr unsigned max_data_bits = 64;

/// Full-form polynomial of `width_bits`: highest term x^width, constant term 1.
constexpr bool is_full_form(std::uint32_t polynomial, unsigned width_bits) {
  return static_cast<unsigned>(std::bit_width(polynomial)) == width_bits + 1U &&
         (polynomial & 1U) != 0;
}

/// The polynomial a BiSS master uses when only the width is given; 0 if there is none. Widths 3 to
/// 8 and 16: Microchip's description of the iC-Haus master core; 0x43 and 0x190D9 also Renishaw's
/// data sheets.
constexpr std::uint32_t default_polynomial(unsigned width_bits) {
  switch (width_bits) {
    case 3:
      return 0x0B;
    case 4:
      return 0x13;
    case 5:
      return 0x25;
    case 6:
      return 0x43;
    case 7:
      return 0x89;
    case 8:
      return 0x12F;
    case 16:
      return 0x190D9;
    default:
      return 0;
  }
}

/// CRC6 of a control position word: Renishaw "BiSS C-mode (unidirectional)", "CRC for position
/// data".
inline constexpr CrcSpec crc6{.polynomial = 0x43, .start = 0, .width_bits = 6, .inverted = true};
/// CRC16 of a safety position word: Renishaw "BiSS Safety", "CRC for position data".
inline constexpr CrcSpec crc16{
    .polynomial = 0x190D9, .start = 0, .width_bits = 16, .inverted = true};

}  // namespace biss
