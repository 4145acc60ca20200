// A campaign: faults by the billion frames, on all cores, in parts that add up exactly.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lab/campaign_block.hpp"
#include "lab/campaign_estimate.hpp"

namespace biss::lab {

/// Of one fault; the blocks that are done are held in memory, a bit each.
inline constexpr std::uint64_t max_campaign_frames = std::uint64_t{1} << 46U;

/// Of a fitting draw: nearly half of them are accepted, each after the whole monitor has looked.
inline constexpr std::uint64_t max_fitting_frames = std::uint64_t{1} << 22U;

/// What is asked for. Two campaigns with the same plan give the same table.
struct CampaignPlan {
  /// As the user gave it: a name, or the text of a format. Two parts belong together when it and
  /// `rules` are the same.
  std::string format;
  /// What of the monitor can be set, as text.
  std::string rules;
  std::uint64_t seed = 1;
  /// Of each fault; see frames_of().
  std::uint64_t frames = 0;
  std::vector<FaultChoice> faults;

  bool operator==(const CampaignPlan&) const = default;
  /// `frames`; of a fitting draw max_fitting_frames at most.
  std::uint64_t frames_of(std::size_t fault) const;
  std::uint64_t blocks_of(std::size_t fault) const;
  /// Frames of a block; only the last one has fewer than block_frames.
  std::uint64_t frames_of_block(std::size_t fault, std::uint64_t block) const;
};

/// What is done of a plan.
struct CampaignState {
  explicit CampaignState(CampaignPlan plan);

  CampaignPlan plan;
  /// Of each fault in the plan's order.
  std::vector<CampaignCounts> counts;
  /// Of each fault: block by block, whether it is in the counts.
  std::vector<std::vector<bool>> done;

  bool operator==(const CampaignState&) const = default;
  /// All blocks of all faults.
  bool complete() const;
  /// Adds another part. False, and nothing is changed, where the plans differ or a block is in
  /// both.
  [[nodiscard]] bool merge(const CampaignState& other);
};

inline constexpr std::uint64_t max_campaign_shards = std::uint64_t{1} << 20U;

/// Every count-th block from number - 1 on. \pre 1 <= number <= count <= max_campaign_shards
struct CampaignShard {
  std::uint64_t number = 1;
  std::uint64_t count = 1;
};

struct CampaignRun {
  /// 0: as many as there are cores.
  unsigned threads = 0;
  CampaignShard shard{};
  /// Called now and then, and at the end, while nobody counts; false ends the run.
  std::function<bool(const CampaignState&)> save{};
  /// Seconds between two calls.
  double save_seconds = 5;
};

/// Does what is missing of the shard's blocks. The result does not depend on the threads.
/// \return false where `save` said so
bool run_campaign(const CampaignFrame& frame, CampaignState& state, const CampaignRun& run);

/// The state as text, a JSON object, and back. Text of anything else gives none.
std::string state_text(const CampaignState& state);
std::optional<CampaignState> read_state(const std::string& text);

}  // namespace biss::lab
