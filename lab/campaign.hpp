// A fault campaign: billions of frames with injected faults, and how many were accepted.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "lab/campaign_block.hpp"
#include "lab/experiment.hpp"

namespace biss::lab {

/// Frames of one fault.
inline constexpr std::uint64_t max_campaign_frames = std::uint64_t{1} << 46U;

/// Frames of a fitting draw: the monitor judges each, and nearly half of them are accepted.
inline constexpr std::uint64_t max_fitting_frames = std::uint64_t{1} << 22U;

/// Two campaigns with the same plan have the same results.
struct CampaignPlan {
  /// The user's text: a name or a frame format. Two parts belong together if `format` and `rules`
  /// are equal.
  std::string format;
  /// The settings of the monitor, as text.
  std::string rules;
  std::uint64_t seed = 1;
  /// Frames of each fault; see frames_of().
  std::uint64_t frames = 0;
  std::vector<FaultChoice> faults;

  bool operator==(const CampaignPlan&) const = default;
  /// `frames`, but at most max_fitting_frames of a fitting draw.
  std::uint64_t frames_of(const FaultChoice& fault) const;
};

/// A plan and the blocks that are done.
struct CampaignState {
  explicit CampaignState(CampaignPlan plan);

  CampaignPlan plan;
  /// A row a fault, in the plan's order.
  std::vector<ExperimentRow<CampaignCounts>> rows;

  bool operator==(const CampaignState&) const = default;
  /// All blocks of all faults are done.
  bool complete() const;
  std::uint64_t frames_done() const;
  std::uint64_t frames_planned() const;
  /// Adds another part. Returns false, and changes nothing, if the plans differ or a block is in
  /// both parts.
  [[nodiscard]] bool merge(const CampaignState& other);
};

/// Counts the missing blocks of the shard.
/// \return false if `save` or `interrupted` ended the run
bool run_campaign(const CampaignFrame& frame, CampaignState& state, const ExperimentRun& run);

/// The state as text, a JSON object.
std::string state_text(const CampaignState& state);

/// Reads the text of state_text(). Every number is checked: counts against frames, frames against
/// blocks.
/// \return the state, or the cause why the text is not a state of a campaign
tl::expected<CampaignState, std::string> read_state(std::string_view text);

/// Whether all numbers of wrong bits occur in these words. \pre the state's format is the frame's
bool fits(const CampaignFrame& frame, const CampaignState& state);

}  // namespace biss::lab
