// Text of `[section]` and `key=value` rows, as the archives of sigrok and DSView hold it.
#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "biss/base/units.hpp"

namespace biss::capture {

/// `text` without blanks around it.
std::string_view trimmed(std::string_view text);

/// Takes the next row off the front of `text`, trimmed.
std::string_view take_row(std::string_view& text);

/// Neither a section nor a key: empty, or a comment.
bool is_comment_row(std::string_view row);

/// Characters that cannot stand in a value are written as \s, \n, \t, \r and doubled backslashes.
std::string unescaped(std::string_view value);
std::string escaped(std::string_view text);

/// Decimal digits and nothing else.
template <class Number>
std::optional<Number> whole_number(std::string_view text) {
  Number number = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failed != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// `100 MHz`, `12.5 MHz`, `2000000`: hertz, kilohertz, megahertz or gigahertz, with or without
/// `Hz`, rounded to the hertz. 0 Hz for a text that is not a rate, or beyond 4.29 GHz.
Hertz parse_sample_rate(std::string_view text);

/// The rate with the largest unit in which it is whole. \pre rate is not 0 Hz
std::string sample_rate_text(Hertz rate);

}  // namespace biss::capture
