// A hash of text that is the same on every machine: FNV-1a, 64 bits. A text with one changed byte
// has another hash.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

namespace biss::archive {

/// \param hash of the text before, to hash a text in pieces
constexpr std::uint64_t hash_of(std::string_view text, std::uint64_t hash = 0xCBF29CE484222325U) {
  for (const char letter : text) {
    hash = (hash ^ static_cast<std::uint8_t>(letter)) * 0x100000001B3U;
  }
  return hash;
}
static_assert(hash_of("a") == 0xAF63DC4C8601EC8CU);

/// The end of a JSON object that this program writes and reads back: the checksum of all bytes
/// before it, as the last member. Always of the same size.
inline std::string checksum_end(std::uint64_t hash) {
  return fmt::format(",\n\"checksum\":\"{:016x}\"}}\n", hash);
}
/// Whether a text ends with the checksum of the bytes before it.
inline bool checksum_holds(std::string_view text) {
  const std::size_t hashed = text.size() - std::min(text.size(), checksum_end(0).size());
  return text.substr(hashed) == checksum_end(hash_of(text.substr(0, hashed)));
}
/// Follows the name of a file if the checksum at its end does not match its bytes.
inline constexpr std::string_view checksum_wrong =
    "its checksum is missing or wrong; it was changed, or written by a version without checksums, "
    "so make it again";

}  // namespace biss::archive
