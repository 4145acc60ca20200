// Conditions on bits that are XORs of the data bits of a frame: counted by rank over GF(2), never
// sampled. The general sibling of lab/affine.hpp, with memory for a whole frame.
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <vector>

#include "biss/frame/format.hpp"

namespace biss::lab {

/// XOR of some data bits of a frame, and of 1 where the last bit is set.
inline constexpr std::size_t most_unknowns = max_channels * max_data_bits;
using LinearBit = std::bitset<most_unknowns + 1>;

inline LinearBit constant_bit(bool level) {
  LinearBit bit;
  bit[most_unknowns] = level;
  return bit;
}

/// Equations "this bit is 0", reduced as they come.
class Equations {
 public:
  /// False when no data can satisfy it together with the others; nothing else may be asked then.
  bool require_zero(LinearBit bit) {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (bit[pivots_[i]]) bit ^= rows_[i];
    }
    const std::size_t first = bit._Find_first();
    if (first == most_unknowns) return possible_ = false;
    if (first > most_unknowns) return possible_;
    rows_.push_back(bit);
    pivots_.push_back(first);
    return possible_;
  }
  bool require(LinearBit bit, bool level) { return require_zero(bit ^ constant_bit(level)); }

  /// Of all data the share that satisfies them: a power of 1/2, or 0.
  long double share() const {
    long double part = possible_ ? 1 : 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) part /= 2;
    return part;
  }
  bool possible() const { return possible_; }

 private:
  std::vector<LinearBit> rows_;
  std::vector<std::size_t> pivots_;
  bool possible_ = true;
};

}  // namespace biss::lab
