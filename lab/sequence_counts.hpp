// What a run of frames in order counts: whole numbers, sums in any order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "biss/safety/verdict.hpp"

namespace biss::lab {

/// So many odd indices are remembered, the lowest ones.
inline constexpr std::size_t odd_kept = 16;

struct SequenceCounts {
  /// Undamaged frames that the monitor was shown, those between faults included.
  std::uint64_t frames = 0;
  /// Times that one of these, or the clock before it, was anything but `safe` after start-up.
  std::uint64_t false_alarms = 0;
  /// Undamaged frames that were safe with another position, counter or warning than was sent.
  std::uint64_t misread = 0;
  std::uint64_t position_wraps = 0;
  std::uint64_t counter_wraps = 0;

  /// Faults committed, or trials of a wrong counter range.
  std::uint64_t events = 0;
  /// Events in which a frame was safe that must not be; see SequenceResult::theory.
  std::uint64_t accepted = 0;
  /// Of these, with another position than the encoder had.
  std::uint64_t wrong = 0;
  /// Events that were neither accepted nor told within the bound.
  std::uint64_t late = 0;
  /// Events whose first verdict is none that the kind of fault may have.
  std::uint64_t unexpected = 0;
  /// The first verdict of each event that was not accepted.
  std::array<std::uint64_t, safety_verdict_count> verdicts{};
  /// From the first request that has the fault to that verdict, at most; begun cycles count.
  std::uint64_t worst_cycles = 0;
  /// Indices of frames or events that are in false_alarms, misread, late or unexpected; of accepted
  /// events as well.
  std::vector<std::uint64_t> odd{};

  bool operator==(const SequenceCounts&) const = default;

  std::uint64_t told(SafetyVerdict verdict) const {
    return verdicts[static_cast<std::size_t>(verdict)];
  }
  /// Events that were not accepted and had a verdict.
  std::uint64_t recognised() const;
  void add_odd(std::uint64_t index);
  void add(const SequenceCounts& other);
};

}  // namespace biss::lab
