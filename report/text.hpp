// Numbers and strings as characters: exact, the same in every locale, safe to print.
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "biss/base/bits.hpp"
#include "biss/base/units.hpp"

namespace biss::report {

/// The most characters that put_number() and put_nanoseconds() write.
inline constexpr std::size_t number_chars = 32;

/// Each put_ writes to `at`, which has room for it, and returns the end; each append_ writes the same
/// text to the end of a string.
char* put_number(char* at, std::uint64_t value);
char* put_number(char* at, std::int64_t value);
/// As few digits as give the same double again, with an exponent if that is shorter; no digits if
/// it is not finite.
char* put_number(char* at, double value);
template <class Number>
void append_number(std::string& out, Number value) {
  std::array<char, number_chars> text;
  out.append(text.data(), put_number(text.data(), value));
}

/// Nanoseconds with up to three digits after the point, exact, no trailing zeros: `112`, `-0.5`.
char* put_nanoseconds(char* at, Picoseconds time);

/// The whole text as a number; nothing if it is not a number.
template <class Number, class... Base>
std::optional<Number> number_in(std::string_view text, Base... base) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number, base...);
  return error == std::errc() && rest == end ? std::optional(number) : std::nullopt;
}

/// A sign and a magnitude, so that all of uint64 and int64 fit.
struct Magnitude {
  std::uint64_t value = 0;
  bool negative = false;
};

/// Magnitude and sign of any int64, the lowest one too.
constexpr Magnitude magnitude_of(std::int64_t value) {
  const auto bits = static_cast<std::uint64_t>(value);
  return value < 0 ? Magnitude{~bits + 1U, true} : Magnitude{bits, false};
}

/// The number divided by 10^shift with exactly `places` digits after the point, rounded half away
/// from zero; a number that rounds to zero has no sign.
/// \pre shift and places are at most 18
void append_fixed(std::string& out, Magnitude number, unsigned shift, unsigned places);

/// The bits as one hexadecimal number with `0x`, upper case: the first bit on the line is the most
/// significant one, zeros in front fill the first digit. No bits give no text.
char* put_hex(char* at, BitView bits);
/// The most characters that put_hex() writes.
constexpr std::size_t hex_chars(BitView bits) { return bits.size_bits() / 4 + 3; }

/// One character of UTF-8.
struct CodePoint {
  char32_t value = 0;
  std::size_t bytes = 1;  ///< how many to step over; 1 when not valid
  bool valid = false;
};

/// The character at the front of `text`: overlong forms, surrogates and values past U+10FFFF are
/// not valid. \pre text is not empty
CodePoint front_code_point(std::string_view text);

/// Appends `text` fit for a terminal: control characters and invalid UTF-8 become U+FFFD, so that a
/// name from a file cannot control the terminal or break a line.
void append_printable(std::string& out, std::string_view text);
/// The same for text of several lines: line feeds and tabs stay.
void append_printable_lines(std::string& out, std::string_view text);

/// Columns that printable text takes: combining marks none, wide East Asian characters two.
std::size_t display_width(std::string_view text);

/// Appends `text` with spaces before (or after) it up to `width` columns.
void append_padded(std::string& out, std::string_view text, std::size_t width, bool right_aligned);

/// Columns, counted from 0.
struct Wrap {
  std::size_t first = 0;   ///< the column at which the text begins
  std::size_t indent = 0;  ///< the column at which its further lines begin
  std::size_t width = 0;   ///< of a line; a longer word is not broken
};

/// Appends `text` broken at spaces, without a line feed at its end.
void append_wrapped(std::string& out, std::string_view text, Wrap wrap);

}  // namespace biss::report
