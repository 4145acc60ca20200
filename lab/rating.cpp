#include "lab/rating.hpp"

#include <cmath>

namespace biss::lab {

std::optional<SafetyRating> safety_rating(const FrameFormat& format,
                                          const SafetyComparison& comparison) {
  const PairChecks checks = pair_checks_of({.comparison = comparison});
  if (pair_problem(format, checks)) return std::nullopt;
  const PairWeights weights = pair_weights(format, checks);
  // Rounded up, and by more than what the sum may be wrong by.
  const long double share = probability(weights.beyond_tolerance, rated_bit_error_rate);
  const long double scaled = std::ceil(share * 1e24L * (1 + 1e-9L));
  if (scaled > 1e19L) return std::nullopt;
  SafetyRating rating;
  rating.words = rated_words(format.channel_list[0], format.channel_list[1], comparison);
  rating.residual_e24 = static_cast<std::uint64_t>(scaled);
  rating.check = rating_check(rating.words, rating.residual_e24);
  return rating;
}

}  // namespace biss::lab
