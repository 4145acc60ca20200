// A hash of text that is the same on every machine: FNV-1a, 64 bits.
#pragma once

#include <cstdint>
#include <string_view>

namespace biss::archive {

constexpr std::uint64_t hash_of(std::string_view text) {
  std::uint64_t hash = 0xCBF29CE484222325U;
  for (const char letter : text) {
    hash = (hash ^ static_cast<std::uint8_t>(letter)) * 0x100000001B3U;
  }
  return hash;
}
static_assert(hash_of("a") == 0xAF63DC4C8601EC8CU);

}  // namespace biss::archive
