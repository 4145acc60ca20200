// Numbers whose lowest byte comes first, as logic analysers store them.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>

namespace biss::capture {

inline std::uint64_t get_number(const char* at, std::size_t bytes) {
  std::uint64_t number = 0;
  while (bytes-- > 0) number = number << 8U | static_cast<unsigned char>(at[bytes]);
  return number;
}

inline double get_double(const char* at) { return std::bit_cast<double>(get_number(at, 8)); }

inline void put_number(std::string& out, std::uint64_t number, std::size_t bytes) {
  for (; bytes-- > 0; number >>= 8U) out += static_cast<char>(number & 0xFFU);
}

/// Numbers of that many bytes each.
inline void put_numbers(std::string& out, std::size_t bytes,
                        std::initializer_list<std::uint64_t> numbers) {
  for (const std::uint64_t number : numbers) put_number(out, number, bytes);
}

inline void put_double(std::string& out, double value) {
  put_number(out, std::bit_cast<std::uint64_t>(value), 8);
}

}  // namespace biss::capture
