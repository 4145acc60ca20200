// Whole numbers in as many bytes as they need, as simulators store them: seven bits a byte, the
// lowest first; the highest bit means that another byte follows.
#pragma once

#include <cstdint>
#include <optional>
#include <type_traits>

namespace biss::capture {

/// A number without a sign, or in two's complement, whose sign is bit 6 of the last byte. Nothing
/// if the number has more than 64 bits.
/// \param next gives the next byte
template <class Number, class Next>
constexpr std::optional<Number> leb128(Next next) {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64; shift += 7) {
    const std::uint8_t byte = next();
    if (std::is_unsigned_v<Number> && shift == 63 && byte > 1) break;
    value |= std::uint64_t{byte & 0x7FU} << shift;
    if (byte >= 0x80) continue;
    const bool negative = std::is_signed_v<Number> && (byte & 0x40U) != 0;
    if (negative && shift + 7 < 64) value |= ~std::uint64_t{0} << (shift + 7);
    return static_cast<Number>(value);
  }
  return std::nullopt;
}

}  // namespace biss::capture
