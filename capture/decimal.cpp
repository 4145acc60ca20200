#include "capture/decimal.hpp"

#include <limits>
#include <optional>

namespace biss::capture {
namespace {

constexpr auto largest = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::uint64_t digit_of(char c) { return static_cast<std::uint64_t>(c - '0'); }

// The parts of a number. `digits` counts the digits of both parts, without the decimal mark.
struct Parts {
  bool negative = false;
  std::string_view whole;
  std::string_view fraction;
  std::int64_t exponent = 0;

  std::size_t digits() const { return whole.size() + fraction.size(); }
  char digit(std::size_t i) const {
    return i < whole.size() ? whole[i] : fraction[i - whole.size()];
  }
};

std::string_view take_digits(std::string_view& text) {
  std::size_t count = 0;
  while (count < text.size() && is_digit(text[count])) ++count;
  const std::string_view digits = text.substr(0, count);
  text.remove_prefix(count);
  return digits;
}

bool take_sign(std::string_view& text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  return negative;
}

std::optional<Parts> take_apart(std::string_view text, bool comma) {
  // Far beyond every length of a number that a line can hold, and far from overflow.
  constexpr std::int64_t huge_exponent = 1'000'000'000;
  Parts parts;
  parts.negative = take_sign(text);
  parts.whole = take_digits(text);
  if (text.starts_with('.') || (comma && text.starts_with(','))) {
    text.remove_prefix(1);
    parts.fraction = take_digits(text);
  }
  if (parts.digits() == 0) return std::nullopt;
  if (text.empty()) return parts;
  if (text[0] != 'e' && text[0] != 'E') return std::nullopt;
  text.remove_prefix(1);
  const bool negative = take_sign(text);
  const std::string_view digits = take_digits(text);
  if (digits.empty() || !text.empty()) return std::nullopt;
  for (const char c : digits) {
    parts.exponent = parts.exponent * 10 + static_cast<std::int64_t>(digit_of(c));
    if (parts.exponent > huge_exponent) parts.exponent = huge_exponent;
  }
  if (negative) parts.exponent = -parts.exponent;
  return parts;
}

bool append_digit(std::uint64_t& value, std::uint64_t digit) {
  if (value > (largest - digit) / 10) return false;
  value = value * 10 + digit;
  return true;
}

// The digits before the point after it was moved by the scale and the exponent, then rounded.
std::optional<std::uint64_t> magnitude_of(const Parts& parts, int scale) {
  const std::int64_t point = static_cast<std::int64_t>(parts.whole.size()) + parts.exponent + scale;
  if (point < 0) return 0;
  const auto places = static_cast<std::uint64_t>(point);
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < parts.digits() && i < places; ++i) {
    if (!append_digit(value, digit_of(parts.digit(i)))) return std::nullopt;
  }
  for (std::uint64_t i = parts.digits(); i < places && value != 0; ++i) {
    if (!append_digit(value, 0)) return std::nullopt;
  }
  // The first digit dropped decides: 5 and more is half or above, whatever follows.
  if (places < parts.digits() && parts.digit(static_cast<std::size_t>(places)) >= '5') {
    if (value == largest) return std::nullopt;
    ++value;
  }
  return value;
}

// Appends the digits at the front of `text` to `value`, eight at a time; returns how many.
std::size_t append_digits(std::string_view text, std::uint64_t& value) {
  std::size_t at = 0;
  for (; text.size() - at >= 8; at += 8) {
    const std::uint64_t word = load_eight(text.data() + at);
    if (no_digits(word) != 0) break;
    value = value * powers_of_ten[8] + sum_digits(word - 0x3030303030303030U);
  }
  for (; at < text.size() && is_digit(text[at]); ++at) value = value * 10 + digit_of(text[at]);
  return at;
}

// The plain case, like nearly every cell: `42007.500`, few digits, no exponent, nothing to round.
std::optional<std::int64_t> parse_plain(std::string_view text, int scale, bool comma) {
  if (text.empty() || text.size() > 18 || scale < 0 || scale > 12) return std::nullopt;
  std::uint64_t value = 0;
  std::size_t at = append_digits(text, value);
  if (at == 0) return std::nullopt;
  std::size_t missing = static_cast<std::size_t>(scale);
  if (at < text.size() && (text[at] == '.' || (comma && text[at] == ','))) {
    const std::size_t places = append_digits(text.substr(++at), value);
    if (places > missing) return std::nullopt;
    at += places;
    missing -= places;
  }
  if (at != text.size() || value > largest / powers_of_ten[missing]) return std::nullopt;
  return static_cast<std::int64_t>(value * powers_of_ten[missing]);
}

}  // namespace

Result<std::int64_t, DecimalCause> parse_decimal(std::string_view text, int scale, bool comma) {
  if (const auto plain = parse_plain(text, scale, comma)) return *plain;
  const auto parts = take_apart(text, comma);
  if (!parts) return failure(DecimalCause::no_number);
  const auto magnitude = magnitude_of(*parts, scale);
  if (!magnitude) return failure(DecimalCause::out_of_range);
  const auto value = static_cast<std::int64_t>(*magnitude);
  return parts->negative ? -value : value;
}

std::int64_t last_digit_of(std::string_view text, int scale) {
  const auto parts = take_apart(text, true);
  if (!parts) return 0;
  const Parts one{.whole = "1",
                  .fraction = {},
                  .exponent = parts->exponent - static_cast<std::int64_t>(parts->fraction.size())};
  return static_cast<std::int64_t>(magnitude_of(one, scale).value_or(largest));
}

}  // namespace biss::capture
