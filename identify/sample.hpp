// The frames of a capture from which the format is inferred, and polynomials over GF(2), for the
// generator of a checksum.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "biss/base/bit_buffer.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/format.hpp"

namespace biss::identify {

/// Bit k is the coefficient of x^k. The degree is at most 127: a channel has 80 bits.
using Polynomial = unsigned __int128;

/// Returns -1 for the polynomial 0.
constexpr int degree(Polynomial p) {
  const auto high = static_cast<std::uint64_t>(p >> 64U);
  if (high != 0) return 127 - std::countl_zero(high);
  return 63 - std::countl_zero(static_cast<std::uint64_t>(p));
}

/// \pre divisor is not 0
constexpr Polynomial remainder(Polynomial p, Polynomial divisor) {
  const int width = degree(divisor);
  for (int top = degree(p); top >= width; top = degree(p)) p ^= divisor << (top - width);
  return p;
}

/// The greatest common divisor; of p and 0 it is p.
constexpr Polynomial common_divisor(Polynomial a, Polynomial b) {
  while (b != 0) {
    const Polynomial rest = remainder(a, b);
    a = b;
    b = rest;
  }
  return a;
}

/// Removes all factors x. 0 stays 0.
constexpr Polynomial without_x(Polynomial p) {
  while (p != 0 && (p & 1U) == 0) p >>= 1U;
  return p;
}

/// The vectors that were added, reduced so that each one has a highest bit of its own.
class Basis {
 public:
  void add(Polynomial vector) {
    for (int top = degree(vector); top >= 0; top = degree(vector)) {
      Polynomial& row = rows_[static_cast<std::size_t>(top)];
      if (row == 0) {
        row = vector;
        ++rank_;
        return;
      }
      vector ^= row;
    }
  }
  /// How many of the vectors are not sums of others.
  unsigned rank() const { return rank_; }

 private:
  // By their highest bit.
  std::array<Polynomial, 128> rows_{};
  unsigned rank_ = 0;
};

/// A frame whose structure is good: the bits after CDS, as received.
struct Sample {
  /// Number of its request cycle.
  std::uint64_t cycle = 0;
  Picoseconds time{};
  /// As received; 1 is an answer only if `asked`.
  bool cds = false;
  /// A control frame of the master may run, or its CDM was not seen.
  bool asked = false;
  BitBuffer<max_payload_bits + 1> bits;
};

/// `count` bits after CDS, from `begin` on, as a polynomial, the first one on the line with the highest
/// power. \pre the sample has these bits; 128 at most
inline Polynomial polynomial_of(const Sample& sample, unsigned begin, unsigned count) {
  const BitView bits = sample.bits.view();
  const unsigned low = std::min(count, 64U);
  const unsigned high = count - low;
  return Polynomial{bits.word(begin, high)} << low | bits.word(begin + high, low);
}

}  // namespace biss::identify
