// The table of a fault campaign.
#pragma once

#include <string>

#include "lab/campaign.hpp"
#include "report/table.hpp"

namespace biss::cli {

struct CampaignTable {
  /// False: the sink did not take it.
  bool written = false;
  /// A count is more than five standard deviations from the theory.
  bool disagrees = false;
};

/// For machines a row a fault; for eyes a row a fault and check.
CampaignTable write_campaign(const lab::CampaignFrame& frame, const lab::CampaignState& state,
                             report::Format to, report::TextSink& sink, bool colour);

/// A deviation for eyes, `+1.53`: what rounds to 0 has no sign.
std::string sigma_text(long double sigma);

}  // namespace biss::cli
