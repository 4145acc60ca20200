// Polynomials over GF(2), for the generator of a checksum. Bit k is the coefficient of x^k.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace biss::identify {

/// The degree is at most 127: a channel has 80 bits.
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

}  // namespace biss::identify
