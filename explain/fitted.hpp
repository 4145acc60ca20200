// How bits become likelihoods. Scale and power are rounded from what tests/explain/fit.py printed for
// development seeds; its priors are not used.
#pragma once

#include <array>

#include "explain/cause.hpp"

namespace biss::explain::fitted {

/// A cause whose account is `b` bits longer than the shortest one weighs prior * (1 + b / scale)^-power.
inline constexpr double scale = 1.2;
inline constexpr double power = 1.5;
/// In the order of Cause.
inline constexpr std::array<double, cause_count> prior{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1,
                                                       1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};

}  // namespace biss::explain::fitted
