// The rating of two words: the number that check_safety() compares with its limit.
#pragma once

#include <optional>

#include "biss/frame/format.hpp"
#include "biss/safety/rating.hpp"
#include "lab/pair.hpp"

namespace biss::lab {

/// The bit error rate of IEC 61784-3 for which a rating holds.
inline constexpr double rated_bit_error_rate = 1e-2;

/// The share of frames with an undetected error at rated_bit_error_rate.
struct UndetectedShares {
  /// The compared bits are wrong by more than the tolerance: those of the CPW, as
  /// PairWeights::beyond_tolerance counts, and those of the SPW, which the safe position consists of.
  long double by_cpw = 0;
  long double by_spw = 0;
  /// Any bit of the CPW is wrong.
  long double control_position = 0;

  long double safe_position() const { return by_cpw > by_spw ? by_cpw : by_spw; }
};

/// Of the first two channels. Nothing where pair_problem() finds a problem.
std::optional<UndetectedShares> undetected_shares(const FrameFormat& format,
                                                  const SafetyComparison& comparison);

/// The rating of the first two channels with this comparison. Nothing where pair_problem() finds a
/// problem, and where the residual error is too large for a rating.
std::optional<SafetyRating> safety_rating(const FrameFormat& format,
                                          const SafetyComparison& comparison);

}  // namespace biss::lab
