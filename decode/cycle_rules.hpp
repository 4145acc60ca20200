// The rules that both ways of reading a cycle share.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

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

}  // namespace biss::decode
