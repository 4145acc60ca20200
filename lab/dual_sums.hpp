// The theory of flips once more, for the tests: as a mean of signs over all pairs of dual words, in
// floating point from the first step on. It shares no code with weights and pairs.
#pragma once

#include "lab/campaign_theory.hpp"

namespace biss::lab {

/// \param rate of a bit to be wrong
/// \pre the conditions of campaign_theory(); turns stand right above the singleturn value.
/// Rounded at 1e-19 or so of 1, so that less than 1e-16 means little.
CampaignTheory dual_sums(const CampaignFrame& frame, long double rate);

}  // namespace biss::lab
