// Hexadecimal digits, as every text format has them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "dump/line_source.hpp"

namespace biss::dump {

constexpr int hex_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// The number that all of `text` is; empty when it is none, or has more than 8 digits.
constexpr std::optional<std::uint32_t> hex_number(std::string_view text) {
  if (text.empty() || text.size() > 8) return std::nullopt;
  std::uint32_t number = 0;
  for (const char c : text) {
    const int digit = hex_value(c);
    if (digit < 0) return std::nullopt;
    number = number << 4U | static_cast<std::uint32_t>(digit);
  }
  return number;
}

/// Decimal, or hexadecimal behind 0x; at most 8 digits.
constexpr std::optional<std::uint32_t> any_number(std::string_view text) {
  if (text.starts_with("0x") || text.starts_with("0X")) return hex_number(text.substr(2));
  if (text.empty() || text.size() > 8) return std::nullopt;
  std::uint32_t number = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return std::nullopt;
    number = number * 10U + static_cast<std::uint32_t>(c - '0');
  }
  return number;
}

/// Takes the next word off the front of `rest`; empty at the end.
constexpr std::string_view next_word(std::string_view& rest) {
  while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
  std::size_t size = 0;
  while (size < rest.size() && !is_blank(rest[size])) ++size;
  const std::string_view word = rest.substr(0, size);
  rest.remove_prefix(size);
  return word;
}

}  // namespace biss::dump
