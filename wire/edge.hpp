// Changes of level on the line, as every reader of a capture delivers them.
#pragma once

#include <cstdint>
#include <string>

#include "biss/base/units.hpp"

namespace biss::wire {

/// A line's level; `unknown` is a simulator's x or z, or a cell that is neither 0 nor 1.
enum class Level : std::uint8_t { low, high, unknown };

/// Index of a line in the capture's list of lines.
using LineIndex = std::uint32_t;

/// From `time` on `line` has `level`. A line's first edge gives its initial level. Times never
/// fall.
struct Edge {
  Picoseconds time;
  LineIndex line = 0;
  Level level = Level::unknown;

  bool operator==(const Edge&) const = default;
};

}  // namespace biss::wire
