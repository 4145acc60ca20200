// The lines of a capture as lists of times, and the shared parts of the trials of
// recognise_protocol().
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "biss/base/units.hpp"
#include "decode/times.hpp"
#include "identify/protocol.hpp"
#include "wire/edge.hpp"

namespace biss::identify {

/// The length of a stretch of time in picoseconds. \pre from <= to
inline double length(Picoseconds from, Picoseconds to) {
  return static_cast<double>(decode::elapsed(from, to).count);
}

/// The same, negative if `to` is before `from`.
inline double offset(Picoseconds from, Picoseconds to) {
  return from <= to ? length(from, to) : -length(to, from);
}

inline Picoseconds later(Picoseconds time, double by) {
  return decode::shifted(time, Picoseconds{static_cast<std::int64_t>(by)});
}

/// 0 of nothing.
inline double share(std::size_t part, std::size_t all) {
  return all == 0 ? 0 : static_cast<double>(part) / static_cast<double>(all);
}

template <class Values, class Property>
double share_of(const Values& values, Property property) {
  const auto count = std::count_if(values.begin(), values.end(), property);
  return share(static_cast<std::size_t>(count), values.size());
}

/// The least of the most frequent ones; 0 if there are no values.
template <class Value>
Value most_frequent(const std::vector<Value>& values) {
  std::map<Value, std::size_t> counts;
  for (const Value value : values) ++counts[value];
  const auto most =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == counts.end() ? Value{} : most->first;
}

/// The one with this index in ascending order; 0 if there are no values.
template <class Value>
Value nth_of(std::vector<Value> values, std::size_t index) {
  if (values.empty()) return 0;
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(index);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}
template <class Value>
Value median_of(const std::vector<Value>& values) {
  return nth_of(values, values.size() / 2);
}

/// The mean of the values from `least` to `most`; 0 if there are no such values.
double mean_within(const std::vector<double>& values, double least, double most);

/// Share of the values within `tolerance` of the median.
double share_near_median(const std::vector<double>& values, double tolerance);

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
  /// The most frequent length of the bursts; 0 without a burst.
  std::size_t usual_pulses = 0;
};

/// The changes of a line; the level alternates. Stretches of unknown level keep the level before.
struct Trace {
  wire::LineIndex line = 0;
  /// The level before the first change.
  bool first_high = false;
  std::vector<Picoseconds> changes;
  ClockShape clock;

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
/// \param sample the time between two samples of the capture
std::vector<Trace> moving_lines(std::span<const wire::Edge> edges, std::size_t lines,
                                double sample);

/// The data that all trials examine.
struct Scene {
  /// All edges, for decode::Decoder.
  std::span<const wire::Edge> edges;
  std::vector<Trace> lines;
  double sample = 0;
  Picoseconds end{};
};

/// A line is a clock if this share of its changes is regular; BiSS C with faults has less.
inline constexpr double clock_share = 0.7;
inline constexpr double damaged_clock_share = 0.4;

using Guesses = std::vector<ProtocolGuess>;

struct BissTrial {
  /// A checksum proves that the words are BiSS C.
  bool checked = false;
  /// The words consist of one that repeats, as SSI sends it.
  bool repeats = false;
  ProtocolGuess guess{Protocol::biss_c, 0, ""};
};

// The trials add their guesses.

BissTrial try_biss(const Scene& scene);
/// SSI, EnDat, SPI, a clock alone.
void try_clocked(const Scene& scene, const BissTrial& biss, Guesses& guesses);
/// I2C and quadrature.
void try_two_wire(const Scene& scene, Guesses& guesses);
/// UART, encoders on UART words, HIPERFACE DSL, noise.
void try_serial(const Scene& scene, Guesses& guesses);

}  // namespace biss::identify
