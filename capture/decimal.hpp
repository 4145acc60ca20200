// Decimal digits to numbers, and decimal numbers to whole units, exactly.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "biss/base/result.hpp"

namespace biss::capture {

inline constexpr std::array<std::uint64_t, 20> powers_of_ten = [] {
  std::array<std::uint64_t, 20> powers{1};
  for (std::size_t i = 1; i < powers.size(); ++i) powers[i] = 10 * powers[i - 1];
  return powers;
}();

/// Eight bytes as a number, the first lowest.
inline std::uint64_t load_eight(const char* text) {
  std::uint64_t word = 0;
  std::memcpy(&word, text, sizeof word);
  return word;
}

/// The upper bit of each byte that is not a digit; correct up to the first of them.
inline std::uint64_t no_digits(std::uint64_t word) {
  const std::uint64_t digits = word - 0x3030303030303030U;
  return (digits | (digits + 0x7676767676767676U) | word) & 0x8080808080808080U;
}

/// The number of eight digits, given as bytes 0 to 9: neighbours are added up.
inline std::uint64_t sum_digits(std::uint64_t digits) {
  const std::uint64_t pairs = digits * 10U + (digits >> 8U);
  return ((pairs & 0x000000FF000000FFU) * 0x000F424000000064U +
          ((pairs >> 16U) & 0x000000FF000000FFU) * 0x0000271000000001U) >>
         32U;
}

struct Digits {
  std::uint64_t value;
  const char* end;  ///< after the last digit
};

/// The digits at `text`, up to 19 of them; with more, `value` is undefined.
/// \pre a character that is not a digit follows, and the 8 bytes after it may be read
inline Digits read_digits(const char* text) {
  std::uint64_t value = 0;
  for (;;) {
    const std::uint64_t word = load_eight(text);
    const auto count = static_cast<unsigned>(std::countr_zero(no_digits(word))) / 8U;
    if (count == 0) return {value, text};
    // The digits to the end of the word, zeros before them.
    const std::uint64_t digits = word - 0x3030303030303030U;
    const std::uint64_t sum = sum_digits(count == 8 ? digits : digits << (64U - 8U * count));
    value = value * powers_of_ten[count] + sum;
    text += count;
    if (count != 8) return {value, text};
  }
}

/// Reads numbers that have the same count of digits and follow each other: nearly always the first
/// digits stay as they are.
class FixedDigits {
 public:
  static constexpr std::size_t most = 16;

  /// \pre count <= most
  explicit FixedDigits(std::size_t count)
      : count_(count),
        keep_low_(upper_bytes(count < 8 ? count : 8)),
        keep_high_(upper_bytes(count < 8 ? 0 : count - 8)) {}

  std::size_t count() const { return count_; }

  /// The number whose digits end before `end`; false, and no number, if another character is among
  /// them. \pre the 16 bytes before `end` may be read
  bool read(const char* end, std::uint64_t& number) {
    const std::uint64_t high = (load_eight(end - 16) & keep_high_) | (zeros & ~keep_high_);
    const std::uint64_t low = (load_eight(end - 8) & keep_low_) | (zeros & ~keep_low_);
    if (no_digits(low) != 0) return false;
    if (high != high_) {
      if (no_digits(high) != 0) return false;
      high_ = high;
      high_number_ = sum_digits(high - zeros) * powers_of_ten[8];
    }
    number = high_number_ + sum_digits(low - zeros);
    return true;
  }

 private:
  static constexpr std::uint64_t zeros = 0x3030303030303030U;

  static std::uint64_t upper_bytes(std::size_t count) {
    return count == 0 ? 0 : ~std::uint64_t{0} << (64U - 8U * count);
  }

  std::size_t count_;
  std::uint64_t keep_low_;
  std::uint64_t keep_high_;
  std::uint64_t high_ = zeros;
  std::uint64_t high_number_ = 0;
};

enum class DecimalCause : std::uint8_t { no_number, out_of_range };

/// `text` × 10^`scale`, rounded to a whole number, halves away from zero.
///
/// Sign, digits with or without a fraction, exponent (`-1.5e-3`); at least one digit; `.` and, when
/// `comma` is set, `,` as decimal mark. Any number of digits. Fails with `no_number`, or with
/// `out_of_range` when the result is beyond ±(2⁶³ − 1).
Result<std::int64_t, DecimalCause> parse_decimal(std::string_view text, int scale,
                                                 bool comma = false);

/// The value of one unit in the last digit of `text`, times 10^`scale`; 0 if that is less than one
/// half.
/// \pre parse_decimal() reads it
std::int64_t last_digit_of(std::string_view text, int scale);

}  // namespace biss::capture
