// Polynomials over GF(2), for the generator of a checksum. Bit k is the coefficient of x^k.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

namespace biss::identify {

/// Of degree 127 at most: a channel has 80 bits.
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

/// Quotient of a division without a remainder. \pre divisor divides p and is not 0
constexpr Polynomial quotient(Polynomial p, Polynomial divisor) {
  const int width = degree(divisor);
  Polynomial result = 0;
  for (int top = degree(p); top >= width; top = degree(p)) {
    p ^= divisor << (top - width);
    result |= Polynomial{1} << (top - width);
  }
  return result;
}

constexpr Polynomial product(Polynomial a, Polynomial b) {
  Polynomial result = 0;
  for (; b != 0; b >>= 1U, a <<= 1U) {
    if ((b & 1U) != 0) result ^= a;
  }
  return result;
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

/// Divides by x as often as that leaves no remainder. 0 stays 0.
constexpr Polynomial without_x(Polynomial p) {
  while (p != 0 && (p & 1U) == 0) p >>= 1U;
  return p;
}

/// All divisors of `p` with a constant term and a degree from `least` to `most`, p itself included
/// where it is one. At most `limit` of them, those of the highest degree first.
/// \pre p is not 0; most is 16 at most
std::vector<std::uint32_t> divisors(Polynomial p, int least, int most, std::size_t limit);

/// The vectors that were added, reduced so that each one has a highest bit of its own.
class Basis {
 public:
  /// \return true where the vector is no sum of vectors added before
  bool add(Polynomial vector) {
    for (const Polynomial row : rows_) {
      if (((vector >> degree(row)) & 1U) != 0) vector ^= row;
    }
    if (vector == 0) return false;
    // Kept in falling order of their highest bits.
    auto at = rows_.begin();
    while (at != rows_.end() && degree(*at) > degree(vector)) ++at;
    rows_.insert(at, vector);
    return true;
  }
  unsigned rank() const { return static_cast<unsigned>(rows_.size()); }

 private:
  std::vector<Polynomial> rows_;
};

}  // namespace biss::identify
