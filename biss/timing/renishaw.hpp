// Renishaw's timing, the same for all RESOLUTE and FORTiS encoders, with BiSS C and BiSS Safety.
#pragma once

#include "biss/base/units.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

/// Source: the data sheets "BiSS C-mode (unidirectional)" and "BiSS Safety for RESOLUTE and FORTiS
/// encoders", both "Timing information" and "Timeout".
inline constexpr DeviceTiming renishaw_timing{
    .clock_min = kilohertz(250),
    .clock_max = megahertz(10),
    .start_min = nanoseconds(3'225),
    .ack_max = microseconds(16),
    .timeout = {TimeoutRule::cycle, nanoseconds(31'250)},
    .internal_delay_max = picoseconds(42'500),
    .cycle_min = nanoseconds(31'250),
    .sampling_min = nanoseconds(3'225),
    .sampling_typical = nanoseconds(3'250),
    .sampling_max = nanoseconds(3'275),
    .clock_constant = true,
    .duty_even = true,
};

/// 100 m of cable at 10 ns/m for both ways, the longest that the data sheets allow, and the delay
/// inside the encoder.
inline constexpr Picoseconds renishaw_line_delay_max =
    microseconds(1) + renishaw_timing.internal_delay_max;

}  // namespace biss
