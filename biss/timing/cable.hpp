// Cable length and sampling. The figures are Renishaw's ("BiSS C-mode (unidirectional)", "Line
// delay compensation" and "Timing information"). For other encoders they are a rule of thumb;
// nothing better is published.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "biss/base/units.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

/// Delay of a cable, to the encoder and back: 10 ns/m.
constexpr Picoseconds cable_delay(Millimetres cable) { return picoseconds(10 * cable.count); }

/// The delay from MA to SLO at the master. \param other_delay the delay inside the encoder and, if
/// known, inside the master, which the data sheet's table of cables leaves out
constexpr Picoseconds line_delay(Millimetres cable, Picoseconds other_delay) {
  return cable_delay(cable) + other_delay;
}

/// How many samples at the beginning of a request may still see SLO low from the previous cycle. If
/// the encoder is ready after a fixed time and the request begins then, these are the samples
/// within the line delay, at most the delay of 100 m of cable; otherwise 0.
/// \param first_sample from the falling edge of MA that begins the request; at most a period
/// \param start_clocks the fewest samples before START, which must not be taken for one of these
/// \pre period and start_clocks are positive
constexpr std::uint16_t late_clocks(const DeviceTiming& timing, Picoseconds period,
                                    Picoseconds line_delay_max, Picoseconds first_sample,
                                    unsigned start_clocks) {
  if (timing.timeout.rule != TimeoutRule::cycle) return 0;
  const Picoseconds longest =
      std::min(line_delay_max, line_delay(metres(100), timing.internal_delay_max));
  const std::int64_t clocks = (longest + period - first_sample).count / period.count;
  return static_cast<std::uint16_t>(std::min<std::int64_t>(clocks, start_clocks - 1U));
}

/// Whether the data sheet's table of cables has a row for this clock. Lengths at other clocks are
/// interpolated by the rules below.
constexpr bool is_published_clock(Hertz clock) {
  return clock == kilohertz(250) || clock == megahertz(1) || clock == megahertz(2) ||
         clock == megahertz(5) || clock == megahertz(10);
}

/// The longest cable for a master that compensates the line delay: 100 m up to 5 MHz, 50 m up to
/// 10 MHz. The data sheet prints 5 and 10 MHz only; between them the shorter one is taken. Above
/// 10 MHz nothing is known.
constexpr std::optional<Millimetres> cable_max_compensated(Hertz clock) {
  if (clock <= megahertz(5)) return metres(100);
  if (clock <= megahertz(10)) return metres(50);
  return std::nullopt;
}

/// The longest cable for a master that samples half a period after its own edge. The line delay may
/// take a quarter of the period. The length is rounded down to 1 m, below 1 m to 0.5 m, and is
/// never more than with compensation. None when less than 0.5 m is left.
/// \param other_delay as for line_delay()
/// \pre clock is not 0 Hz
constexpr std::optional<Millimetres> cable_max_uncompensated(Hertz clock, Picoseconds other_delay) {
  const auto most = cable_max_compensated(clock);
  if (!most) return std::nullopt;
  // Not by period_of(): its rounding could change the length by a step.
  const std::int64_t quarter = picoseconds_per_second / (std::int64_t{4} * clock.count);
  const std::int64_t length = (quarter - other_delay.count) / cable_delay(millimetres(1)).count;
  const std::int64_t step = length < 1'000 ? 500 : 1'000;
  if (length < step) return std::nullopt;
  return std::min(millimetres(length / step * step), *most);
}

/// Whether this cable needs a master that compensates the line delay.
constexpr bool needs_compensation(Hertz clock, Millimetres cable, Picoseconds other_delay) {
  const auto longest = cable_max_uncompensated(clock, other_delay);
  return !longest || cable > *longest;
}

/// Time from a bit's arrival to the moment a master without compensation samples it, half a period
/// after its own rising edge. Negative: it samples the bit before. \pre clock is not 0 Hz
constexpr Picoseconds margin_uncompensated(Hertz clock, Picoseconds delay) {
  return period_of(clock) / 2 - delay;
}

/// The same with compensation: half a period, less the quarter by which the line delay may vary
/// within a frame (protocol description D2, row 8). \pre clock is not 0 Hz
constexpr Picoseconds margin_compensated(Hertz clock) { return period_of(clock) / 4; }

/// When to sample: `whole_clocks` periods and `rest` (less than a period) after the rising edge of
/// MA that produced the bit.
struct SamplingPoint {
  std::int64_t whole_clocks = 0;
  Picoseconds rest{};

  constexpr bool operator==(const SamplingPoint&) const = default;
};

/// The middle of a bit that arrives after `delay`: half a period later.
/// \pre delay is not negative, period is positive
constexpr SamplingPoint sampling_point(Picoseconds delay, Picoseconds period) {
  const std::int64_t after = delay.count + period.count / 2;
  return {after / period.count, picoseconds(after % period.count)};
}

}  // namespace biss
