// What a campaign counts: whole numbers only, so that parts add up to the same sum in any order.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string_view>
#include <vector>

namespace biss::lab {

/// What can accept a damaged frame; the fields of FrameOutcome.
enum class Acceptance : std::uint8_t { cpw, spw, both, monitor, wrong };

inline constexpr std::size_t acceptance_count = 5;
inline constexpr std::array<std::string_view, acceptance_count> acceptance_names{
    "cpw", "spw", "both", "monitor", "wrong"};

/// Most bits of both words that can be wrong, and 0.
inline constexpr std::size_t weight_count = 127;

/// So many missed frames are remembered, those with the lowest index.
inline constexpr std::size_t missed_kept = 16;

/// Numbers of wrong bits of a fitting draw; see FittingDraws.
struct FittedBits {
  std::uint8_t far = 0;   ///< of the control word's compared bits, the lowest three left out
  std::uint8_t near = 0;  ///< of all others that are drawn
  std::uint8_t all = 0;   ///< of both words, without a bit that was turned as well

  auto operator<=>(const FittedBits&) const = default;
};

/// Accepted frames of a fitting draw that have the same weight.
struct FittedBin {
  Acceptance what{};
  FittedBits bits{};

  auto operator<=>(const FittedBin&) const = default;
};

/// Frames, and how many of them were accepted. Those accepted are counted by the number of their
/// wrong bits: of the control word for `cpw`, of the safety word for `spw`, of both for the rest.
/// All in [0] where the fault is no flips. Fitting draws have their bins in `fitted` instead, of
/// `monitor` and `wrong` only.
struct CampaignCounts {
  std::uint64_t frames = 0;
  std::array<std::array<std::uint64_t, weight_count>, acceptance_count> accepted{};
  std::map<FittedBin, std::uint64_t> fitted{};
  /// Indices of frames with a wrong position that the monitor called safe, in order.
  std::vector<std::uint64_t> missed{};

  bool operator==(const CampaignCounts&) const = default;

  void add(Acceptance what, std::size_t weight) {
    ++accepted[static_cast<std::size_t>(what)][weight];
  }
  void add_missed(std::uint64_t index);
  void add(const CampaignCounts& other);
  std::uint64_t total(Acceptance what) const;
};

}  // namespace biss::lab
