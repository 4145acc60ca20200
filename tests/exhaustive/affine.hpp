// Counts positions without sampling. Every bit on the line is a sum of position bits and a
// constant. The positions for which certain bits have certain levels are therefore the solutions of
// linear equations over GF(2).
#pragma once

#include <cstdint>
#include <vector>

#include "tests/core/random.hpp"
#include "tests/oracle/oracle.hpp"

namespace exhaustive {

/// The sum of the position's bits in `mask` and a constant.
struct AffineBit {
  std::uint64_t mask = 0;
  bool constant = false;

  AffineBit operator+(const AffineBit& other) const {
    return {mask ^ other.mask, constant != other.constant};
  }
  bool at(std::uint64_t position) const;
};

using AffineBits = std::vector<AffineBit>;

/// The checksum of affine data, by the oracle's polynomial division.
AffineBits affine_checksum(const oracle::Checksum& checksum, const AffineBits& data);

/// The positions of some width that satisfy some equations.
class Positions {
 public:
  explicit Positions(unsigned bits) : bits_(bits) {}

  /// The subset for which the bit has this level.
  Positions with(AffineBit bit, bool level) const;
  bool contains(std::uint64_t position) const;
  /// The number of solutions: a power of two, or 0.
  std::uint64_t count() const;
  /// A random solution. \pre there is one
  std::uint64_t any(biss::test::Random& random) const;

 private:
  unsigned bits_;
  bool none_ = false;
  // Each equation states that its bit is 0. The lowest set bit of a mask is in no other mask.
  AffineBits equations_;
};

}  // namespace exhaustive
