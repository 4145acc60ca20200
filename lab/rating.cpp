#include "lab/rating.hpp"

#include <cmath>
#include <utility>

namespace biss::lab {

std::optional<UndetectedShares> undetected_shares(const FrameFormat& format,
                                                  const SafetyComparison& comparison) {
  const PairChecks checks = pair_checks_of({.comparison = comparison});
  if (pair_problem(format, checks)) return std::nullopt;
  FrameFormat exchanged = format;
  std::swap(exchanged.channel_list[0], exchanged.channel_list[1]);
  const PairWeights by_cpw = pair_weights(format, checks);
  const PairWeights by_spw = pair_weights(exchanged, checks);
  const auto share = [](const Undetected& of) { return probability(of, rated_bit_error_rate); };
  return UndetectedShares{.by_cpw = share(by_cpw.beyond_tolerance),
                          .by_spw = share(by_spw.beyond_tolerance),
                          .control_position = share(by_cpw.wrong)};
}

std::optional<SafetyRating> safety_rating(const FrameFormat& format,
                                          const SafetyComparison& comparison) {
  const auto shares = undetected_shares(format, comparison);
  if (!shares) return std::nullopt;
  // Rounded up, and by more than what the sum may be wrong by.
  const long double scaled = std::ceil(shares->safe_position() * 1e24L * (1 + 1e-9L));
  if (scaled > 1e19L) return std::nullopt;
  SafetyRating rating;
  rating.words = rated_words(format.channel_list[0], format.channel_list[1], comparison);
  rating.residual_e24 = static_cast<std::uint64_t>(scaled);
  rating.check = rating_check(rating.words, rating.residual_e24);
  return rating;
}

}  // namespace biss::lab
