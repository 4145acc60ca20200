// Frames of the core as frames of C.
#pragma once

#include "biss/base/result.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/spi_read.hpp"
#include "capi/biss_c_frame.h"
#include "capi/device.hpp"

namespace biss::capi {

/// In place: a biss_frame is large.
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
