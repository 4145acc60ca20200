// Bits off the line for the second evaluation of a safety frame: no code shared with BitView's.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "biss/base/bits.hpp"

namespace biss::safety_detail {

class LineReader {
 public:
  constexpr explicit LineReader(const BitView& bits)
      : bytes_(bits.stored()),
        origin_(bits.first_bit_of_stored()),
        end_(origin_ + bits.size_bits()),
        at_(origin_) {}

  constexpr std::size_t left() const { return end_ - at_; }

  // Late zeros, ones, the zeros of ACK, and so to START.
  struct Runs {
    std::size_t late = 0;
    std::size_t ones = 0;
    std::size_t zeros = 0;
  };

  // Goes to START, or to the end where there is none.
  [[gnu::always_inline]] constexpr Runs find_start() {
    Runs runs;
    // Nearly always the ones end within the first look.
    const std::uint32_t front = left() < 32U ? 0 : look(at_);
    const auto ones = static_cast<unsigned>(std::countl_one(front));
    if (ones == 0 || ones == 32) {
      runs.late = run(false);
      runs.ones = run(true);
    } else {
      runs.ones = ones;
      at_ += ones;
    }
    runs.zeros = run(false);
    return runs;
  }

  // The next `Bits` bits in words of 32, the first one at the top; undefined behind the end.
  // \pre left() is at least Sure
  template <unsigned Bits, unsigned Sure, std::size_t... I>
  [[gnu::always_inline]] constexpr auto peek(std::index_sequence<I...>) const {
    const std::size_t first = at_ / 8U;
    const auto skip = static_cast<unsigned>(at_ % 8U);
    // The first bit may be the last one of its byte.
    constexpr std::size_t size = (Bits + 7U + 31U) / 32U;
    std::array<std::uint32_t, sizeof...(I) + 1U> words{
        (I < size ? four_at<(32U * I + 25U <= Sure)>(first + 4U * I) : 0U)...};
    if constexpr (size > sizeof...(I)) words[size - 1U] = four_at<false>(first + 4U * (size - 1U));
    return std::array<std::uint32_t, sizeof...(I)>{
        ((words[I] << skip) | (words[I + 1U] >> 1U >> (31U - skip)))...};
  }

 private:
  // Steps over the bits of that level, the end at most, and counts them.
  [[gnu::always_inline]] constexpr std::size_t run(bool level) {
    const std::uint32_t all = level ? ~0U : 0U;
    const std::size_t from = at_;
    if (at_ >= end_) return 0;
    std::uint32_t other = look(at_) ^ all;
    if (other == 0) {
      // From here on by whole bytes; their first bits are known to be of the level.
      std::size_t byte = at_ / 8U + 4U;
      while (byte + 4U <= bytes_.size() && (other = four(byte) ^ all) == 0) byte += 4U;
      if (other == 0) other = rest_from(byte) ^ all;
      at_ = byte * 8U;
    }
    at_ = std::min(at_ + static_cast<unsigned>(std::countl_zero(other)), end_);
    return at_ - from;
  }

  // Zeros behind the end, unless there is none to be met.
  template <bool Inside>
  [[gnu::always_inline]] constexpr std::uint32_t four_at(std::size_t first) const {
    if (Inside || first + 4U <= bytes_.size()) return four(first);
    return rest_from(first);
  }
  constexpr std::uint32_t four(std::size_t first) const {
    const std::uint8_t* byte = bytes_.data() + first;
    return (std::uint32_t{byte[0]} << 24U) | (std::uint32_t{byte[1]} << 16U) |
           (std::uint32_t{byte[2]} << 8U) | byte[3];
  }

  [[gnu::always_inline]] constexpr std::uint32_t look(std::size_t at) const {
    const std::size_t first = at / 8U;
    const auto skip = static_cast<unsigned>(at % 8U);
    if (first + 5U > bytes_.size()) return rest_from(first) << skip;
    return (four(first) << skip) | (std::uint32_t{bytes_[first + 4U]} >> (8U - skip));
  }

  // Four bytes at most, zeros behind them.
  [[gnu::noinline]] constexpr std::uint32_t rest_from(std::size_t first) const {
    std::uint32_t word = 0;
    for (unsigned room = 32; first < bytes_.size(); ++first) {
      room -= 8U;
      word |= std::uint32_t{bytes_[first]} << room;
    }
    return word;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t origin_;
  std::size_t end_;
  std::size_t at_;
};

}  // namespace biss::safety_detail
