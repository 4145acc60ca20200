// The unit of work of a run of frames in order: a block that depends on nothing but the row, the
// seed and its number.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "lab/sequence_counts.hpp"
#include "lab/sequence_frame.hpp"

namespace biss::lab {

/// One call of the monitor, to be looked at.
struct SequenceStep {
  /// Of the frame or event, as counted in the row.
  std::uint64_t index = 0;
  /// By the master's clock, which wraps around in every fourth block.
  Picoseconds time{};
  /// `frame`: good; `fault`: a frame that is not this request's; `silence`: no answer; `watch`:
  /// time alone.
  std::string_view what{};
  /// Empty but for frames. Valid during the call.
  BitView bits{};
  /// What the encoder would have said to this request; none for `watch`.
  std::optional<SequenceWords> meant{};
  SafetyJudgement told{};
};

using SequenceWatcher = std::function<void(const SequenceStep&)>;

/// Counts one block of the row.
/// \param frame made with the row's two counters
/// \param watcher may be empty
SequenceCounts count_sequence(const SequenceFrame& frame, const SequenceRow& row,
                              std::uint64_t seed, std::uint64_t block,
                              const SequenceWatcher& watcher = {});

}  // namespace biss::lab
