// The rules that both ways of reading a cycle share.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "biss/timing/device_timing.hpp"
#include "decode/cycle_reader.hpp"

namespace biss::decode {

/// SLO may seem to fall at most a fourth of a period before the edge of ACK, even in a coarse
/// capture: a fall before that was not caused by that edge.
inline constexpr std::int64_t uncertain_share = 4;

/// The margin of `marginal` is a twentieth of a period, as in the master of biss/master.
inline constexpr std::int64_t margin_share = 20;

/// The clock of a cycle is estimated from this many edges at its beginning.
inline constexpr std::size_t lookahead_edges = 12;
/// A pause is longer than their longest gap by at least this share of a period.
inline constexpr std::int64_t pause_share = 50;
/// A low of MA shorter than this share of a period is a pulse and not a clock.
inline constexpr std::int64_t pulse_share = 20;

/// SLO is ignored later than this after the last edge of a cycle: the line delay and a period are
/// over by then.
inline constexpr Picoseconds slo_matters = milliseconds(1);

/// The capture and the jitter of MA: by how much the time between two edges may be off.
constexpr Picoseconds uncertainty_of(const MarginSetup& margin, Picoseconds jitter,
                                     Picoseconds period) {
  return std::min(margin.resolution + jitter, period / uncertain_share);
}

/// The part of the margin that the resolution of the capture makes uncertain.
constexpr Picoseconds margin_doubt(const MarginSetup& margin) {
  // The edge of MA that the sample counts from is uncertain, SLO's is, and the delay between them.
  return (margin.compensated ? 2 : 1) * margin.resolution;
}

/// The period is measured, so a bound close to a clock edge gets a tolerance of 2 %.
constexpr bool ack_within_bounds(const DeviceTiming& timing, Picoseconds period,
                                 std::uint16_t ack_clocks) {
  const Picoseconds grace = period / 50;
  return ack_clocks >= ack_bounds(timing, period + grace).min_clocks &&
         ack_clocks <= ack_bounds(timing, std::max(period - grace, picoseconds(1))).max_clocks;
}

/// A distance of rising edges outside these shares of the usual one means that an edge is missing or
/// too many: a lost edge doubles it, an extra one leaves at most half. The range between them is the
/// jitter of a capture with only two samples per period.
inline constexpr std::int64_t irregular_above_percent = 160;
inline constexpr std::int64_t irregular_below_percent = 55;

constexpr bool irregular(Picoseconds interval, Picoseconds usual) {
  // 12 hours: longer ones are equal here, and the products below fit.
  constexpr std::int64_t longest = std::numeric_limits<std::int64_t>::max() / 200;
  const std::int64_t count = std::min(interval.count, longest);
  const std::int64_t expected = std::min(usual.count, longest);
  return count * 100 > expected * irregular_above_percent ||
         count * 100 < expected * irregular_below_percent;
}

inline Picoseconds median(std::vector<Picoseconds>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace biss::decode
