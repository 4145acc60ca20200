// One line as a list of times, and what makes a line a clock.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "biss/base/units.hpp"
#include "decode/times.hpp"
#include "wire/edge.hpp"

namespace biss::identify {

/// The length of a stretch of time in picoseconds. \pre from <= to
inline double length(Picoseconds from, Picoseconds to) {
  return static_cast<double>(decode::elapsed(from, to).count);
}

/// The changes of a line; the level alternates. Stretches of unknown level keep the level before.
struct Trace {
  wire::LineIndex line = 0;
  /// The level before the first change.
  bool first_high = false;
  std::vector<Picoseconds> changes;

  /// The level that change `index` ends; `index` may be changes.size().
  bool level_before(std::size_t index) const { return first_high != (index % 2 != 0); }
  /// Index of the first change after `time`.
  std::size_t after(Picoseconds time) const {
    return static_cast<std::size_t>(std::upper_bound(changes.begin(), changes.end(), time) -
                                    changes.begin());
  }
  bool level_at(Picoseconds time) const { return level_before(after(time)); }
  /// From change `index` to the next one.
  double interval(std::size_t index) const { return length(changes[index], changes[index + 1]); }
};

/// The lines that change, busiest first, a bounded number of lines and of changes of each.
std::vector<Trace> moving_lines(std::span<const wire::Edge> edges, std::size_t lines);

/// The line without pulses shorter than this.
Trace without_pulses(const Trace& trace, double shortest);

/// Pulses of a clock without a gap between them.
struct Burst {
  /// Indexes of changes: the first leaves the idle level, the last returns to it.
  std::size_t first = 0;
  std::size_t last = 0;

  std::size_t pulses() const { return (last - first + 1) / 2; }
};

/// A line read as a clock.
struct ClockShape {
  double period = 0;
  /// The level in the gaps.
  bool idle_high = true;
  /// Share of the changes that belong to regular pulses in bursts.
  double regular = 0;
  /// There are gaps.
  bool pauses = false;
  std::vector<Burst> bursts;
};

ClockShape clock_shape(const Trace& trace, Picoseconds sample_period);

/// The most frequent length of the bursts; 0 without a burst.
std::size_t usual_pulses(std::span<const Burst> bursts);

/// The middle one; 0 where there is none.
double median_of(std::vector<double> values);

/// Share of the values within `tolerance` of the median.
double share_near_median(const std::vector<double>& values, double tolerance);

}  // namespace biss::identify
