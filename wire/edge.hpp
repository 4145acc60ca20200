// Changes of level on the line, as every reader of a capture delivers them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

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

/// The changes of one line in a stretch of a capture, in picoseconds; the first one leads to
/// `first_high`, each further one inverts the level.
struct LineRun {
  std::span<const std::int64_t> times;
  bool first_high = false;

  /// From change `index` on.
  constexpr Level level(std::size_t index) const {
    return first_high == (index % 2 == 0) ? Level::high : Level::low;
  }
};

}  // namespace biss::wire
