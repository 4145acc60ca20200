// The unit of work of a sequence: a block that depends on nothing but row, seed and number.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "lab/sequence_frame.hpp"

namespace biss::lab {

/// One call of the monitor.
struct SequenceStep {
  /// The index of the frame or event in the row.
  std::uint64_t index = 0;
  /// By the master's clock, which wraps around in every fourth block.
  Picoseconds time{};
  /// `frame`: undamaged; `fault`: a frame that is not the answer to this request; `silence`: no
  /// answer; `watch`: time alone.
  std::string_view what{};
  /// Empty except for frames. Valid during the call.
  BitView bits{};
  /// The answer of the encoder to this request; none for `watch`.
  std::optional<SequenceWords> meant{};
  SafetyJudgement judgement{};
  /// control_position() of a safe judgement.
  std::optional<std::uint64_t> position_read{};
};

using SequenceWatcher = std::function<void(const SequenceStep&)>;

/// Counts one block of the row.
/// \param frame made with the row's two counters
/// \param watcher may be empty
SequenceCounts count_sequence(const SequenceFrame& frame, const SequenceRow& row,
                              std::uint64_t seed, std::uint64_t block,
                              const SequenceWatcher& watcher = {});

/// The verdict of an event must come within this number of cycles after the first request that has
/// the fault: 0, or the watchdog's cycles if a frame is missing and the monitor is not called.
unsigned reaction_bound(const SequenceFrame& frame, const SequenceRow& row);

}  // namespace biss::lab
