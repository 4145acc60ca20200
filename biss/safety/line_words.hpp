// Some hundred bits off the line in words of 32, for the second evaluation of a safety frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "biss/safety/line_reader.hpp"

namespace biss::safety_detail {

// Where an offset is known while compiling, so are word and shift: everything is inlined.
template <unsigned Bits, unsigned Sure>
class LineWords {
 public:
  // \pre the line has Sure bits more; those that it does not have are not asked for
  [[gnu::always_inline]] constexpr explicit LineWords(const LineReader& line)
      : words_(line.peek<Bits, Sure>(std::make_index_sequence<size>())) {}

  // `count` bits from `offset` on at the top of a word, zeros below. \pre count is 1…32
  [[gnu::always_inline]] constexpr std::uint32_t top(unsigned offset, unsigned count) const {
    const unsigned skip = offset % 32U;
    std::uint32_t word = words_[offset / 32U] << skip;
    if (skip + count > 32U) word |= words_[offset / 32U + 1U] >> (32U - skip);
    return word & (~0U << (32U - count));
  }

  // `count` bits from `offset` on as a number; 0 without any. \pre count is 0…64
  [[gnu::always_inline]] constexpr std::uint64_t value(unsigned offset, unsigned count) const {
    if (count == 0) return 0;
    if (count <= 32) return top(offset, count) >> (32U - count);
    return (std::uint64_t{top(offset, 32)} << (count - 32U)) |
           (top(offset + 32U, count - 32U) >> (64U - count));
  }

  [[gnu::always_inline]] constexpr bool bit(unsigned offset) const {
    return ((words_[offset / 32U] >> (31U - offset % 32U)) & 1U) != 0;
  }

 private:
  static constexpr std::size_t size = (Bits + 31U) / 32U;
  std::array<std::uint32_t, size> words_;
};

}  // namespace biss::safety_detail
