// The plan of a fault campaign from what a user says, the same for every verb that runs one.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lab/campaign.hpp"

namespace biss::cli {

/// What a campaign does where nobody says anything.
const std::vector<std::string>& usual_campaign_faults();

/// What parse_safety_format() makes of the text.
/// \return none where that is none
std::optional<lab::CampaignFrame> campaign_frame_of(const std::string& name);

/// What of the monitor can be set and changes the counts, for CampaignPlan::rules.
std::string campaign_rules(const lab::CampaignFrame& frame);

/// Adds a fault. False where the text is none, or none of these bits.
bool add_campaign_fault(const lab::CampaignFrame& frame, const std::string& text,
                        lab::CampaignPlan& plan);

/// Adds rows by importance sampling where plain sampling sees too little. They are part of the
/// plan, so every shard has them.
void add_importance(const lab::CampaignFrame& frame, lab::CampaignPlan& plan);

}  // namespace biss::cli
