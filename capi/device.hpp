// Conversions between the data of the C interface and the core's types.
#pragma once

#include <cstdint>
#include <initializer_list>

#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"
#include "biss/timing/device_timing.hpp"
#include "capi/biss_c.h"
#include "capi/object.hpp"

namespace biss::capi {

/// A biss_format in the types of the core.
struct Described {
  FrameFormat format;
  DeviceTiming timing;
};

biss_format as_c(const FrameFormat& format, const DeviceTiming& timing);
/// \return BISS_NULL_ARGUMENT, BISS_BAD_FORMAT or BISS_BAD_TIMING: `to` is not complete
biss_status read(const biss_format* from, Described& to);
/// Whether this is a checksum, also with the errors of a maker.
bool is_checksum(const CrcSpec& crc);

constexpr bool is_duration(std::int64_t count) { return count >= 0 && count <= BISS_DURATION_MAX; }
constexpr bool is_time(std::int64_t count) {
  return count >= -BISS_TIME_MAX && count <= BISS_TIME_MAX;
}

// A loop, which is less code than an algorithm.
constexpr bool are_durations(std::initializer_list<std::int64_t> counts) {
  for (const std::int64_t count : counts) {
    if (!is_duration(count)) return false;
  }
  return true;
}

/// The channels of a frame. \return their number \pre there is room for max_channels
std::uint32_t put_channels(const Frame& frame, biss_channel* channels);

/// Remembers the last time of an object.
class Clock {
 public:
  biss_status check(std::int64_t now) const {
    if (!is_time(now)) return BISS_TIME_RANGE;
    return now < last_ ? BISS_TIME_BACKWARDS : BISS_OK;
  }
  void set(std::int64_t now) { last_ = now; }

 private:
  std::int64_t last_ = -BISS_TIME_MAX;
};

}  // namespace biss::capi
