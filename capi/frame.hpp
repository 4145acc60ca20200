// Frames of the core as frames of C, and the handle of a format.
#pragma once

#include "biss/base/result.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/spi_read.hpp"
#include "capi/biss_c_frame.h"
#include "capi/device.hpp"

namespace biss::capi {

biss_frame as_c(const Result<Frame, FrameFault>& from);
biss_bounds as_c(const FrameBounds& bounds);
/// \pre each number has 16 bits
FrameBounds bounds_from_c(const biss_bounds& bounds);
/// The text of a format, ended by 0. \param length of the text, also without room; may be null
biss_status put_text(const FrameFormat& format, char* text, std::size_t room,
                     std::size_t* length = nullptr);
/// Why the core's check_spi() refuses this setup; BISS_OK if it does not.
biss_status check_spi(const Device& device, const SpiSetup& setup);

}  // namespace biss::capi

struct biss_format {
  explicit biss_format(const biss::Device& device) : codec(device.format), timing(device.timing) {}

  biss::FrameCodec<> codec;
  biss::DeviceTiming timing;
};
