// What can be asked of a run of frames in order: a line of the table each.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "biss/safety/setup.hpp"
#include "biss/safety/verdict.hpp"
#include "lab/experiment.hpp"

namespace biss::lab {

enum class SequenceTask : std::uint8_t {
  undamaged,     ///< frames as the encoder sends them: nothing but `safe` after start-up
  counter_mode,  ///< the same of a counter with the other range: `counter_mode`, and no other name
  fault,         ///< one of the eight kinds, committed again and again in a safe sequence
};

/// How an undamaged encoder moves. Every 512 frames it is put to another place, every second time
/// so that zero is passed; it then goes 256 frames one way and 256 back.
enum class SequenceMotion : std::uint8_t {
  max,    ///< full speed: just less than half a turn from frame to frame
  steps,  ///< every speed from a count to half the range, each magnitude as often
  creep,  ///< a count or two to and fro, about any multiple of a power of two
};

inline constexpr std::array<std::string_view, 3> sequence_motion_names{"max", "steps", "creep"};

/// As the option --counter takes it.
constexpr std::string_view name_of(CounterMode mode) {
  constexpr std::array<std::string_view, 3> names{"count_1_63", "count_0_63", "learned"};
  return names[static_cast<std::size_t>(mode)];
}

/// The ways in which a fault of this kind is committed; docs/safety-sequences.md describes them.
std::span<const std::string_view> variants_of(TransmissionError kind);

struct SequenceRow {
  SequenceTask task = SequenceTask::undamaged;
  /// Of a fault; and which of its variants.
  TransmissionError kind{};
  unsigned variant = 0;
  /// The monitor's.
  CounterMode counter = CounterMode::count_1_63;
  /// The encoder's; not `learned`.
  CounterMode encoder_counter = CounterMode::count_1_63;
  SequenceMotion motion = SequenceMotion::max;
  /// Frames if undamaged, else events.
  std::uint64_t size = 0;

  bool operator==(const SequenceRow&) const = default;
  /// undamaged, counter_mode, or the name of the kind.
  std::string_view name() const;
  /// The words and the motion's behaviour, or how the fault is committed.
  std::string_view variant_name() const;
  /// Of the row's random numbers: it depends on everything but `size`, and not on other rows.
  std::uint64_t seed(std::uint64_t campaign_seed) const;
  /// Values of the encoder's counter.
  unsigned period() const { return encoder_counter == CounterMode::count_0_63 ? 64 : 63; }
  /// Its frames or events in blocks.
  TrialBlocks blocks() const;
};

}  // namespace biss::lab
