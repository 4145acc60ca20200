// What a campaign should count, by exact calculation: another way than the campaign's in every
// step.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>

#include "lab/campaign_counts.hpp"
#include "lab/campaign_fault.hpp"
#include "lab/campaign_frame.hpp"
#include "lab/residual.hpp"

namespace biss::lab {

/// The probability of each Acceptance, in its order. All words drawn evenly.
using CampaignTheory = std::array<long double, acceptance_count>;

/// Of any fault: weights of the codes for flips, solutions of linear equations for the others.
/// \return none where both checksums together have more than 24 bits, or the comparison tolerates
/// more than one count
std::optional<CampaignTheory> campaign_theory(const CampaignFrame& frame, const FaultChoice& fault);

/// Flips at any rate. The patterns are counted once, in integers; what is left is a sum of positive
/// terms, so that no digit is lost however rare a thing is.
class FlipsTheory {
 public:
  /// \pre the conditions of campaign_theory()
  explicit FlipsTheory(const CampaignFrame& frame);

  CampaignTheory at(long double rate) const;

 private:
  Undetected cpw_;
  Undetected spw_;
  Undetected monitor_;
  Undetected wrong_;
};

/// All other kinds, see campaign_theory(). \pre its conditions
CampaignTheory placed_theory(const CampaignFrame& frame, const FaultChoice& fault);

/// campaign_theory() of many faults of one frame, each calculated once.
class CampaignTheories {
 public:
  /// The frame must outlive it.
  explicit CampaignTheories(const CampaignFrame& frame) : frame_(frame) {}

  std::optional<CampaignTheory> of(const FaultChoice& fault);

 private:
  const CampaignFrame& frame_;
  std::optional<FlipsTheory> flips_;
  std::map<std::string, CampaignTheory> placed_;
};

}  // namespace biss::lab
