// Counts instructions with SysTick under QEMU's -icount, which gives every instruction the same
// virtual time. The ticks per instruction are measured on blocks of known length in the same run.
#pragma once

#include <cstdint>

#include "firmware/cost/row.hpp"

namespace cost {

/// The ticks and the result of a call.
struct Timed {
  std::uint32_t ticks = 0;
  std::uint64_t answer = 0;
};

/// Calls `run` between two readings of the clock.
Timed timed(Run run, const Sample& sample);

/// Ticks = ticks_of_none + slope * instructions; a call and its return are part of ticks_of_none.
struct Ruler {
  std::uint32_t ticks_of_none = 0;
  std::uint32_t ticks_of_long_block = 0;
  /// The other blocks are measured to the exact instruction.
  bool straight = false;

  /// Instructions of a call that took this number of ticks, rounded; call and return not counted.
  std::uint32_t instructions(std::uint32_t ticks) const;
};

/// Starts SysTick and measures blocks of 0, 1, 10, 100, 1000, 3000 and 8000 NOPs.
Ruler calibrate();

}  // namespace cost
