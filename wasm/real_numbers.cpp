// Real numbers as text and back, with the functions of <charconv>.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#ifndef __cpp_lib_to_chars

namespace {

// The fewest digits that give the same number again, and the exponent of the first one.
struct Digits {
  std::string digits;
  int exponent = 0;
};

Digits shortest(double value) {
  constexpr int enough = 16;
  for (int places = 0;; ++places) {
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "%.*e", places, value);
    if (places != enough && std::strtod(text.data(), nullptr) != value) continue;
    const char* const begin = text.data();
    const char* const exponent = std::strchr(begin, 'e');
    Digits found;
    found.digits.assign(begin, exponent);
    std::erase(found.digits, '.');
    found.exponent = static_cast<int>(std::strtol(exponent + 1, nullptr, 10));
    return found;
  }
}

std::string text_with_exponent(const Digits& number) {
  std::string text = number.digits.substr(0, 1);
  if (number.digits.size() > 1) text += '.' + number.digits.substr(1);
  std::array<char, 8> exponent{};
  std::snprintf(exponent.data(), exponent.size(), "e%+03d", number.exponent);
  return text + exponent.data();
}

std::string text_without_exponent(const Digits& number, double value) {
  const auto count = static_cast<int>(number.digits.size());
  if (number.exponent >= count - 1) {
    std::array<char, 400> text{};
    std::snprintf(text.data(), text.size(), "%.0f", value);
    return text.data();
  }
  if (number.exponent < 0) {
    return "0." + std::string(static_cast<std::size_t>(-number.exponent - 1), '0') + number.digits;
  }
  const auto whole = static_cast<std::size_t>(number.exponent) + 1;
  return number.digits.substr(0, whole) + '.' + number.digits.substr(whole);
}

bool is_part_of_number(char c) { return c != 0 && std::strchr("0123456789.-+eE", c) != nullptr; }

}  // namespace

namespace std {

// Only decimal numbers. A text longer than any number that a user types is refused.
from_chars_result from_chars(const char* begin, const char* end, double& value) {
  array<char, 64> text{};
  size_t count = 0;
  while (begin + count != end && count + 1 < text.size() && is_part_of_number(begin[count])) {
    text[count] = begin[count];
    ++count;
  }
  char* stop = text.data();
  if (count != 0 && text[0] != '+') value = strtod(text.data(), &stop);
  return {begin + (stop - text.data()), stop == text.data() ? errc::invalid_argument : errc{}};
}

// The shorter of both notations; fixed if they are equally long.
to_chars_result to_chars(char* begin, char* end, double value) {
  string text = signbit(value) ? "-" : "";
  const Digits number = shortest(fabs(value));
  const string with_exponent = text_with_exponent(number);
  const string without = text_without_exponent(number, fabs(value));
  text += without.size() <= with_exponent.size() ? without : with_exponent;
  if (static_cast<size_t>(end - begin) < text.size()) return {end, errc::value_too_large};
  return {copy(text.begin(), text.end(), begin), errc{}};
}

}  // namespace std

#endif
