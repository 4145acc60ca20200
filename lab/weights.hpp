// How many error patterns of each weight (number of wrong bits) a checksum accepts: exact, by
// MacWilliams' theorem over all words of the dual code.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "biss/crc/spec.hpp"
#include "biss/frame/format.hpp"

namespace biss::lab {

/// Numbers of error patterns of one word: less than 2^80.
using Count = unsigned __int128;
using SignedCount = __int128;

/// A polynomial in z; the coefficient of z^w counts patterns with w wrong bits.
template <class Integer>
using Polynomial = std::vector<Integer>;

/// Multiplied by 1 + z^step, or by 1 - z^step.
template <class Integer>
Polynomial<Integer> times_binomial(const Polynomial<Integer>& factor, std::size_t step,
                                   bool minus) {
  Polynomial<Integer> product = factor;
  product.resize(factor.size() + step);
  for (std::size_t i = 0; i < factor.size(); ++i) {
    minus ? product[i + step] -= factor[i] : product[i + step] += factor[i];
  }
  return product;
}

template <class Integer>
Polynomial<Integer> product_of(const Polynomial<Integer>& a, const Polynomial<Integer>& b) {
  Polynomial<Integer> product(a.size() + b.size() - 1);
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] == Integer{}) continue;
    for (std::size_t k = 0; k < b.size(); ++k) product[i + k] += a[i] * b[k];
  }
  return product;
}

template <class Integer>
void add_to(Polynomial<Integer>& sum, const Polynomial<Integer>& more) {
  if (sum.size() < more.size()) sum.resize(more.size());
  for (std::size_t i = 0; i < more.size(); ++i) sum[i] += more[i];
}

/// The sum of terms[a] (1 - z^step)^a (1 + z^step)^(N - a); N + 1 is the number of terms. In
/// MacWilliams' theorem, a counts the bits in which a word of the dual code is 1.
template <class Integer>
Polynomial<Integer> macwilliams_sum(const std::vector<Polynomial<Integer>>& terms,
                                    std::size_t step) {
  Polynomial<Integer> sum = terms.back();
  Polynomial<Integer> plus{Integer(1)};
  for (std::size_t a = terms.size() - 1; a-- > 0;) {
    plus = times_binomial(plus, step, false);
    sum = times_binomial(sum, step, true);
    if (!terms[a].empty()) add_to(sum, product_of(terms[a], plus));
  }
  return sum;
}

/// A word as it is protected: data bits, then the checksum. Only the polynomial matters for the
/// detection; start value and inversion do not. Without a checksum (crc_bits 0), every pattern is
/// accepted.
struct WordCode {
  std::uint32_t polynomial = 0;  ///< full form
  unsigned crc_bits = 0;         ///< 0…16
  unsigned data_bits = 0;        ///< 1…64

  constexpr unsigned bits() const { return data_bits + crc_bits; }
};

constexpr WordCode code_of(const ChannelFormat& channel) {
  return {channel.crc.polynomial, channel.crc.width_bits, channel.data_bits};
}

/// Data bits of an error pattern that are given: the bits of `mask` are as in `value`. Bits are
/// counted from the last data bit, as in Field.
struct FixedBits {
  std::uint64_t mask = 0;
  std::uint64_t value = 0;
};

/// For each word h of the dual code, 2^crc_bits in all: the data bits in which it is 1. The bits of
/// h itself belong to the checksum.
std::vector<std::uint64_t> dual_words(const WordCode& code);

/// A[w]: the number of patterns of w wrong bits that the checksum accepts, w = 0…bits(). A[0] is 1,
/// the pattern without a wrong bit. With fixed bits: only patterns that have these values.
/// \pre the polynomial is in full form
Polynomial<Count> weights_of(const WordCode& code, const FixedBits& fixed = {});

/// The smallest number of wrong bits, from 1, that can be accepted; 0 if there is none.
unsigned min_distance(const Polynomial<Count>& weights);

}  // namespace biss::lab
