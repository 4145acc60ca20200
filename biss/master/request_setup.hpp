// The setup of a master, and its reading of each request.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "biss/base/result.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/frame.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

/// How much of an answer a request reads.
enum class RequestKind : std::uint8_t {
  frame,         ///< the whole frame
  control_only,  ///< START and CDS, whether or not the device's channels are active; D2's "short"
                 ///< frame if they are inactive
  reduced,       ///< ACK: two rising edges; CDM is sent, no CDS comes back. INIT with CDM 0
};

/// The setup of a RequestCycle. A time of 0 means the default in its comment.
struct MasterSetup {
  /// Period of MA; at least 32 ps.
  Picoseconds period{};
  /// ACK's bounds, timeout and shortest cycle are respected, and a clock above clock_max is refused.
  DeviceTiming timing{};
  /// Devices in a daisy chain; each after the first delays START by a clock. At least 1.
  std::uint8_t slaves = 1;
  /// START may be this number of clocks later than the moment when the device is ready ("busy_s", 0
  /// to 8).
  std::uint8_t busy_s_clocks = 0;
  /// Samples each bit half a period after it arrives, by the line delay measured in this request.
  /// Off: half a period after the rising edge, one bit a clock, at any line delay.
  bool compensate = true;
  /// CDM if begin() is called without it.
  bool cdm = false;
  /// MA keeps the level of CDM until the next request ("Hold-CDM"): at CDM 1 it rises only
  /// `idle_min` before the first falling edge. D2 recommends it while it is unknown which channels
  /// are active.
  bool hold_cdm = false;
  /// Clocks of MA after the clock of STOP.
  std::uint16_t extra_clocks = 0;
  /// Time that MA is low in each clock; half a period. Less than the period.
  Picoseconds low_time{};
  /// Resolution of the sampling point; a sixteenth of the period, at most a quarter of it.
  Picoseconds sample_step{};
  /// Moves the sampling point from the middle, at most half a period in both directions. With
  /// compensation, half a period samples at the moment of the change.
  Picoseconds sample_shift{};
  /// The wait for ACK. When it is over, the request fails with no_response.
  Picoseconds line_delay_max = biss_line_delay_max;
  /// MA high after a failed request, from its last edge; the rest of the full request cycle, with
  /// the longest ACK and the device's timeout, and at least 40 µs if the timeout is adaptive. A
  /// shorter time is at the caller's risk.
  Picoseconds reset_time{};
  /// Makes the next request to an encoder with TimeoutRule::cycle when its time has passed, as
  /// drives do, without waiting to see SLO high a line delay later; see RequestCycle. Off: every
  /// request waits.
  bool trust_cycle_time = false;
  /// MA high between two requests; half a period. Only CDM 1 comes so close.
  Picoseconds idle_min{};
  /// As in SpiSetup: reads positions without nE, and channels without CRC, too.
  bool no_error_flag = false;
  bool unchecked = false;
};

/// The setup with a value for each default.
constexpr MasterSetup with_defaults(MasterSetup setup) {
  const Picoseconds period = setup.period;
  if (setup.low_time.count == 0) setup.low_time = period / 2;
  if (setup.sample_step.count == 0) setup.sample_step = period / 16;
  setup.sample_step = std::clamp(setup.sample_step, picoseconds(1), period / 4);
  if (setup.idle_min.count == 0) setup.idle_min = period / 2;
  return setup;
}

/// The bounds of ACK at the master: the bounds of the device, plus a clock for each further slave
/// and busy_s.
constexpr AckBounds request_ack_bounds(const MasterSetup& setup) {
  AckBounds bounds = ack_bounds(setup.timing, setup.period);
  const unsigned further = setup.slaves - 1U;
  bounds.min_clocks = static_cast<std::uint16_t>(bounds.min_clocks + further);
  bounds.max_clocks = static_cast<std::uint16_t>(bounds.max_clocks + further + setup.busy_s_clocks);
  return bounds;
}

/// Why no request was made.
enum class Refusal : std::uint8_t {
  none,
  slo_low,    ///< the encoder is not ready, or SLO is stuck or not connected
  too_early,  ///< the device's shortest cycle has not passed, or MA was not high long enough
  setup,      ///< no request is ever made: RequestCycle::error() has the cause
};

/// The result of one request. `Frame` is a type of the codec.
template <class Frame>
struct BasicReading {
  /// The frame, or the one cause:
  ///   not_ready       refused, `refusal` is the reason; MA did not move
  ///   no_response     SLO stayed high
  ///   response_range  SLO was low before ACK could begin (longer than ready_by_time() allows), or
  ///                   ACK came after line_delay_max
  ///   no_start        ACK exceeded the device's bound
  ///   ack_range       START came before the device can answer
  ///   cds, crc, stop_bit  as decode_frame()
  ///   truncated       control_only, reduced: everything that was requested came
  Result<Frame, FrameFault> frame = failure(FrameFault{FrameError::no_response});
  Refusal refusal = Refusal::none;
  /// CDS as received, also in a bad frame; empty if it was not received.
  std::optional<bool> cds{};
  /// The first falling edge of MA, or the time of the refusal.
  Picoseconds begin{};
  /// From the second rising edge of MA to the fall of SLO, both at the master; measured with and
  /// without compensation. Nothing when ACK did not begin.
  std::optional<Picoseconds> line_delay{};
  /// Ones before ACK as sampled, LAT's included: 1 with compensation.
  std::uint16_t lead_clocks = 0;
  /// Zeros of ACK as sampled, 0 when it did not begin.
  std::uint16_t ack_clocks = 0;
  /// Rising edges of MA, without the edge that ends CDM.
  std::uint32_t clocks = 0;
  /// SLO changed within a twentieth of a period of a sampling instant, before or after.
  bool marginal = false;
  /// The encoder accepts the next request: SLO is high at the end, or known to rise.
  bool ready = false;
};

}  // namespace biss
