// Real numbers as text and back, with the functions of <charconv>.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "wasm/compat.hpp"

namespace biss::wasm {

std::from_chars_result from_chars(const char* begin, const char* end, double& value) {
  const char* const other = std::find_if_not(begin, end, [](char c) {
    return (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+' || c == 'e' || c == 'E';
  });
  // Without the characters that only strtod() reads: blanks, hexadecimal digits, infinity.
  std::string number(begin, other);
  char* stop = nullptr;
  const double read = std::strtod(number.c_str(), &stop);
  number.resize(static_cast<std::size_t>(stop - number.c_str()));
  if (number.empty() || number[0] == '+') return {begin, std::errc::invalid_argument};
  const char* const rest = begin + number.size();
  // A digit above 0 before the exponent: the number is not 0.
  const bool is_zero = number.find_first_of("123456789") >= number.find_first_of("eE");
  if (std::isinf(read) || (read == 0 && !is_zero)) return {rest, std::errc::result_out_of_range};
  value = read;
  return {rest, std::errc{}};
}

std::to_chars_result to_chars(char* begin, char* end, double value) {
  std::array<char, 32> with_exponent{};  // the longest text is -1.2345678901234567e-308
  std::array<char, 32> without_exponent{};
  int length = 0;
  int places = -1;
  int exponent = 0;
  // The fewest digits that are read as `value` again; 17 are always enough.
  do {
    length = std::snprintf(with_exponent.data(), with_exponent.size(), "%.*e", ++places, value);
    if (!std::isfinite(value)) break;
    char* const mark = std::strchr(with_exponent.data(), 'e');
    exponent = std::atoi(mark + 1);
    // Above a power of two, numbers are twice as far apart as below: the digits above it may be read
    // as the power although the nearest digits, which are below it, are not.
    if (std::strtod(with_exponent.data(), nullptr) != value && mark[-1] != '9') ++mark[-1];
  } while (std::strtod(with_exponent.data(), nullptr) != value);
  // A text that does not fit into the array is longer than the text with exponent.
  const int other_length = std::snprintf(without_exponent.data(), without_exponent.size(), "%.*f",
                                         std::max(places - exponent, 0), value);
  const char* const text = (length < other_length ? with_exponent : without_exponent).data();
  length = std::min(length, other_length);
  if (end - begin < length) return {end, std::errc::value_too_large};
  return {std::copy_n(text, length, begin), std::errc{}};
}

}  // namespace biss::wasm
