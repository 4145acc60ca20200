// Integers that hold any number of error patterns of a pair of words: 2^160 at most.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace biss::lab {

/// Numbers of error patterns of one word: less than 2^80.
using Count = unsigned __int128;
using SignedCount = __int128;

/// An unsigned integer of 256 bits; it wraps around, so that a difference may be formed in any
/// order as long as the result is not negative.
class Wide {
 public:
  constexpr Wide() = default;
  constexpr Wide(std::uint64_t value) : limbs_{value, 0, 0, 0} {}
  constexpr Wide(Count value)
      : limbs_{static_cast<std::uint64_t>(value), static_cast<std::uint64_t>(value >> 64U), 0, 0} {}
  /// The two's complement of a negative one.
  constexpr Wide(std::int64_t value) : limbs_{static_cast<std::uint64_t>(value), 0, 0, 0} {
    for (std::size_t i = 1; value < 0 && i < size; ++i) limbs_[i] = ~std::uint64_t{0};
  }

  constexpr bool operator==(const Wide&) const = default;

  constexpr Wide& operator+=(const Wide& other) {
    Count carry = 0;
    for (std::size_t i = 0; i < size; ++i) {
      carry += Count{limbs_[i]} + other.limbs_[i];
      limbs_[i] = static_cast<std::uint64_t>(carry);
      carry >>= 64U;
    }
    return *this;
  }
  constexpr Wide& operator-=(const Wide& other) {
    Wide negative;
    for (std::size_t i = 0; i < size; ++i) negative.limbs_[i] = ~other.limbs_[i];
    *this += negative;
    return *this += Wide(std::uint64_t{1});
  }
  friend constexpr Wide operator*(const Wide& a, const Wide& b) {
    Wide product;
    for (std::size_t i = 0; i < size; ++i) {
      Count carry = 0;
      for (std::size_t k = 0; a.limbs_[i] != 0 && i + k < size; ++k) {
        carry += Count{a.limbs_[i]} * b.limbs_[k] + product.limbs_[i + k];
        product.limbs_[i + k] = static_cast<std::uint64_t>(carry);
        carry >>= 64U;
      }
    }
    return product;
  }
  /// Divided by 2^bits. \pre bits is 1…63
  constexpr Wide halved(unsigned bits) const {
    Wide out;
    for (std::size_t i = 0; i < size; ++i) {
      out.limbs_[i] = limbs_[i] >> bits;
      if (i + 1 < size) out.limbs_[i] |= limbs_[i + 1] << (64U - bits);
    }
    return out;
  }
  /// Rounded to the 64 bits of a long double.
  long double value() const {
    long double sum = 0;
    for (std::size_t i = size; i-- > 0;) {
      sum = std::ldexp(sum, 64) + static_cast<long double>(limbs_[i]);
    }
    return sum;
  }

 private:
  static constexpr std::size_t size = 4;
  std::array<std::uint64_t, size> limbs_{};
};

}  // namespace biss::lab
