// What a stepper returns: the level that it drives, and when to call it again. Time and levels are
// arguments; the same step runs in a simulator and in firmware.
#pragma once

#include <cstdint>
#include <limits>

#include "biss/base/units.hpp"

namespace biss {

/// Later than any time: no deadline.
inline constexpr Picoseconds never{std::numeric_limits<std::int64_t>::max()};

/// What one step returns. Both values hold until the next step.
struct StepOutput {
  /// What the stepper drives from the time of this step on: the slave SLO, the master MA.
  bool level = true;
  /// When to call step() again if no input changes before, at or after the time of this step;
  /// never: only an input matters.
  Picoseconds deadline = never;

  constexpr bool has_deadline() const { return deadline != never; }
  constexpr bool operator==(const StepOutput&) const = default;
};

}  // namespace biss
