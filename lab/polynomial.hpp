// Polynomials in z whose coefficient of z^w counts patterns with w wrong bits.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace biss::lab {

template <class Integer>
using Polynomial = std::vector<Integer>;

/// Multiplied by 1 + z^step, or by 1 - z^step.
template <class Integer>
Polynomial<Integer> times_binomial(const Polynomial<Integer>& factor, std::size_t step,
                                   bool minus) {
  Polynomial<Integer> product(factor.size() + step);
  std::copy(factor.begin(), factor.end(), product.begin());
  for (std::size_t i = 0; i < factor.size(); ++i) {
    if (minus) {
      product[i + step] -= factor[i];
    } else {
      product[i + step] += factor[i];
    }
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

/// The sum of terms[a] (1 - z^step)^a (1 + z^step)^(N - a), N + 1 being the number of terms.
/// MacWilliams: a counts the bits in which a word of the dual code is 1.
template <class Integer>
Polynomial<Integer> macwilliams_sum(const std::vector<Polynomial<Integer>>& terms,
                                    std::size_t step) {
  Polynomial<Integer> sum = terms.back();
  Polynomial<Integer> plus{Integer(std::uint64_t{1})};
  for (std::size_t a = terms.size() - 1; a-- > 0;) {
    plus = times_binomial(plus, step, false);
    sum = times_binomial(sum, step, true);
    if (!terms[a].empty()) add_to(sum, product_of(terms[a], plus));
  }
  return sum;
}

}  // namespace biss::lab
