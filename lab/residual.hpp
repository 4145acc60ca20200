// Residual error rates on a binary symmetric channel: every bit is wrong with the same probability,
// the bit error rate, independently of all other bits. A model of a channel, not a certificate.
#pragma once

#include <optional>
#include <vector>

#include "lab/weights.hpp"

namespace biss::lab {

/// How many patterns of each weight, [0] to [bits], are undetected errors. Not always whole numbers:
/// a pattern that passes for half of all positions counts half.
using Undetected = std::vector<long double>;

/// The accepted patterns of a word, without the pattern that has no wrong bit.
Undetected undetected_of(const Polynomial<Count>& weights);

/// The probability of any of these patterns: the sum of count[w] p^w (1-p)^(bits-w). All terms are
/// positive, so nothing cancels. \pre 0 <= bit_error_rate <= 1
long double probability(const Undetected& undetected, long double bit_error_rate);

struct WorstRate {
  long double bit_error_rate = 0;
  long double probability = 0;
  /// Proven: the probability is not higher than this anywhere in 0…1/2.
  long double bound = 0;
};

/// The bit error rate in 0…1/2 with the highest probability, even if there are several maxima:
/// intervals are bisected until the bound is within a millionth of the result. If rounding cannot
/// distinguish rates, it is 1/2. \pre a wrong pattern is accepted
WorstRate worst_rate(const Undetected& undetected);

/// The smallest bit error rate in 0…1/2 at which the probability reaches `limit`, to 12 digits.
/// Nothing if it never does. \pre limit > 0
std::optional<long double> rate_reaching(const Undetected& undetected, long double limit);

}  // namespace biss::lab
