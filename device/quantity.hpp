// Quantities with units as users type and read them: exact, in integers, without a locale.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "biss/base/result.hpp"
#include "biss/base/units.hpp"

namespace biss {

/// Why a text is not a quantity.
enum class QuantityCause : std::uint8_t {
  empty,          ///< no text
  negative,       ///< starts with `-`
  not_a_number,   ///< a digit is missing
  decimal_comma,  ///< `1,5` instead of `1.5`
  unit_missing,   ///< a number other than 0 without a unit
  unknown_unit,   ///< not a unit of this quantity
  too_fine,       ///< more decimal places than the smallest step (1 Hz, 1 ps, 1 mm)
  too_small,      ///< below the least value
  too_large,      ///< above the greatest value
};

/// The cause and the place of the first wrong character, counted from 0.
struct QuantityError {
  QuantityCause cause{};
  std::size_t at = 0;

  bool operator==(const QuantityError&) const = default;
};

/// `10MHz`, `250 kHz`, `1.5MHz`: Hz, kHz, MHz, GHz; 1 Hz to 4294967295 Hz in steps of 1 Hz. For
/// this and all other quantities, only 0 may have no unit.
Result<Hertz, QuantityError> parse_rate(std::string_view text);

/// `31.25us`, `42.5ns`, `3 ms`, `0`: ps, ns, us, µs, ms, s; 0 to 1000 s in steps of 1 ps.
Result<Picoseconds, QuantityError> parse_duration(std::string_view text);

/// A time in a capture, which may start before 0: `-20us`, `+3ms`; ±100 days in steps of 1 ps.
Result<Picoseconds, QuantityError> parse_time(std::string_view text);

/// `50m`, `0.5m`, `1km`: mm, cm, m, km; 0 to 10 km in steps of 1 mm.
Result<Millimetres, QuantityError> parse_length(std::string_view text);

/// A share as `45%`, `44.5 %`: 0.1 % to 99.9 %. \return thousandths
Result<std::uint32_t, QuantityError> parse_duty(std::string_view text);

/// The deviation of a rate: `200ppm`, `-50 ppm`, `+0.5%`; ±10 %. \return parts per million
Result<std::int32_t, QuantityError> parse_deviation(std::string_view text);

/// A voltage with or without a sign: `1.2V`, `-200 mV`; uV, mV, V, kV; ±1 MV in steps of 1 nV.
Result<Nanovolts, QuantityError> parse_voltage(std::string_view text);

/// A count or a position: decimal, or hexadecimal after `0x`; 0 to `largest`. A sign, a point, a
/// unit or a space is not_a_number.
Result<std::uint64_t, QuantityError> parse_count(std::string_view text,
                                                 std::uint64_t largest = UINT64_MAX);

/// The quantity that a text must be.
enum class Quantity : std::uint8_t {
  rate,
  duration,
  time,
  length,
  duty,
  deviation,
  voltage,
  count
};

/// One line: "'10m': at character 3: unknown unit; use Hz, kHz, MHz or GHz".
/// \param largest as given to parse_count()
std::string quantity_error_text(Quantity quantity, std::string_view text, QuantityError error,
                                std::uint64_t largest = UINT64_MAX);

/// Human-readable, in the largest unit with a value of at least 1: `10 MHz`, `31.25 us`, `50 m`.
/// Exact by default, and then the text parses to the same quantity; otherwise rounded to
/// `max_places` decimal places. \pre max_places is at most 12
std::string text_of(Hertz rate, unsigned max_places = 12);
std::string text_of(Picoseconds duration, unsigned max_places = 12);
std::string text_of(Millimetres length, unsigned max_places = 12);

}  // namespace biss
