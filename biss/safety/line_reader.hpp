// Bits off the line for the second evaluation of a safety frame: no code shared with BitView's.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/base/bits.hpp"

namespace biss::safety_detail {

class LineReader {
 public:
  constexpr explicit LineReader(const BitView& bits)
      : bytes_(bits.stored()),
        origin_(bits.first_bit_of_stored()),
        end_(origin_ + bits.size_bits()),
        at_(origin_) {}

  // Of the bits, from 0.
  constexpr std::size_t at() const { return at_ - origin_; }
  constexpr std::size_t left() const { return end_ - at_; }

  // Steps over all bits that are the complement of `level`; false at the end.
  constexpr bool skip_to(bool level) {
    while (at_ < end_) {
      const std::uint32_t ahead = look(at_) ^ (level ? 0U : ~0U);
      if (ahead != 0) {
        at_ += static_cast<unsigned>(std::countl_zero(ahead));
        return at_ < end_;
      }
      at_ += 32;
    }
    at_ = end_;
    return false;
  }

  // The next `count` bits at the top of a word, zeros below.
  // \pre count is 1…32 and not above left()
  constexpr std::uint32_t take(unsigned count) {
    const std::uint32_t word = look(at_) & (~0U << (32U - count));
    at_ += count;
    return word;
  }

 private:
  // 32 bits, the first one at the top; undefined behind the end.
  constexpr std::uint32_t look(std::size_t at) const {
    const std::size_t first = at / 8U;
    const auto skip = static_cast<unsigned>(at % 8U);
    if (first + 5U > bytes_.size()) return look_near_end(first, skip);
    const std::uint8_t* byte = bytes_.data() + first;
    std::uint32_t word = 0;
    for (unsigned i = 0; i < 4; ++i) word = (word << 8U) | byte[i];
    return (word << skip) | (std::uint32_t{byte[4]} >> (8U - skip));
  }

  [[gnu::noinline]] constexpr std::uint32_t look_near_end(std::size_t first, unsigned skip) const {
    std::uint64_t word = 0;
    for (std::size_t i = first; i < first + 5U; ++i) {
      word = (word << 8U) | (i < bytes_.size() ? bytes_[i] : 0U);
    }
    return static_cast<std::uint32_t>(word >> (8U - skip));
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t origin_;
  std::size_t end_;
  std::size_t at_;
};

}  // namespace biss::safety_detail
