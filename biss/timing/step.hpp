// The result of a stepper: the level that it drives, and the time of the next call. Time and levels
// are arguments; the same step runs in a simulator and in firmware.
#pragma once

#include <cstdint>
#include <limits>

#include "biss/base/units.hpp"

namespace biss {

/// Later than any time: no deadline.
inline constexpr Picoseconds never{std::numeric_limits<std::int64_t>::max()};

/// The result of one step. Both values hold until the next step.
struct StepOutput {
  /// The level from the time of this step on: of SLO for a slave, of MA for a master.
  bool level = true;
  /// When to call step() again if no input changes before, at or after the time of this step;
  /// never: only an input matters.
  Picoseconds deadline = never;

  constexpr bool has_deadline() const { return deadline != never; }
  constexpr bool operator==(const StepOutput&) const = default;
};

}  // namespace biss
