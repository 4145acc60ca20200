// Numbers with the most significant byte at the lowest address, as in every BiSS register.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/base/language.hpp"

namespace biss {

/// The number in `Bytes` bytes (1…8), the first one most significant.
template <std::size_t Bytes>
constexpr std::uint64_t from_big_endian(std::span<const std::uint8_t, Bytes> bytes) {
  static_assert(Bytes >= 1 && Bytes <= 8);
  std::uint64_t value = 0;
  for (const std::uint8_t byte : bytes) value = value << 8U | byte;
  return value;
}

/// The lowest `Bytes` bytes (1…8) of a number, most significant first.
template <std::size_t Bytes>
constexpr std::array<std::uint8_t, Bytes> to_big_endian(std::uint64_t value) {
  static_assert(Bytes >= 1 && Bytes <= 8);
  std::array<std::uint8_t, Bytes> bytes{};
  for (std::size_t i = Bytes; i-- > 0; value >>= 8U) bytes[i] = static_cast<std::uint8_t>(value);
  return bytes;
}

/// A number as registers store it: its bytes, the most significant one first.
template <std::unsigned_integral Number>
class BigEndian {
 public:
  constexpr BigEndian(Number number) : bytes_(to_big_endian<sizeof(Number)>(number)) {}
  constexpr operator Number() const {
    return static_cast<Number>(from_big_endian<sizeof(Number)>(bytes_));
  }

 private:
  std::array<std::uint8_t, sizeof(Number)> bytes_;
};

}  // namespace biss
