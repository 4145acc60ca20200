// EdsField: one row of a part's table, by which tools print, check and build a bank.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "biss/base/bits.hpp"
#include "biss/crc/spec.hpp"
#include "biss/eds/bank.hpp"

namespace biss {

/// The parts of a data sheet; `raw` is the part of a profile whose layout is unknown.
enum class EdsPart : std::uint8_t { common, bp3, raw };

/// The name that scripts see: "common", "bp3", "raw".
constexpr std::string_view name_of(EdsPart part) {
  constexpr std::array<std::string_view, 3> names{"common", "bp3", "raw"};
  return names[static_cast<std::size_t>(part)];
}

/// The unit of a value. Units with two names depend on EN_TYP: first rotary, then linear.
enum class EdsUnit : std::uint8_t {
  none,
  banks,
  bank_number,
  bits,
  clocks,     ///< of MA
  time_step,  ///< of its own: biss/eds/common_part.hpp
  milliseconds,
  per_revolution_or_nanometre,  ///< signal periods a revolution; length of a signal period
  lsb,
  half_lsb_or_micrometre,
  half_lsb,
  per_minute_or_metre_per_minute,
  per_minute2_or_metre_per_minute2,  ///< printed as 1/min² and m/min²
  kelvin,
  millivolt,
  milliampere,
};

/// The unit as text; empty for a bare number, "step" if eds_scales has the factor.
constexpr std::string_view text_of(EdsUnit unit, bool linear) {
  // Rotary, linear.
  constexpr std::string_view texts[][2] = {{"", ""},
                                           {"banks", "banks"},
                                           {"", ""},
                                           {"bit", "bit"},
                                           {"clocks", "clocks"},
                                           {"step", "step"},
                                           {"ms", "ms"},
                                           {"PPR", "nm"},
                                           {"LSB", "LSB"},
                                           {"LSB/2", "um"},
                                           {"LSB/2", "LSB/2"},
                                           {"1/min", "m/min"},
                                           {"1/min2", "m/min2"},
                                           {"K", "K"},
                                           {"mV", "mV"},
                                           {"mA", "mA"}};
  return texts[static_cast<std::size_t>(unit)][linear ? 1 : 0];
}

/// The interpretation of a value.
enum class EdsKind : std::uint8_t {
  number,
  feedback,        ///< table B: 0 no function, 1 nE, 2 nW
  encoder_type,    ///< table T: 0 rotary, 1 linear
  position_value,  ///< table N: 0 undefined, 1 or 2
  alignment,       ///< table F: 0 right, 1 left
  // The others are not numbers: people see them in hexadecimal.
  identifier,      ///< the profile identifier, registers 0x42 and 0x43
  polynomial,      ///< without its lowest bit, which is always 1: 0x21 means 0x43
  channel_format,  ///< FORMAT_i's bits
  bus_coupler,     ///< bit 4: there is one, bits 3…0: its slave
  checksum,
  reserved,  ///< the documents reserve it
  unnamed,   ///< no source names it
};

/// The name of a value from a table (kinds feedback to alignment); empty if it has none.
constexpr std::string_view name_of(EdsKind kind, std::uint32_t value) {
  constexpr std::string_view names[][3] = {{"no function", "nE", "nW"},
                                           {"rotary", "linear"},
                                           {"undefined", "position 1", "position 2"},
                                           {"right", "left"}};
  if (kind < EdsKind::feedback || kind > EdsKind::alignment || value > 2) return {};
  return names[static_cast<std::size_t>(kind) - static_cast<std::size_t>(EdsKind::feedback)][value];
}

/// One field of a part. All text is static.
struct EdsField {
  /// The symbol of the documents; reserved bytes without one are RES_ and their address.
  std::string_view symbol{};
  std::string_view meaning{};
  std::uint8_t address = 0;
  /// 1, 2 or 4: U8, U16, U32. More than one byte: big-endian.
  std::uint8_t bytes = 1;
  EdsKind kind = EdsKind::number;
  EdsUnit unit = EdsUnit::none;
  /// The range, limits included. If no source gives one, it is the range of the bytes.
  std::uint32_t min = 0;
  std::uint32_t max = 0;

  constexpr std::uint32_t all_ones() const {
    return static_cast<std::uint32_t>(low_mask(8U * bytes));
  }
  constexpr bool in_range(std::uint32_t value) const { return value >= min && value <= max; }
  /// Whether 0 and all ones can mark a value that is not given: the range excludes just these two.
  /// No document states this rule (inferred).
  constexpr bool may_be_absent() const { return min == 1 && max == all_ones() - 1; }
};

/// The value of a field, in or out of its range.
constexpr std::uint32_t field_value(const EdsBank& bank, const EdsField& field) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < field.bytes; ++i) value = value << 8U | bank[field.address + i];
  return value;
}

/// Writes a field, in or out of its range; sealed() sets the checksum. False, and nothing written,
/// when the value has more bits than the field.
[[nodiscard]] constexpr bool set_field(EdsBank& bank, const EdsField& field, std::uint32_t value) {
  if (value > field.all_ones()) return false;
  for (std::size_t i = field.bytes; i-- > 0; value >>= 8U) {
    bank[field.address + i] = static_cast<std::uint8_t>(value);
  }
  return true;
}

/// The value with its bytes in reverse order: the value that a little-endian writer meant.
constexpr std::uint32_t bytes_swapped(std::uint32_t value, unsigned bytes) {
  std::uint32_t swapped = 0;
  for (unsigned i = 0; i < bytes; ++i, value >>= 8U) swapped = swapped << 8U | (value & 0xFFU);
  return swapped;
}

/// The field with exactly this symbol; null when there is none.
constexpr const EdsField* find_field(std::span<const EdsField> fields, std::string_view symbol) {
  for (const EdsField& field : fields) {
    if (field.symbol == symbol) return &field;
  }
  return nullptr;
}

}  // namespace biss

namespace biss::eds_detail {

// Whether this is a polynomial of BiSS in full form, with the lowest bit that the data sheet leaves
// out.
constexpr bool is_full_form_of_known(std::uint32_t stored) {
  constexpr std::uint32_t ccitt = 0x11021;  // in BP3's history, 0x8810 (Rev A2)
  if (stored == ccitt) return true;
  for (unsigned width = min_crc_bits; width <= max_crc_bits; ++width) {
    if (stored != 0 && stored == default_polynomial(width)) return true;
  }
  return false;
}

// The width of a CRC whose polynomial is stored without its lowest bit.
constexpr unsigned stored_crc_bits(std::uint32_t stored) {
  return static_cast<unsigned>(std::bit_width(stored));
}

// Whether each byte of a bank belongs to one row.
constexpr bool covers_a_bank(std::span<const EdsField> fields) {
  std::size_t at = 0;
  for (const EdsField& field : fields) {
    if (field.address != at) return false;
    at += field.bytes;
  }
  return at == eds_bank_bytes;
}

}  // namespace biss::eds_detail
