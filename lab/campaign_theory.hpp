// What a campaign should count, by exact calculation: another way than the campaign's in every
// step.
#pragma once

#include <array>
#include <optional>

#include "lab/campaign_counts.hpp"
#include "lab/campaign_fault.hpp"
#include "lab/campaign_frame.hpp"

namespace biss::lab {

/// The probability of each Acceptance, in its order. All words drawn evenly.
using CampaignTheory = std::array<long double, acceptance_count>;

/// Of any fault. Sums over all words of both dual codes for flips, solutions of linear equations
/// for the others. Rounded at 1e-19 or so of 1, so that less than 1e-16 means little.
/// \return none where both checksums together have more than 24 bits, or the comparison tolerates
/// more than one count
std::optional<CampaignTheory> campaign_theory(const CampaignFrame& frame, const FaultChoice& fault);

/// flips, see campaign_theory(). \pre its conditions
CampaignTheory flips_theory(const CampaignFrame& frame, long double rate);
/// All other kinds, see campaign_theory(). \pre its conditions
CampaignTheory placed_theory(const CampaignFrame& frame, const FaultChoice& fault);

}  // namespace biss::lab
