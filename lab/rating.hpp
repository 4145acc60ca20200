// The rating of two words: the number that check_safety() compares with its limit.
#pragma once

#include <optional>

#include "biss/frame/format.hpp"
#include "biss/safety/rating.hpp"
#include "lab/pair.hpp"

namespace biss::lab {

/// The bit error rate of IEC 61784-3 for which a rating holds.
inline constexpr double rated_bit_error_rate = 1e-2;

/// The rating of the first two channels with this comparison. Nothing where pair_problem() finds a
/// problem, and where the residual error is too large for a rating.
std::optional<SafetyRating> safety_rating(const FrameFormat& format,
                                          const SafetyComparison& comparison);

}  // namespace biss::lab
