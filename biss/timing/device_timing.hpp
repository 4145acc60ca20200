// DeviceTiming: how an encoder behaves in time. It is separate from FrameFormat, because devices
// with the same bits differ in time.
#pragma once

#include <algorithm>
#include <cstdint>

#include "biss/base/units.hpp"

namespace biss {

/// Limits of the protocol description D2, table of characteristics (row numbers as in PROTOCOL 1.3).
inline constexpr Hertz biss_clock_min = kilohertz(80);                       // row 1
inline constexpr Hertz biss_clock_max = megahertz(10);                       // row 1
inline constexpr Picoseconds biss_line_delay_max = microseconds(40);         // row 7
inline constexpr Picoseconds biss_busy_max = microseconds(40);               // row 10a
inline constexpr std::uint8_t biss_busy_s_max_clocks = 8;                    // row 10b
inline constexpr Picoseconds biss_static_timeout_min = nanoseconds(12'500);  // row 5
inline constexpr Picoseconds biss_static_timeout_max = microseconds(40);     // row 5

/// Whether an encoder may answer with this line delay: the time from the rising edge of MA that
/// makes ACK to the falling edge of SLO, negative if SLO falls before that edge. False gives the
/// status `response_range`. The same rule holds for the master and for the decoder of captures.
/// \param uncertainty how much too early SLO may seem to fall: the resolution and the jitter of
///   the measurement; 0 for a master, which sees both lines as they are
constexpr bool is_response_delay(Picoseconds delay, Picoseconds uncertainty = {},
                                 Picoseconds longest = biss_line_delay_max) {
  return delay >= -uncertainty && delay <= longest;
}

/// ACK at its longest: the longest processing time at the highest clock.
inline constexpr std::uint16_t biss_ack_max_clocks =
    static_cast<std::uint16_t>(clocks_to_cover(biss_busy_max, period_of(biss_clock_max)));

/// When SLO returns to 1 after a frame.
enum class TimeoutRule : std::uint8_t {
  adaptive,  ///< 1.5 MA periods after the last edge of MA, up to 3 sampling clocks of the slave
             ///< later
  fixed,     ///< a time after the last edge of MA ("static" in the protocol description)
  cycle,     ///< a time after the start of the request (Renishaw)
};

/// How long SLO stays low after a frame that is longer than its TimeoutRule::cycle, in half periods
/// of MA after its last edge. The sources leave it open: Renishaw's data sheet gives only the time
/// from the start of the request. The value is the same as for the adaptive timeout (D2, row 6: 1.5
/// periods), so that STOP can be read.
inline constexpr std::uint8_t biss_release_half_periods = 3;
/// With less, a slave would release SLO between two clocks.
inline constexpr std::uint8_t biss_release_half_periods_min = 2;

struct Timeout {
  TimeoutRule rule = TimeoutRule::fixed;
  /// For `fixed` and `cycle` the time; for `adaptive` the most that is added to 1.5 periods.
  Picoseconds time = biss_static_timeout_max;
  /// For `cycle`: the least time that SLO is low after the last edge of MA, 2 or more; see above.
  std::uint8_t release_half_periods = biss_release_half_periods;
  /// The shortest fixed timeout, or static one of an adaptive device. 0: not stated; see
  /// shortest_timeout().
  Picoseconds shortest{};

  constexpr bool operator==(const Timeout&) const = default;
};

/// How long SLO stays low after the last edge of MA by the rule `cycle`, whenever the request
/// began; rounded up to a picosecond.
constexpr Picoseconds release_time(const Timeout& timeout, Picoseconds period) {
  return (std::int64_t{timeout.release_half_periods} * period + picoseconds(1)) / 2;
}

/// A frame ends if MA rests for this time or longer: the shortest timeout after an edge of MA.
///   fixed     Timeout::shortest, by default D2's minimum, or `time` if that is shorter
///   adaptive  1.5 periods, which the device measures in each frame, but at most the static timeout,
///             which applies until then: Timeout::shortest, by default D2's minimum
///   cycle     release_time(), in the whole cycle. It is not used that SLO may stay low for longer
///             at the beginning of a cycle: no source promises it
/// The default Timeout means that nothing is stated; the device may then be an adaptive one.
/// \pre period is positive
constexpr Picoseconds shortest_timeout(const Timeout& timeout, Picoseconds period) {
  if (timeout.rule == TimeoutRule::cycle)
    return std::int64_t{timeout.release_half_periods} * period / 2;
  const Picoseconds fixed = timeout.shortest.count != 0 ? timeout.shortest
                            : timeout.rule == TimeoutRule::fixed
                                ? std::min(timeout.time, biss_static_timeout_min)
                                : biss_static_timeout_min;
  const bool may_be_adaptive = timeout.rule == TimeoutRule::adaptive || timeout == Timeout{};
  return may_be_adaptive ? std::min(3 * period / 2, fixed) : fixed;
}

/// The defaults are the widest that BiSS C allows.
struct DeviceTiming {
  Hertz clock_min = biss_clock_min;
  Hertz clock_max = biss_clock_max;
  /// From the first rising edge of MA (LAT) to START, at least. 0: not known; it is always two
  /// clocks or more.
  Picoseconds start_min{};
  /// From the second rising edge of MA (ACK) until the encoder has its answer; START comes with the
  /// next rising edge.
  Picoseconds ack_max = biss_busy_max;
  /// Clocks of ACK of a device that always takes the same number; 0: not fixed.
  std::uint16_t ack_clocks = 0;
  Timeout timeout{};
  /// MA to SLO inside the encoder, at most.
  Picoseconds internal_delay_max{};
  /// From one request to the next, at least; 0: limited by the frame only.
  Picoseconds cycle_min{};
  /// When the position was taken, from the first rising edge of MA; all 0: at that edge.
  Picoseconds sampling_min{};
  Picoseconds sampling_typical{};
  Picoseconds sampling_max{};
  /// The clock must not change within a request, nor pause.
  bool clock_constant = false;
  /// MA must be high for half of each period.
  bool duty_even = false;

  constexpr bool operator==(const DeviceTiming&) const = default;
};

/// The bounds of ACK in clocks of this period. ACK ends on a rising edge, so its longest time is
/// rounded up.
struct AckBounds {
  std::uint16_t min_clocks = 1;
  std::uint16_t max_clocks = biss_ack_max_clocks;

  constexpr bool operator==(const AckBounds&) const = default;
};

/// \pre period is positive
constexpr AckBounds ack_bounds(const DeviceTiming& timing, Picoseconds period) {
  if (timing.ack_clocks != 0) return {timing.ack_clocks, timing.ack_clocks};
  constexpr std::int64_t most = biss_ack_max_clocks;
  const std::int64_t longest =
      std::clamp<std::int64_t>(clocks_to_cover(timing.ack_max, period), 1, most);
  // LAT to START is one clock more than ACK to START.
  const std::int64_t shortest =
      std::clamp<std::int64_t>(clocks_to_cover(timing.start_min, period) - 1, 1, longest);
  return {static_cast<std::uint16_t>(shortest), static_cast<std::uint16_t>(longest)};
}

}  // namespace biss
