// A bit string with its own storage of a fixed size.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "biss/base/bits.hpp"

namespace biss {

namespace bits_detail {

// Not constexpr: the compiler names it where append() gets more bits than a word has.
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
  std::array<std::uint8_t, (CapacityBits + 7U) / 8U> bytes_{};
  std::size_t size_bits_ = 0;
  bool overflowed_ = false;
};

}  // namespace biss
