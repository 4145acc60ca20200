// Bit strings in transmission order: bit 0 is the first on the line, and the top bit of the first
// byte.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "biss/base/language.hpp"

namespace biss {

/// The lowest `bits` bits set. \pre bits is 0…64
constexpr std::uint64_t low_mask(unsigned bits) {
  return bits == 0 ? 0 : ~std::uint64_t{0} >> (64U - bits);
}

namespace bits_detail {

// Limits a distance from memory that may have had a fault, so that the shift gives wrong bits at
// worst. With registers of 64 bits the mask costs nothing; with registers of 32 bits there is no
// mask.
constexpr unsigned shift_of(std::size_t distance) {
  return static_cast<unsigned>(sizeof(std::size_t) < 8 ? distance : distance & 63U);
}
constexpr std::uint64_t left(std::uint64_t word, std::size_t distance) {
  return word << shift_of(distance);
}
constexpr std::uint64_t right(std::uint64_t word, std::size_t distance) {
  return word >> shift_of(distance);
}

}  // namespace bits_detail

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
    if (stored >= 8) return window_of_many(index);
    return load_short(bytes_, stored) << at;
  }

  /// Like window(), if at least 8 bytes are stored.
  [[gnu::always_inline]] constexpr std::uint64_t window_of_many(std::size_t index) const {
    const std::size_t at = first_bit_ + index;
    // Near the end read the last 8 bytes instead of stepping over it.
    const std::size_t base = std::min(at >> 3U, stored_bytes() - 8U);
    return bits_detail::left(load(bytes_ + base), at - base * 8U);
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

  /// The first 64 bits, or all bits of a shorter view, the first one topmost. A short view that
  /// begins within a byte may lack up to 7 of its bits. The bits after them are undefined. The
  /// result is 0 if fewer than 4 bytes are stored.
  [[gnu::always_inline]] constexpr std::uint64_t head() const {
    if (size_bits_ < 64) return short_head(bytes_, first_bit_, size_bits_);
    const std::uint8_t* const p = bytes_ + (first_bit_ >> 3U);
    const unsigned skipped = first_bit_ & 7U;
    return skipped == 0 ? load(p) : load(p) << skipped | std::uint64_t{p[8]} >> (8U - skipped);
  }
  /// The bits of head() that a view of fewer than 64 bits can have.
  constexpr std::size_t head_bits() const { return 64U - (first_bit_ & 7U); }

  /// head() and find_one_after_head() for registers of 32 bits. The head has at least 25 bits, and
  /// 32 if the view begins at the start of a byte. The search starts after the first 4 bytes. If
  /// there is no 1, it returns size_bits() or more.
  [[gnu::always_inline]] constexpr std::uint32_t narrow_head() const {
    const std::uint8_t* const p = bytes_ + (first_bit_ >> 3U);
    if (stored_bytes() - (first_bit_ >> 3U) < 4) return 0;
    return load32(p) << (first_bit_ & 7U);
  }
  constexpr unsigned narrow_head_bits() const {
    return 32U - static_cast<unsigned>(first_bit_ & 7U);
  }
  [[gnu::always_inline]] constexpr std::size_t narrow_find_one_after_head() const {
    const std::uint8_t* const p = bytes_ + (first_bit_ >> 3U);
    const std::size_t stored = stored_bytes() - (first_bit_ >> 3U);
    const std::uint8_t* const end = p + (stored & ~std::size_t{3});
    for (const std::uint8_t* at = p + 4; at < end; at += 4) {
      const std::uint32_t word = load32(at);
      if (word == 0) continue;
      return static_cast<std::size_t>(at - bytes_) * 8U - first_bit_ +
             static_cast<std::size_t>(std::countl_zero(word));
    }
    return narrow_find(true, static_cast<std::size_t>(end - bytes_) * 8U - first_bit_);
  }

  /// find(true, head_bits()), without branches within the next 16 bytes: the length of an ACK
  /// cannot be predicted, and operations on 64-bit words cost less than mispredicted branches.
  [[gnu::always_inline]] constexpr std::size_t find_one_after_head() const {
    const std::uint8_t* const p = bytes_ + (first_bit_ >> 3U);
    const std::size_t stored = stored_bytes() - (first_bit_ >> 3U);
    std::size_t at = 8;
    if (stored >= 24) {
      const std::uint64_t second = load(p + 8);
      const std::uint64_t none = ones_if(second == 0);
      const std::uint64_t after = second | (load(p + 16) & none);
      at = static_cast<std::size_t>(64U + (none & 64U) + leading_zeros(after));
      if (after == 0) at = find_one_far(p, 24, stored);
    } else {
      at = find_one_far(p, 8, stored);
    }
    return std::min(at - (first_bit_ & 7U), size_bits_);
  }

  /// All bits after the first 64, combined with OR in any order: 0 if is_low_from(64).
  /// \pre the view is whole bytes
  [[gnu::always_inline]] constexpr std::uint64_t ones_after_8_bytes() const {
    const std::uint8_t* const p = bytes_ + (first_bit_ >> 3U);
    const std::size_t stored = size_bits_ >> 3U;
    if (stored <= 8) return 0;
    if (stored < 16) return load(p + stored - 8U) << (8U * (16U - stored));
    // Overlapping words, without a loop for the usual lengths.
    std::uint64_t ones = load_any_order(p + 8) | load_any_order(p + stored - 8U);
    if (stored <= 24) return ones;
    ones |= load_any_order(p + 16) | load_any_order(p + stored - 16U);
    return stored <= 40 ? ones : ones | ones_far(p, stored - 16U);
  }

  /// Whether all bits from `index` on are 0; true if there are no such bits.
  [[gnu::always_inline]] constexpr bool is_low_from(std::size_t index) const {
    if (index >= size_bits_) return true;
    const std::size_t at = first_bit_ + index;
    const std::size_t stored = stored_bytes();
    if constexpr (!narrow) {
      if (stored >= 8) [[likely]]
        return is_low_by_words(at, stored);
    }
    return is_low_by_bytes(bytes_ + (at >> 3U), at & 7U, stored - (at >> 3U), pad_bits());
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

  // Steps by four bytes from the byte that holds `from`. Not inlined: it is long, and there are
  // several callers.
  [[gnu::noinline]] constexpr std::size_t narrow_find(bool level, std::size_t from) const {
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

  // Unused bits of the last byte.
  constexpr unsigned pad_bits() const {
    return static_cast<unsigned>((0U - (first_bit_ + size_bits_)) & 7U);
  }

  // How many words are read depends on their number only, not on the place.
  [[gnu::always_inline]] constexpr bool is_low_by_words(std::size_t at, std::size_t stored) const {
    const std::size_t last = stored - 8U;
    const std::size_t first = std::min(at >> 3U, last);
    const std::uint64_t kept = ~std::uint64_t{0} << pad_bits();
    const std::uint64_t is_last = ones_if(first == last);
    std::uint64_t ones = load(bytes_ + first) & (~std::uint64_t{0} >> (at - first * 8U));
    ones &= kept | ~is_last;
    ones |= load(bytes_ + last) & kept & ~is_last;
    for (std::size_t i = 8; i < last; i += 8)
      ones |= load_any_order(bytes_ + i) & ones_if(i > first);
    return ones == 0;
  }

  // Whether `size` bytes (at least 1) are low, without `skip` bits at the front and `pad` bits at
  // the end. The order of the bytes in a word does not matter.
  static constexpr bool is_low_by_bytes(const std::uint8_t* at, std::size_t skip, std::size_t size,
                                        unsigned pad) {
    const std::uint8_t* const last = at + (size - 1U);
    const unsigned head = 0xFFU >> skip;
    const unsigned tail = (0xFFU << pad) & 0xFFU;
    if (at == last) return (*at & head & tail) == 0;
    if (((*at++ & head) | (*last & tail)) != 0) return false;
    for (; last - at >= 4; at += 4) {
      const std::uint32_t word = std::uint32_t{at[0]} | (std::uint32_t{at[1]} << 8U) |
                                 (std::uint32_t{at[2]} << 16U) | (std::uint32_t{at[3]} << 24U);
      if (word != 0) return false;
    }
    for (; at != last; ++at) {
      if (*at != 0) return false;
    }
    return true;
  }

  // The words from byte 24 to byte `end` combined with OR. Not inlined, because views of this
  // length are rare.
  [[gnu::noinline]] static constexpr std::uint64_t ones_far(const std::uint8_t* p,
                                                            std::size_t end) {
    std::uint64_t ones = 0;
    for (std::size_t i = 24; i < end; i += 8) ones |= load_any_order(p + i);
    return ones;
  }

  // The first 1 of `size` bytes from byte `at` (at least 8) on; size * 8 if there is none. Not
  // inlined. The view is not an argument, so that it stays in registers.
  [[gnu::noinline]] static constexpr std::size_t find_one_far(const std::uint8_t* p, std::size_t at,
                                                              std::size_t size) {
    for (; at + 8U <= size; at += 8) {
      const std::uint64_t word = load(p + at);
      if (word != 0) return at * 8U + static_cast<std::size_t>(std::countl_zero(word));
    }
    if (at >= size) return size * 8U;
    // The last bytes, after some that are shifted out.
    const std::size_t missing = at + 8U - size;
    const std::uint64_t word = load(p + size - 8U) << (8U * missing);
    if (word == 0) return size * 8U;
    return at * 8U + static_cast<std::size_t>(std::countl_zero(word));
  }

  [[gnu::always_inline]] static constexpr std::uint32_t load32(const std::uint8_t* p) {
    return (std::uint32_t{p[0]} << 24U) | (std::uint32_t{p[1]} << 16U) |
           (std::uint32_t{p[2]} << 8U) | std::uint32_t{p[3]};
  }

  constexpr std::size_t stored_bytes() const { return (first_bit_ + size_bits_ + 7U) >> 3U; }

  static constexpr std::uint64_t ones_if(bool yes) { return std::uint64_t{0} - std::uint64_t{yes}; }

  // 63 for 0, too: without a special case for 0 every machine takes one instruction.
  static constexpr std::uint64_t leading_zeros(std::uint64_t word) {
    return static_cast<std::uint64_t>(std::countl_zero(word | 1U));
  }

  // head() of fewer than 64 bits: two halves that overlap, of up to 8 bytes. Not inlined. The view
  // is not an argument, so that it stays in registers.
  [[gnu::noinline]] static constexpr std::uint64_t short_head(const std::uint8_t* p,
                                                              std::size_t first_bit,
                                                              std::size_t size_bits) {
    p += first_bit >> 3U;
    const auto stored = std::min<std::size_t>(((first_bit & 7U) + size_bits + 7U) >> 3U, 8);
    if (stored < 4) return 0;
    const std::uint64_t end = std::uint64_t{load32(p + stored - 4)} << (64U - 8U * stored);
    return ((std::uint64_t{load32(p)} << 32U) | end) << (first_bit & 7U);
  }

  // Not inlined: it is rarely called and would be copied to every reader.
  [[gnu::noinline]] static constexpr std::uint64_t load_short(const std::uint8_t* p,
                                                              std::size_t size) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) value |= std::uint64_t{p[i]} << (56U - 8U * i);
    return value;
  }

  // Eight bytes, the first one most significant.
  [[gnu::always_inline]] static constexpr std::uint64_t load(const std::uint8_t* p) {
    if constexpr (loads_words) {
      if (!std::is_constant_evaluated()) return __builtin_bswap64(load_as_stored(p));
    }
    return load_by_bytes(p);
  }

  // Loads bytes in any order, for tests in which only the presence of ones matters.
  [[gnu::always_inline]] static constexpr std::uint64_t load_any_order(const std::uint8_t* p) {
    if constexpr (loads_words) {
      if (!std::is_constant_evaluated()) return load_as_stored(p);
    }
    return load_by_bytes(p);
  }

  // Compilers turn this into one load, too, but not if several calls are combined.
  [[gnu::always_inline]] static constexpr std::uint64_t load_by_bytes(const std::uint8_t* p) {
    return (std::uint64_t{p[0]} << 56U) | (std::uint64_t{p[1]} << 48U) |
           (std::uint64_t{p[2]} << 40U) | (std::uint64_t{p[3]} << 32U) |
           (std::uint64_t{p[4]} << 24U) | (std::uint64_t{p[5]} << 16U) |
           (std::uint64_t{p[6]} << 8U) | std::uint64_t{p[7]};
  }

  [[gnu::always_inline]] static std::uint64_t load_as_stored(const std::uint8_t* p) {
    std::uint64_t word = 0;
    __builtin_memcpy(&word, p, sizeof(word));
    return word;
  }

#if defined(__GNUC__)
  static constexpr bool loads_words = !narrow && std::endian::native == std::endian::little;
#else
  static constexpr bool loads_words = false;
#endif

  const std::uint8_t* bytes_ = nullptr;
  std::size_t first_bit_ = 0;
  std::size_t size_bits_ = 0;
};

}  // namespace biss
