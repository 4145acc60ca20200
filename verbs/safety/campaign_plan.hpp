// The plan of a fault campaign from command-line options.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lab/campaign.hpp"

namespace biss::verbs {

/// The faults of a campaign without --fault.
const std::vector<std::string>& usual_campaign_faults();

/// The frame of the format that parse_safety_format() returns.
/// \return nothing if it returns nothing
std::optional<lab::CampaignFrame> campaign_frame_of(const std::string& name);

/// The settings of the monitor that change the counts, for CampaignPlan::rules.
std::string campaign_rules(const lab::CampaignFrame& frame);

/// Adds a fault. Returns false if the text is no fault, or no fault of these bits.
bool add_campaign_fault(const lab::CampaignFrame& frame, const std::string& text,
                        lab::CampaignPlan& plan);

/// Adds rows by importance sampling for events that are too rare for plain sampling. They are part
/// of the plan, so every shard has them.
void add_importance(const lab::CampaignFrame& frame, lab::CampaignPlan& plan);

}  // namespace biss::verbs
