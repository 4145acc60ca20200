// How one slave behaves in time: a device of a type that DeviceTiming describes, with one value
// where the type has a range.
#pragma once

#include <algorithm>
#include <cstdint>

#include "biss/base/units.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

/// The defaults: position taken at LAT, an answer ready at once, the longest timeout.
struct SlaveTiming {
  /// From the first rising edge of MA (LAT) to the moment whose position is sent; not negative.
  Picoseconds sampling{};
  /// From LAT: START never comes before; nor before the sampling moment.
  Picoseconds start_min{};
  /// From the second rising edge (ACK) until the answer is ready: START comes with the first rising
  /// edge at that moment or later, the third at the earliest.
  Picoseconds ready{};
  /// Clocks of ACK where the device always takes the same, in place of start_min and ready; 0: not
  /// fixed.
  std::uint16_t ack_clocks = 0;
  /// START comes this many clocks later than it could ("busy_s").
  std::uint8_t busy_s_clocks = 0;
  /// By the rule `cycle` the time is to be longer than 1.5 periods of MA.
  Timeout timeout{};
  /// The timeout while the period of MA is not yet measured, where the rule is `adaptive`; and the
  /// longest that a measured one can be, so that MA held high always ends a frame.
  Picoseconds static_timeout = biss_static_timeout_max;
  /// SLI comes from another slave. False: SLI is tied low, and this slave makes START and STOP.
  bool chained = false;

  constexpr bool operator==(const SlaveTiming&) const = default;
};

/// A typical device of this type.
/// \param ready from ACK until it has its answer; more than the type's longest is cut to that
constexpr SlaveTiming slave_timing(const DeviceTiming& timing, Picoseconds ready = {}) {
  return {.sampling = timing.sampling_typical,
          .start_min = timing.start_min,
          .ready = std::min(ready, timing.ack_max),
          .ack_clocks = timing.ack_clocks,
          .timeout = timing.timeout};
}

}  // namespace biss
