#include "lab/residual.hpp"

#include <algorithm>
#include <cstddef>
#include <queue>
#include <utility>
#include <vector>

namespace biss::lab {
namespace {

// The probability over a part of 0…1 in Bernstein form: the first and the last coefficient are the
// values at the ends, and the probability is nowhere higher than the highest coefficient.
struct Piece {
  long double low = 0;
  long double high = 1;
  std::vector<long double> coefficients;

  long double bound() const { return *std::max_element(coefficients.begin(), coefficients.end()); }
  bool operator<(const Piece& other) const { return bound() < other.bound(); }
};

// count[w] p^w (1-p)^(bits-w) is a Bernstein polynomial without its binomial coefficient.
Piece whole_of(const Undetected& undetected) {
  Piece piece;
  const std::size_t bits = undetected.size() - 1;
  long double binomial = 1;
  for (std::size_t w = 0; w <= bits; ++w) {
    piece.coefficients.push_back(undetected[w] / binomial);
    binomial = binomial * static_cast<long double>(bits - w) / static_cast<long double>(w + 1);
  }
  return piece;
}

// Both halves, by de Casteljau's rule. All numbers are positive, so nothing cancels.
std::pair<Piece, Piece> halves_of(const Piece& piece) {
  const long double middle = (piece.low + piece.high) / 2;
  Piece left{piece.low, middle, piece.coefficients};
  Piece right{middle, piece.high, piece.coefficients};
  const std::size_t last = piece.coefficients.size() - 1;
  for (std::size_t level = 1; level <= last; ++level) {
    for (std::size_t i = 0; i <= last - level; ++i) {
      right.coefficients[i] = (right.coefficients[i] + right.coefficients[i + 1]) / 2;
    }
    left.coefficients[level] = right.coefficients[0];
  }
  return {std::move(left), std::move(right)};
}

// Ternary search: the peak may be flat, so a good probability alone does not locate it.
long double climb(const Undetected& undetected, long double low, long double high) {
  for (int i = 0; i < 200; ++i) {
    const long double left = low + (high - low) / 3;
    const long double right = high - (high - low) / 3;
    if (probability(undetected, left) < probability(undetected, right)) {
      low = left;
    } else {
      high = right;
    }
  }
  return (low + high) / 2;
}

}  // namespace

Undetected undetected_of(const Polynomial<Count>& weights) {
  Undetected undetected;
  for (const Count count : weights) undetected.push_back(static_cast<long double>(count));
  undetected[0] = 0;
  return undetected;
}

long double probability(const Undetected& undetected, long double bit_error_rate) {
  const std::size_t bits = undetected.size() - 1;
  // Products instead of powers: this is called thousands of times, and a few hundred roundings are
  // far below the digits shown.
  std::vector<long double> right(bits + 1, 1);
  for (std::size_t k = 1; k <= bits; ++k) right[k] = right[k - 1] * (1 - bit_error_rate);
  long double sum = 0;
  long double wrong = 1;
  for (std::size_t w = 0; w <= bits; ++w) {
    sum += undetected[w] * wrong * right[bits - w];
    wrong *= bit_error_rate;
  }
  return sum;
}

WorstRate worst_rate(const Undetected& undetected) {
  constexpr long double tolerance = 1e-6L;
  // Near 1/2 the probability is so flat that rounding alone would decide between rates.
  constexpr long double clearly = 1 + 1e-15L;
  constexpr long double highest = 0.5L;
  WorstRate worst{highest, probability(undetected, highest), 0};
  const auto consider = [&](long double rate, long double found) {
    if (found > worst.probability * clearly) worst = {rate, found, 0};
  };
  std::priority_queue<Piece> open;
  open.push(halves_of(whole_of(undetected)).first);
  while (open.top().bound() > worst.probability * (1 + tolerance)) {
    auto [left, right] = halves_of(open.top());
    open.pop();
    consider(left.high, left.coefficients.back());
    open.push(std::move(left));
    open.push(std::move(right));
  }
  const long double peak = climb(undetected, std::max(0.0L, worst.bit_error_rate - 0.01L),
                                 std::min(highest, worst.bit_error_rate + 0.01L));
  consider(peak, probability(undetected, peak));
  worst.bound = std::max(open.top().bound(), worst.probability);
  return worst;
}

std::optional<long double> rate_reaching(const Undetected& undetected, long double limit) {
  // Finds the first rise in steps of 1 % in rate, small enough for sums of such terms.
  constexpr long double smallest = 1e-30L;
  long double low = 0;
  long double high = smallest;
  while (probability(undetected, high) < limit) {
    if (high >= 0.5L) return {};
    low = high;
    high = std::min(0.5L, high * 1.01L);
  }
  for (int i = 0; i < 100 && high - low > high * 1e-13L; ++i) {
    const long double middle = (low + high) / 2;
    (probability(undetected, middle) < limit ? low : high) = middle;
  }
  return high;
}

}  // namespace biss::lab
