// The unit of work of a campaign: a block of frames that depends on nothing but seed, fault and
// number.
#pragma once

#include <cstdint>

#include "lab/campaign_counts.hpp"
#include "lab/campaign_frame.hpp"

namespace biss::lab {

inline constexpr std::uint64_t block_frames = 65'536;

/// A sequence of frames under one fault.
struct FaultSequence {
  FaultChoice fault{};
  /// Of the campaign; each fault makes its own of it.
  std::uint64_t seed = 0;
};

/// Counts frames block * block_frames and on, `frames` of them, at most block_frames. Flips are
/// drawn and checked 256 frames at a time by bit slices, the monitor then judges those that both
/// CRCs accept.
CampaignCounts count_block(const CampaignFrame& frame, const FaultSequence& sequence,
                           std::uint64_t block, std::uint64_t frames = block_frames);

/// The same, each frame by itself through CampaignFrame::judge().
CampaignCounts count_block_plainly(const CampaignFrame& frame, const FaultSequence& sequence,
                                   std::uint64_t block, std::uint64_t frames = block_frames);

/// One frame of a sequence, as it was counted.
struct ReplayedFrame {
  SentFrame sent{};
  WordPair encoded{};
  WordPair received{};
};
ReplayedFrame replay_frame(const CampaignFrame& frame, const FaultSequence& sequence,
                           std::uint64_t index);

}  // namespace biss::lab
