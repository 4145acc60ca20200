// The unit of work of a campaign, and its counts. A block depends on nothing but seed, fault and
// number; counts are whole numbers, so parts add up to the same sum in any order.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numeric>
#include <string_view>
#include <vector>

#include "lab/campaign_frame.hpp"
#include "lab/experiment.hpp"

namespace biss::lab {

/// The check that accepts a frame with a fault; the fields of FrameOutcome.
enum class Acceptance : std::uint8_t { cpw, spw, both, monitor, wrong };

inline constexpr std::size_t acceptance_count = 5;
inline constexpr std::array<std::string_view, acceptance_count> acceptance_names{
    "cpw", "spw", "both", "monitor", "wrong"};

/// Bits that the check reads.
inline unsigned bits_of(const CampaignFrame& frame, Acceptance what) {
  if (what == Acceptance::cpw) return frame.cpw_bits();
  return what == Acceptance::spw ? frame.spw_bits() : frame.bits();
}

/// Numbers of wrong bits in both words, 0 included.
inline constexpr std::size_t weight_count = 127;

/// The number of missed frames that are kept, those with the lowest index.
inline constexpr std::size_t missed_kept = 16;

/// Numbers of wrong bits of a fitting draw; see FittingDraws.
struct FittedBits {
  std::uint8_t far = 0;   ///< among the control word's compared bits, without the lowest three
  std::uint8_t near = 0;  ///< among all other drawn bits
  std::uint8_t all = 0;   ///< in both words, without an additional flipped bit

  auto operator<=>(const FittedBits&) const = default;
};

/// Accepted frames of a fitting draw with the same weight.
struct FittedBin {
  Acceptance what{};
  FittedBits bits{};

  auto operator<=>(const FittedBin&) const = default;
};

/// Frames, and how many of them were accepted. Accepted frames are counted by the number of their
/// wrong bits: of the control word for `cpw`, of the safety word for `spw`, of both for the rest; in
/// [0] for faults other than flips. Fitting draws have bins in `fitted` instead, of `monitor` and
/// `wrong` only.
struct CampaignCounts {
  std::uint64_t frames = 0;
  std::array<std::array<std::uint64_t, weight_count>, acceptance_count> accepted{};
  std::map<FittedBin, std::uint64_t> fitted{};
  /// Ascending indices of frames with a wrong position that the monitor called safe.
  std::vector<std::uint64_t> missed{};

  bool operator==(const CampaignCounts&) const = default;

  void add(Acceptance what, std::size_t weight) {
    ++accepted[static_cast<std::size_t>(what)][weight];
  }
  void add_missed(std::uint64_t index) { keep_lowest(missed, index, missed_kept); }
  void add(const CampaignCounts& other) {
    frames += other.frames;
    for (std::size_t what = 0; what < acceptance_count; ++what) {
      for (std::size_t weight = 0; weight < weight_count; ++weight) {
        accepted[what][weight] += other.accepted[what][weight];
      }
    }
    for (const auto& [bin, events] : other.fitted) fitted[bin] += events;
    for (const std::uint64_t index : other.missed) add_missed(index);
  }
  std::uint64_t total(Acceptance what) const {
    const auto& counts = accepted[static_cast<std::size_t>(what)];
    std::uint64_t sum = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
    for (const auto& [bin, events] : fitted) {
      if (bin.what == what) sum += events;
    }
    return sum;
  }
};

inline constexpr std::uint64_t block_frames = 65'536;

/// A sequence of frames with one fault.
struct FaultSequence {
  FaultChoice fault{};
  /// The campaign's seed; each fault has its own random numbers.
  std::uint64_t seed = 0;
};

/// Counts frames from block * block_frames on; `frames` is at most block_frames. Flips are drawn and
/// checked 256 frames at a time by bit slices; the monitor judges frames that both CRCs accept.
CampaignCounts count_block(const CampaignFrame& frame, const FaultSequence& sequence,
                           std::uint64_t block, std::uint64_t frames = block_frames);

/// The same, frame by frame through CampaignFrame::judge().
CampaignCounts count_block_plainly(const CampaignFrame& frame, const FaultSequence& sequence,
                                   std::uint64_t block, std::uint64_t frames = block_frames);

/// One frame of a sequence, as it was counted.
struct ReplayedFrame {
  SentFrame sent{};
  WordPair encoded{};
  WordPair received{};
  /// For a fitting draw.
  FittedBits drawn{};
};
ReplayedFrame replay_frame(const CampaignFrame& frame, const FaultSequence& sequence,
                           std::uint64_t index);

}  // namespace biss::lab
