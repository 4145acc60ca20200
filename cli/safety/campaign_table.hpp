// The table of a fault campaign.
#pragma once

#include <string>

#include "lab/campaign.hpp"
#include "report/table.hpp"

namespace biss::cli {

struct CampaignTable {
  /// False if the sink failed.
  bool written = false;
  /// A count is more than five standard deviations from the theory.
  bool disagrees = false;
};

/// CSV and JSON lines have a row for each fault, the human-readable table a row for each fault and
/// check.
CampaignTable write_campaign(const lab::CampaignFrame& frame, const lab::CampaignState& state,
                             report::Format to, report::TextSink& sink,
                             const report::TableOptions& table_options);

/// A deviation for the human-readable table, `+1.53`; 0 after rounding has no sign.
std::string sigma_text(long double sigma);

}  // namespace biss::cli
