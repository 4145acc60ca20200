// Linear equations over GF(2) for bits that are XORs of random bits and a constant.
#pragma once

#include <bitset>
#include <cmath>
#include <cstddef>
#include <vector>

namespace biss::lab {

/// XOR of some of `Unknowns` bits, and of 1 if the last bit is set.
template <std::size_t Unknowns>
using LinearBit = std::bitset<Unknowns + 1>;

/// The first unknown of a bit; beyond the last one if there is none.
template <class Bits>
std::size_t first_of(const Bits& bits) {
  if constexpr (requires { bits._Find_first(); }) {
    return bits._Find_first();
  } else {
    std::size_t first = 0;
    while (first < bits.size() && !bits[first]) ++first;
    return first;
  }
}

/// Equations "this bit is 0", reduced when they are added.
template <std::size_t Unknowns>
class Equations {
 public:
  using Bit = LinearBit<Unknowns>;

  void require_zero(Bit bit) {
    if (!possible_) return;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (bit[pivots_[i]]) bit ^= rows_[i];
    }
    const std::size_t first = first_of(bit);
    if (first < Unknowns) {
      rows_.push_back(bit);
      pivots_.push_back(first);
    } else {
      possible_ = first > Unknowns;
    }
  }
  void require(Bit bit, bool level) {
    if (level) bit.flip(Unknowns);
    require_zero(bit);
  }

  /// Whether the equations have a solution.
  bool possible() const { return possible_; }
  /// The number of independent equations. \pre possible()
  unsigned rank() const { return static_cast<unsigned>(rows_.size()); }
  /// The share of all values of the unknowns that are solutions: 2^-rank(), or 0.
  long double share() const { return possible_ ? std::ldexp(1.0L, -static_cast<int>(rank())) : 0; }

 private:
  std::vector<Bit> rows_;
  std::vector<std::size_t> pivots_;
  bool possible_ = true;
};

}  // namespace biss::lab
