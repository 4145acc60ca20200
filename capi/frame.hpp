// Frames of the core as frames of C.
#pragma once

#include "biss/base/result.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/spi_read.hpp"
#include "capi/biss_c_frame.h"
#include "capi/device.hpp"

namespace biss::capi {

/// In place: a biss_frame is large.
void put(const Result<Frame, FrameFault>& from, biss_frame& to);
/// Why the core's check_spi() refuses this setup; BISS_OK if it does not.
biss_status check_spi(const Described& device, const SpiSetup& setup);

}  // namespace biss::capi
