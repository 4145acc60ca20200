// Decimal digits to numbers, and decimal numbers to whole units, exactly.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "biss/base/result.hpp"

namespace biss::capture {

inline constexpr std::array<std::uint64_t, 9> powers_of_ten{
    1, 10, 100, 1'000, 10'000, 100'000, 1'000'000, 10'000'000, 100'000'000};

struct Digits {
  std::uint64_t value;
  const char* end;  ///< after the last digit
};

/// The digits at `text`, up to 19 of them; with more, `value` is undefined.
/// \pre a character that is no digit follows, and the 8 bytes after it may be read
inline Digits read_digits(const char* text) {
  std::uint64_t value = 0;
  if constexpr (std::endian::native == std::endian::little) {
    for (;;) {
      std::uint64_t word = 0;
      std::memcpy(&word, text, sizeof word);
      const std::uint64_t digits = word - 0x3030303030303030U;
      const std::uint64_t high_bits = (digits | (digits + 0x7676767676767676U) | word);
      const std::uint64_t no_digit = high_bits & 0x8080808080808080U;
      const auto count = static_cast<unsigned>(std::countr_zero(no_digit)) / 8U;
      if (count == 0) return {value, text};
      // The digits to the end of the word, zeros before them; then add up neighbours.
      std::uint64_t sum = count == 8 ? digits : digits << (64U - 8U * count);
      sum = sum * 10U + (sum >> 8U);
      sum = ((sum & 0x000000FF000000FFU) * 0x000F424000000064U +
             ((sum >> 16U) & 0x000000FF000000FFU) * 0x0000271000000001U) >>
            32U;
      value = value * powers_of_ten[count] + sum;
      text += count;
      if (count != 8) return {value, text};
    }
  } else {
    for (; *text >= '0' && *text <= '9'; ++text) {
      value = value * 10U + static_cast<std::uint64_t>(*text - '0');
    }
    return {value, text};
  }
}

enum class DecimalCause : std::uint8_t { no_number, out_of_range };

/// `text` × 10^`scale`, rounded to a whole number, halves away from zero.
///
/// Sign, digits with or without a fraction, exponent (`-1.5e-3`); at least one digit; `.` and, when
/// `comma` is set, `,` as decimal mark. Any number of digits. Fails with `no_number`, or with
/// `out_of_range` when the result is beyond ±(2⁶³ − 1).
Result<std::int64_t, DecimalCause> parse_decimal(std::string_view text, int scale,
                                                 bool comma = false);

}  // namespace biss::capture
