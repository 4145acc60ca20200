// How a request ends: what was read, and when it is over where SLO does not say so.
#pragma once

#include <algorithm>

#include "biss/base/result.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/request_setup.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

/// Tells what a sampler that has stopped has heard.
template <class Sampler, class Codec>
constexpr void judge(const Sampler& sampler, RequestKind kind, const Codec& codec,
                     BasicReading<typename Codec::Frame>& reading) {
  reading.line_delay = sampler.line_delay();
  reading.lead_clocks = sampler.lead_clocks();
  reading.ack_clocks = sampler.ack_clocks();
  if (sampler.cause()) {
    reading.frame = failure(FrameFault{*sampler.cause()});
  } else if (kind != RequestKind::frame) {
    reading.frame = failure(FrameFault{FrameError::truncated});
  } else {
    const FrameStart start{0, sampler.lead_clocks(), sampler.ack_clocks()};
    reading.frame = decode_payload(sampler.bits(), start, codec);
  }
}

/// The end of MA's rest behind a request that went wrong.
/// \param begin     of the request
/// \param last_edge of MA
/// \param travel    from the master to the device and back, and a period
constexpr Picoseconds reset_end(const MasterSetup& setup, Picoseconds begin, Picoseconds last_edge,
                                Picoseconds travel) {
  const Timeout& timeout = setup.timing.timeout;
  if (setup.reset_time.count != 0) return last_edge + setup.reset_time + travel;
  if (timeout.rule == TimeoutRule::cycle) {
    // STOP has to be seen where the frame is longer than the cycle.
    return std::max(begin + timeout.time, last_edge + release_time(timeout, setup.period)) + travel;
  }
  if (timeout.rule == TimeoutRule::fixed) return last_edge + timeout.time + travel;
  // It depends on a clock that the encoder keeps to itself.
  const Picoseconds adaptive = setup.period * 3 / 2 + timeout.time;
  return last_edge + std::max(biss_static_timeout_max, adaptive) + travel;
}

/// The device is ready when a known time has passed since the request began. Behind a frame that
/// outlasts the time nobody knows when SLO is released: it has to be seen.
constexpr bool released_by_time(const MasterSetup& setup, Picoseconds begin,
                                Picoseconds last_edge) {
  const Timeout& timeout = setup.timing.timeout;
  return timeout.rule == TimeoutRule::cycle && setup.trust_cycle_time && setup.compensate &&
         begin + timeout.time >= last_edge + release_time(timeout, setup.period);
}

}  // namespace biss
