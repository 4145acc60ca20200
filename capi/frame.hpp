// Frames of the core as frames of C.
#pragma once

#include "biss/base/result.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/spi_read.hpp"
#include "capi/biss_c_frame.h"
#include "capi/device.hpp"

namespace biss::capi {

biss_frame as_c(const Result<Frame, FrameFault>& from);
biss_bounds as_c(const FrameBounds& bounds);
/// \pre each number has 16 bits
FrameBounds bounds_from_c(const biss_bounds& bounds);
/// Why the core's check_spi() refuses this setup; BISS_OK if it does not.
biss_status check_spi(const Described& device, const SpiSetup& setup);

}  // namespace biss::capi
