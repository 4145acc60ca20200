// Bit strings in transmission order: bit 0 is the first on the line, and the top bit of the first
// byte.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "biss/base/language.hpp"

namespace biss {

/// The lowest `bits` bits set. \pre bits is 0…64
constexpr std::uint64_t low_mask(unsigned bits) {
  return bits == 0 ? 0 : ~std::uint64_t{0} >> (64U - bits);
}

/// A read-only run of bits inside bytes that the caller owns; the bytes must outlive the view. Bits
/// are numbered from 0 in transmission order, the most significant bit of a byte first.
class BitView {
 public:
  constexpr BitView() = default;
  /// All bits of `bytes`.
  constexpr explicit BitView(std::span<const std::uint8_t> bytes)
      : BitView(bytes, 0, bytes.size() * 8) {}
  /// `size_bits` bits from `first_bit`, limited to the bits that `bytes` has.
  constexpr BitView(std::span<const std::uint8_t> bytes, std::size_t first_bit,
                    std::size_t size_bits)
      : bytes_(bytes.data()),
        first_bit_(std::min(first_bit, bytes.size() * 8)),
        size_bits_(std::min(size_bits, bytes.size() * 8 - first_bit_)) {}

  constexpr std::size_t size_bits() const { return size_bits_; }
  constexpr bool empty() const { return size_bits_ == 0; }

  /// For a second reader: the bytes from the first one that holds a bit to the last one, and which
  /// bit of the first byte (0 = the top one) bit 0 is.
  constexpr std::span<const std::uint8_t> stored() const {
    return std::span(bytes_, stored_bytes()).subspan(first_bit_ >> 3U);
  }
  constexpr unsigned first_bit_of_stored() const { return first_bit_ & 7U; }

  /// \pre index < size_bits()
  constexpr bool operator[](std::size_t index) const {
    const std::size_t at = first_bit_ + index;
    return ((bytes_[at >> 3U] >> (7U - (at & 7U))) & 1U) != 0;
  }

  /// The bits that window() always gives: 8 bytes less the 7 bits that may precede bit 0.
  static constexpr unsigned known_bits = 57;

  /// The bits from `index` on, the first one topmost: at least known_bits of them, or all that are
  /// left. The bits after them are undefined.
  /// \pre index < size_bits()
  constexpr std::uint64_t window(std::size_t index) const {
    const std::size_t at = first_bit_ + index;
    const std::size_t stored = stored_bytes();
    if (stored >= 8) {
      // Near the end read the last 8 bytes instead of stepping over it.
      const std::size_t base = std::min(at >> 3U, stored - 8U);
      return load(bytes_ + base) << (at - base * 8U);
    }
    return load_short(bytes_, stored) << at;
  }

  /// `count` bits from `index` as a number, the first bit most significant.
  /// \pre count is 0…64 and index + count <= size_bits()
  constexpr std::uint64_t word(std::size_t index, unsigned count) const {
    if (count == 0) return 0;
    if constexpr (narrow) {
      if (count <= 25) return narrow_window(index) >> (32U - count);
    }
    if (count < known_bits) return window(index) >> (64U - count);
    const std::uint64_t high = window(index) >> 32U;
    const unsigned rest = count - 32U;
    return (high << rest) | (window(index + 32U) >> (64U - rest));
  }

  /// Index of the first bit of that level at or after `from`; size_bits() when there is none.
  constexpr std::size_t find(bool level, std::size_t from) const {
    if constexpr (narrow) return narrow_find(level, from);
    while (from < size_bits_) {
      std::uint64_t ahead = window(from);
      if (!level) ahead = ~ahead;
      const auto run = static_cast<std::size_t>(std::countl_zero(ahead));
      if (run < known_bits) return std::min(from + run, size_bits_);
      from += known_bits;
    }
    return size_bits_;
  }

  /// A run of ones at the front, the run of zeros after it, and a 1.
  struct OnesZerosOne {
    std::size_t ones = 0;
    std::size_t zeros = 0;
  };

  /// Measures both runs when they end within 24 bytes; nothing when they do not, when no 1 follows,
  /// or when fewer bytes are stored. It selects instead of branching, for machines where 64-bit
  /// words are cheap and mispredicted branches are not: the length of an ACK cannot be predicted.
  constexpr std::optional<OnesZerosOne> ones_zeros_one() const {
    if (stored_bytes() < (first_bit_ >> 3U) + 24U) return std::nullopt;
    const std::uint8_t* p = bytes_ + (first_bit_ >> 3U);
    const unsigned skip = first_bit_ & 7U;
    // What follows the first 8 bytes is measured at the same time as these.
    const std::uint64_t second = load(p + 8);
    const std::uint64_t none = ones_if(second == 0);
    const std::uint64_t after = second | (load(p + 16) & none);
    const std::uint64_t after_at = 64U + (none & 64U) + leading_zeros(after);
    const std::uint64_t first = load(p);
    const std::uint64_t in_view = ~std::uint64_t{0} >> skip;
    const std::uint64_t zeros_at = leading_zeros(~first & in_view);
    // Every 1 after a 0; the bits before the view count as ones.
    const std::uint64_t rises = first & ~((first >> 1U) | ~(in_view >> 1U));
    const std::uint64_t rise_at = leading_zeros(rises);
    const std::uint64_t one_at = rise_at ^ ((rise_at ^ after_at) & ones_if(rises == 0));
    if ((~first & in_view) == 0 || (rises | after) == 0) return std::nullopt;
    if (one_at - skip >= size_bits_) return std::nullopt;
    return OnesZerosOne{static_cast<std::size_t>(zeros_at - skip),
                        static_cast<std::size_t>(one_at - zeros_at)};
  }

