// The table of a fault campaign.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lab/campaign.hpp"
#include "lab/campaign_theory.hpp"
#include "report/table.hpp"
#include "verbs/common/exit_status.hpp"

namespace biss::verbs {

class Host;

/// A fault of a campaign, and what was measured.
struct CampaignRow {
  lab::FaultChoice fault;
  /// Of the state.
  const lab::CampaignCounts& counts;
  std::optional<lab::CampaignTheory> theory;
  /// By lab::Acceptance; none if the fault has no counts of this kind.
  std::array<std::optional<lab::CampaignEstimate>, lab::acceptance_count> estimates{};
};

/// \pre the state outlives the rows
std::vector<CampaignRow> campaign_rows(const lab::CampaignFrame& frame,
                                       const lab::CampaignState& state);

/// CSV and JSON lines have a row for each fault, the human-readable table a row for each fault and
/// check.
/// \return false if the sink failed
bool write_campaign(std::span<const CampaignRow> rows, report::Format to, report::TextSink& sink,
                    const report::TableOptions& table_options = {});

/// Done, or data_failed after a message: a count is more than five standard deviations from the
/// theory.
ExitStatus judge_campaign(std::span<const CampaignRow> rows, Host& host);

/// A deviation for the human-readable table, `+1.53`; 0 after rounding has no sign.
std::string sigma_text(long double sigma);

}  // namespace biss::verbs
