// Polynomials over GF(2), for the generator of a checksum. Bit k is the coefficient of x^k.
// One that has at most 128 coefficients is a number, a longer one a WidePolynomial; the functions
// are the same for both.
#pragma once

#include <array>
#include <bit>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace biss::identify {

/// Of degree 127 at most: a channel has 80 bits.
using Polynomial = unsigned __int128;

/// Of degree 255 at most: the bits of a whole frame.
class WidePolynomial {
 public:
  static constexpr unsigned bits_max = 256;

  constexpr WidePolynomial() = default;
  constexpr WidePolynomial(std::uint64_t low) : parts_{low, 0, 0, 0} {}

  /// The coefficients of x^0 to x^63.
  constexpr std::uint64_t low() const { return parts_[0]; }
  /// \pre power < bits_max
  constexpr bool has(unsigned power) const {
    return (parts_[power / 64] >> (power % 64) & 1U) != 0;
  }
  /// Returns -1 for the polynomial 0.
  constexpr int degree() const {
    for (unsigned i = 4; i-- > 0;) {
      if (parts_[i] != 0) return static_cast<int>(64 * i + 63) - std::countl_zero(parts_[i]);
    }
    return -1;
  }
  /// The coefficients below x^bits.
  constexpr WidePolynomial lower_part(std::size_t bits) const {
    WidePolynomial out;
    for (std::size_t i = 0; i < 4 && 64 * i < bits; ++i) {
      const std::size_t left = bits - 64 * i;
      out.parts_[i] = left >= 64 ? parts_[i] : parts_[i] & ((std::uint64_t{1} << left) - 1U);
    }
    return out;
  }

  constexpr WidePolynomial& operator^=(const WidePolynomial& other) {
    for (std::size_t i = 0; i < 4; ++i) parts_[i] ^= other.parts_[i];
    return *this;
  }
  friend constexpr WidePolynomial operator^(WidePolynomial a, const WidePolynomial& b) {
    return a ^= b;
  }
  /// Times x^power; coefficients beyond bits_max are lost. \pre 0 <= power < bits_max
  friend constexpr WidePolynomial operator<<(const WidePolynomial& p, int power) {
    WidePolynomial out;
    const auto parts = static_cast<std::size_t>(power) / 64;
    const unsigned bits = static_cast<unsigned>(power) % 64;
    for (std::size_t i = parts; i < 4; ++i) {
      out.parts_[i] = p.parts_[i - parts] << bits;
      if (bits != 0 && i > parts) out.parts_[i] |= p.parts_[i - parts - 1] >> (64 - bits);
    }
    return out;
  }
  friend constexpr bool operator==(const WidePolynomial&, const WidePolynomial&) = default;
  // Not <=>, which arrays do not have in every library.
  friend constexpr bool operator<(const WidePolynomial& a, const WidePolynomial& b) {
    return a.parts_ < b.parts_;
  }

 private:
  std::array<std::uint64_t, 4> parts_{};
};

/// Returns -1 for the polynomial 0.
constexpr int degree(Polynomial p) {
  const auto high = static_cast<std::uint64_t>(p >> 64U);
  if (high != 0) return 127 - std::countl_zero(high);
  return 63 - std::countl_zero(static_cast<std::uint64_t>(p));
}
constexpr int degree(const WidePolynomial& p) { return p.degree(); }

/// Whether the coefficient of x^power is 1. \pre power is not negative
constexpr bool has(Polynomial p, int power) { return (p >> power & 1U) != 0; }
constexpr bool has(const WidePolynomial& p, int power) {
  return p.has(static_cast<unsigned>(power));
}

/// A division: p = quotient * divisor + remainder.
template <class P>
struct Divided {
  P quotient{};
  P remainder{};
};

/// \pre divisor is not 0
template <class P>
constexpr Divided<P> divided(P p, const std::type_identity_t<P>& divisor) {
  const int width = degree(divisor);
  Divided<P> result;
  for (int top = degree(p); top >= width; top = degree(p)) {
    p ^= divisor << (top - width);
    result.quotient ^= P{1} << (top - width);
  }
  result.remainder = p;
  return result;
}

/// \pre divisor is not 0
template <class P>
constexpr P remainder(const P& p, const std::type_identity_t<P>& divisor) {
  return divided(p, divisor).remainder;
}

constexpr Polynomial product(Polynomial a, Polynomial b) {
  Polynomial result = 0;
  for (; b != 0; b >>= 1U, a <<= 1U) {
    if ((b & 1U) != 0) result ^= a;
  }
  return result;
}

/// The greatest common divisor; of p and 0 it is p.
template <class P>
constexpr P common_divisor(P a, std::type_identity_t<P> b) {
  while (degree(b) >= 0) {
    const P rest = remainder(a, b);
    a = b;
    b = rest;
  }
  return a;
}

/// Divides by x as often as that leaves no remainder. 0 stays 0.
template <class P>
constexpr P without_x(const P& p) {
  if (degree(p) < 0) return p;
  int power = 0;
  while (!has(p, power)) ++power;
  return divided(p, P{1} << power).quotient;
}

/// All divisors of `p` with a constant term and a degree from `least` to `most`, p itself included
/// where it is one. At most `limit` of them, those of the highest degree first.
/// \pre p is not 0; most is 16 at most
std::vector<std::uint32_t> divisors(Polynomial p, int least, int most, std::size_t limit);

/// The vectors that were added, reduced so that each one has a highest bit of its own.
template <class P>
class Basis {
 public:
  /// \return true where the vector is no sum of vectors added before
  bool add(P vector) {
    for (const P& row : rows_) {
      if (has(vector, degree(row))) vector ^= row;
    }
    if (degree(vector) < 0) return false;
    // Kept in falling order of their highest bits.
    auto at = rows_.begin();
    while (at != rows_.end() && degree(*at) > degree(vector)) ++at;
    rows_.insert(at, vector);
    return true;
  }
  unsigned rank() const { return static_cast<unsigned>(rows_.size()); }

 private:
  std::vector<P> rows_;
};

}  // namespace biss::identify