  /// The view from `index` on; empty when `index` is past the end.
  constexpr BitView from(std::size_t index) const {
    BitView rest = *this;
    const std::size_t skip = std::min(index, size_bits_);
    rest.first_bit_ += skip;
    rest.size_bits_ -= skip;
    return rest;
  }

  /// The first `count` bits, or all when there are fewer.
  constexpr BitView first(std::size_t count) const {
    BitView head = *this;
    head.size_bits_ = std::min(count, size_bits_);
    return head;
  }

 private:
  // Registers have 32 bits: there, a 64-bit shift by a variable distance is slow.
  static constexpr bool narrow = sizeof(std::size_t) < 8;

  // Like window(), with at least 25 bits.
  constexpr std::uint32_t narrow_window(std::size_t index) const {
    const std::size_t at = first_bit_ + index;
    const std::size_t stored = stored_bytes();
    if (stored >= 4) {
      const std::size_t base = std::min(at >> 3U, stored - 4U);
      return load32(bytes_ + base) << (at - base * 8U);
    }
    return static_cast<std::uint32_t>(load_short(bytes_, stored) >> 32U) << at;
  }

  // Steps by four bytes from the byte that holds `from`.
  constexpr std::size_t narrow_find(bool level, std::size_t from) const {
    if (from >= size_bits_) return size_bits_;
    const std::uint32_t flip = level ? 0 : ~std::uint32_t{0};
    const std::uint8_t* at = bytes_ + ((first_bit_ + from) >> 3U);
    const std::uint8_t* const end = bytes_ + stored_bytes();
    std::uint32_t wanted = ~std::uint32_t{0} >> ((first_bit_ + from) & 7U);
    for (; end - at >= 4; at += 4) {
      const std::uint32_t ahead = (load32(at) ^ flip) & wanted;
      if (ahead != 0) return found(at, ahead);
      wanted = ~std::uint32_t{0};
    }
    for (; at != end; ++at) {
      const std::uint32_t ahead = ((std::uint32_t{*at} << 24U) ^ flip) & wanted & 0xFF00'0000U;
      if (ahead != 0) return found(at, ahead);
      wanted = ~std::uint32_t{0};
    }
    return size_bits_;
  }

  constexpr std::size_t found(const std::uint8_t* at, std::uint32_t ahead) const {
    const auto run = static_cast<std::size_t>(std::countl_zero(ahead));
    return std::min(static_cast<std::size_t>(at - bytes_) * 8U + run - first_bit_, size_bits_);
  }

  static constexpr std::uint32_t load32(const std::uint8_t* p) {
    return (std::uint32_t{p[0]} << 24U) | (std::uint32_t{p[1]} << 16U) |
           (std::uint32_t{p[2]} << 8U) | std::uint32_t{p[3]};
  }

  constexpr std::size_t stored_bytes() const { return (first_bit_ + size_bits_ + 7U) >> 3U; }

  static constexpr std::uint64_t ones_if(bool yes) { return std::uint64_t{0} - std::uint64_t{yes}; }

  // 63 for 0, too: without that case every machine takes one instruction.
  static constexpr std::uint64_t leading_zeros(std::uint64_t word) {
    return static_cast<std::uint64_t>(std::countl_zero(word | 1U));
  }

  // Not inlined: it is rarely called and would be copied to every reader.
  [[gnu::noinline]] static constexpr std::uint64_t load_short(const std::uint8_t* p,
                                                              std::size_t size) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) value |= std::uint64_t{p[i]} << (56U - 8U * i);
    return value;
  }

  // Written as shifts to be constexpr; compilers make one load and one byte swap of it.
  static constexpr std::uint64_t load(const std::uint8_t* p) {
    return (std::uint64_t{p[0]} << 56U) | (std::uint64_t{p[1]} << 48U) |
           (std::uint64_t{p[2]} << 40U) | (std::uint64_t{p[3]} << 32U) |
           (std::uint64_t{p[4]} << 24U) | (std::uint64_t{p[5]} << 16U) |
           (std::uint64_t{p[6]} << 8U) | std::uint64_t{p[7]};
  }

  const std::uint8_t* bytes_ = nullptr;
  std::size_t first_bit_ = 0;
  std::size_t size_bits_ = 0;
};

}  // namespace biss
