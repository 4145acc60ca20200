// The arithmetic of request cycles: the duration of each part, and how many cycles fit in a second.
#pragma once

#include <algorithm>
#include <cstdint>

#include "biss/base/units.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

/// The parts of a frame's size that its duration depends on.
struct FrameLength {
  /// Bits of all channels, CRCs included, without START, CDS and STOP.
  unsigned payload_bits = 0;
  /// Devices in a daisy chain; each after the first delays START by a clock. Several channels of
  /// one device (BiSS Safety's two words) count as one.
  unsigned slaves = 1;
};

/// A request cycle with ACK at its longest; the parts add up to `total`.
///
/// A request that begins `total` or more after the previous one is answered, also if the previous
/// one sent CDM 1 or all of clocks_to_send. A master that sends only frame_clocks
/// (biss/master/request.hpp) sees SLO high by then. After clocks_to_send, SLO may still be seen low
/// for up to the line delay; a master for which a low SLO means "not ready" (SpiReader, unless the
/// rule is `cycle`) must also wait for the line delay.
struct CycleBudget {
  Picoseconds period{};      ///< of MA
  Picoseconds lat{};         ///< the clock that takes the position
  Picoseconds ack{};         ///< SLO low until START, one clock in reserve unless ACK is fixed
  Picoseconds start_cds{};   ///< START and CDS
  Picoseconds payload{};     ///< data and CRC of all channels
  Picoseconds stop{};        ///< the STOP bit
  Picoseconds line_delay{};  ///< in whole clocks, rounded up: the master sends this many clocks
                             ///< more
  Picoseconds timeout{};     ///< SLO low after STOP until the encoder is ready
  Picoseconds idle{};        ///< until the device's shortest cycle has passed
  Picoseconds total{};       ///< from one request to the next, at least
  /// MA clocks from LAT to STOP.
  std::int64_t frame_clocks = 0;
  /// MA clocks to send so that STOP has reached a master that samples once a clock: the clocks of
  /// the frame, and the line delay in whole clocks, rounded up.
  std::int64_t clocks_to_send = 0;
  /// The highest rate of requests, rounded down; 0 when a cycle takes longer than a second.
  Hertz request_rate_max{};
};

/// How long SLO stays low after the last edge of MA; `elapsed` is the time since the start of the
/// request. In whole clocks, rounded up; for TimeoutRule::cycle the time itself.
/// \pre period is positive
constexpr Picoseconds timeout_after(const Timeout& timeout, Picoseconds period,
                                    Picoseconds elapsed) {
  if (timeout.rule == TimeoutRule::cycle) {
    return std::max(timeout.time - elapsed, release_time(timeout, period));
  }
  Picoseconds time = timeout.time;
  if (timeout.rule == TimeoutRule::adaptive) time += (3 * period + picoseconds(1)) / 2;
  return clocks_to_cover(time, period) * period;
}

/// The shortest cycle by the formula of the protocol description D2: one clock each for LAT, ACK,
/// START, CDS and STOP (one more for each further slave), the payload, and processing time, line
/// delay and timeout, each rounded up to whole clocks. If ACK is fixed in clocks, it counts exactly
/// this number. A timeout from the start of the request is not rounded; if the frame is longer,
/// release_time() is counted. A time above a day (`never`, for example) counts as a day.
/// \pre period is positive, no time is negative, frame has at most max_payload_bits and 8 slaves
constexpr CycleBudget cycle_budget_of(const FrameLength& frame, const DeviceTiming& timing,
                                      Picoseconds period, Picoseconds line_delay) {
  constexpr Picoseconds day = milliseconds(86'400'000);
  line_delay = std::min(line_delay, day);
  Timeout timeout = timing.timeout;
  timeout.time = std::min(timeout.time, day);
  CycleBudget budget;
  const std::int64_t processing_clocks =
      timing.ack_clocks != 0 ? timing.ack_clocks - 1
                             : clocks_to_cover(std::min(timing.ack_max, day), period);
  const std::int64_t ack_clocks =
      1 + processing_clocks + (std::int64_t{std::max(frame.slaves, 1U)} - 1);
  budget.period = period;
  budget.lat = period;
  budget.ack = ack_clocks * period;
  budget.start_cds = 2 * period;
  budget.payload = std::int64_t{frame.payload_bits} * period;
  budget.stop = period;
  budget.line_delay = clocks_to_cover(line_delay, period) * period;
  budget.frame_clocks = 1 + ack_clocks + 2 + frame.payload_bits + 1;
  budget.clocks_to_send = budget.frame_clocks + clocks_to_cover(line_delay, period);

  // Up to the last edge of MA: for CDM 1 the falling edge after the last clock.
  const Picoseconds elapsed = budget.clocks_to_send * period;
  budget.timeout = timeout_after(timeout, period, elapsed);
  budget.idle = std::max(std::min(timing.cycle_min, day) - elapsed - budget.timeout, Picoseconds{});
  budget.total = elapsed + budget.timeout + budget.idle;
  budget.request_rate_max =
      Hertz{static_cast<std::uint32_t>(picoseconds_per_second / budget.total.count)};
  return budget;
}

/// The same at this clock. \pre clock is not 0 Hz
constexpr CycleBudget cycle_budget(const FrameLength& frame, const DeviceTiming& timing,
                                   Hertz clock, Picoseconds line_delay) {
  return cycle_budget_of(frame, timing, period_of(clock), line_delay);
}

/// Whether requests may be made at this rate.
constexpr bool is_feasible(const CycleBudget& budget, Hertz rate) {
  return rate <= budget.request_rate_max;
}

/// Whether the device accepts this clock.
constexpr bool accepts_clock(const DeviceTiming& timing, Hertz clock) {
  return clock >= timing.clock_min && clock <= timing.clock_max;
}

}  // namespace biss
