// Whole numbers in as many bytes as they need, as simulators store them: seven bits a byte, the
// lowest first; the highest bit says that another byte follows.
#pragma once

#include <cstdint>
#include <optional>

namespace biss::capture {

/// Nothing where the number has more than 64 bits.
/// \param next gives the next byte
template <class Next>
constexpr std::optional<std::uint64_t> unsigned_leb128(Next next) {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64; shift += 7) {
    const std::uint8_t byte = next();
    if (shift == 63 && byte > 1) break;
    value |= std::uint64_t{byte & 0x7FU} << shift;
    if (byte < 0x80) return value;
  }
  return std::nullopt;
}

/// The same of a number with a sign, which is bit 6 of the last byte.
template <class Next>
constexpr std::optional<std::int64_t> signed_leb128(Next next) {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64; shift += 7) {
    const std::uint8_t byte = next();
    value |= std::uint64_t{byte & 0x7FU} << shift;
    if (byte >= 0x80) continue;
    if ((byte & 0x40U) != 0 && shift + 7 < 64) value |= ~std::uint64_t{0} << (shift + 7);
    return static_cast<std::int64_t>(value);
  }
  return std::nullopt;
}

}  // namespace biss::capture
