// A bit string with its own storage of a fixed size.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "biss/base/big_endian.hpp"
#include "biss/base/bits.hpp"

namespace biss {

namespace bits_detail {

// Not constexpr: the compiler prints this name if append() gets more than 64 bits.
inline void a_word_has_at_most_64_bits() {}

}  // namespace bits_detail

/// Holds up to `CapacityBits` bits, written from the front. Bits that do not fit are dropped and
/// set overflowed().
template <std::size_t CapacityBits>
class BitBuffer {
 public:
  static constexpr std::size_t capacity_bits = CapacityBits;

  constexpr std::size_t size_bits() const { return size_bits_; }
  constexpr bool overflowed() const { return overflowed_; }
  constexpr BitView view() const { return BitView(bytes_, 0, size_bits_); }
  /// The bits as bytes; the unused bits of the last byte are 0.
  constexpr std::span<const std::uint8_t> bytes() const {
    return std::span<const std::uint8_t>(bytes_).first((size_bits_ + 7U) / 8U);
  }

  constexpr void append(bool bit) { append(std::uint64_t{bit}, 1); }

  /// Appends the lowest `count` bits of `word`, most significant first. \pre count is 0…64
  constexpr void append(std::uint64_t word, unsigned count) {
    if (std::is_constant_evaluated() && count > 64) bits_detail::a_word_has_at_most_64_bits();
    const std::size_t left = CapacityBits - size_bits_;
    if (count > left) {
      overflowed_ = true;
      if (left == 0) return;
      word >>= count - left;
      count = static_cast<unsigned>(left);
    }
    if constexpr (sizeof(std::size_t) >= 8) {
      const unsigned used = size_bits_ % 8U;
      const std::size_t at = size_bits_ / 8U;
      if (count > 0 && used + count <= 64 && at + 8U <= bytes_.size()) {
        put(at, word << (64U - count) >> used);
        size_bits_ += count;
        return;
      }
    }
    while (count > 0) {
      const auto room = static_cast<unsigned>(8U - size_bits_ % 8U);
      const unsigned now = std::min(room, count);
      count -= now;
      const auto piece = static_cast<unsigned>((word >> count) & low_mask(now));
      auto& byte = bytes_[size_bits_ / 8U];
      byte = static_cast<std::uint8_t>(byte | (piece << (room - now)));
      size_bits_ += now;
    }
  }

  constexpr void append(const BitView& bits) {
    for (std::size_t at = 0; at < bits.size_bits(); at += 64) {
      const auto now = static_cast<unsigned>(std::min<std::size_t>(bits.size_bits() - at, 64));
      append(bits.word(at, now), now);
    }
  }

  constexpr void append_run(bool level, std::size_t count) {
    if (!level && !overflowed_ && count <= CapacityBits - size_bits_) {
      // All bits after the last one are 0.
      size_bits_ += count;
      return;
    }
    while (count > 0 && !overflowed_) {
      const auto now = static_cast<unsigned>(std::min<std::size_t>(count, 64));
      append(level ? ~std::uint64_t{0} : 0, now);
      count -= now;
    }
  }

  /// \pre index < size_bits()
  constexpr void flip(std::size_t index) {
    auto& byte = bytes_[index / 8U];
    byte = static_cast<std::uint8_t>(byte ^ (0x80U >> (index % 8U)));
  }

  constexpr void truncate(std::size_t size_bits) {
    while (size_bits_ > size_bits) {
      if (view()[size_bits_ - 1U]) flip(size_bits_ - 1U);
      --size_bits_;
    }
  }

  constexpr void clear() {
    bytes_ = {};
    size_bits_ = 0;
    overflowed_ = false;
  }

 private:
  // Ones of eight bytes, the first byte most significant.
  constexpr void put(std::size_t at, std::uint64_t ones) {
    const std::span<std::uint8_t, 8> place(bytes_.data() + at, 8);
    const auto stored = to_big_endian<8>(from_big_endian<8>(place) | ones);
    std::copy(stored.begin(), stored.end(), place.begin());
  }

  std::array<std::uint8_t, (CapacityBits + 7U) / 8U> bytes_{};
  std::size_t size_bits_ = 0;
  bool overflowed_ = false;
};

}  // namespace biss
