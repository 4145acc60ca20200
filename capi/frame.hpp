// Frames of the core as frames of C.
#pragma once

#include "biss/base/result.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/spi_read.hpp"
#include "capi/biss_c_frame.h"
#include "capi/device.hpp"

namespace biss::capi {

/// Fills in a biss_frame or a biss_reading, in place because they are large. \return whether there
/// is a frame \pre `to` is {}
template <class To>
bool put_result(const Result<Frame, FrameFault>& from, To& to) {
  if (!from.ok()) {
    to.cause = static_cast<biss_cause>(1 + static_cast<int>(from.error().cause));
    to.cause_channel = from.error().channel;
    return false;
  }
  to.channel_count = put_channels(*from, to.channels);
  to.cds = from->cds;
  return true;
}
void put(const Result<Frame, FrameFault>& from, biss_frame& to);
/// The object of a biss_spi.
struct Spi {
  Spi(const Described& device, const SpiSetup& chosen)
      : setup(chosen),
        to_sampling(sampling_delay(chosen, device.timing)),
        reader(FrameCodec<>(device.format), chosen, device.timing) {}

  SpiSetup setup;
  Picoseconds to_sampling;
  SpiReader<FrameCodec<>> reader;
};
/// Why the core's check_spi() refuses this setup; BISS_OK if it does not.
biss_status check_spi(const Described& device, const SpiSetup& setup);

}  // namespace biss::capi
