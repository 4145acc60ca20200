// From weights to probabilities on a binary symmetric channel: every bit is wrong with the same
// probability, the bit error rate, independently of all others. A model of a channel, not a
// certificate.
#pragma once

#include <optional>
#include <vector>

#include "lab/polynomial.hpp"
#include "lab/wide.hpp"

namespace biss::lab {

/// How many patterns of each weight are accepted although they are wrong, [0] to [bits]. Not always
/// whole numbers: a pattern that passes for half of all positions counts half.
using Undetected = std::vector<long double>;

/// The accepted patterns of a word but the one without a wrong bit.
Undetected undetected_of(const Polynomial<Count>& weights);

/// The probability that one of these patterns comes: the sum of count[w] p^w (1-p)^(bits-w). All
/// terms are positive, so nothing cancels. \pre 0 <= bit_error_rate <= 1
long double probability(const Undetected& undetected, long double bit_error_rate);

struct WorstRate {
  long double bit_error_rate = 0;
  long double probability = 0;
  /// Proven: nowhere in 0…1/2 is the probability higher than this.
  long double bound = 0;
};

/// The bit error rate in 0…1/2 at which the probability is highest, also where it rises and falls
/// several times: intervals are halved until the bound is within a millionth of what was found. Of
/// rates that rounding cannot tell apart it is 1/2. \pre a wrong pattern is accepted
WorstRate worst_rate(const Undetected& undetected);

/// The smallest bit error rate in 0…1/2 at which the probability reaches `limit`, to 12 digits.
/// Nothing when it never does. \pre limit > 0
std::optional<long double> rate_reaching(const Undetected& undetected, long double limit);

}  // namespace biss::lab
