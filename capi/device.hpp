// Conversions for the handles of the C interface: texts and numbers of C to the core's types.
#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>

#include "biss/configure/named_device.hpp"
#include "biss/frame/frame.hpp"
#include "capi/biss_c.h"
#include "capi/handle_table.hpp"

namespace biss::capi {

using biss::Device;

/// \pre not null
std::optional<Device> find_device(const char* format);

biss_timing as_c(const DeviceTiming& timing);

/// Replaces the timing unless `timing` is null. False: no device can have it.
bool override_timing(const biss_timing* timing, Device& device);

constexpr bool is_duration(std::int64_t count) { return count >= 0 && count <= BISS_DURATION_MAX; }
constexpr bool is_time(std::int64_t count) {
  return count >= -BISS_TIME_MAX && count <= BISS_TIME_MAX;
}

constexpr bool are_durations(std::initializer_list<std::int64_t> counts) {
  return std::all_of(counts.begin(), counts.end(), is_duration);
}
/// Whether each number has a place in an `Integer`.
template <class Integer>
constexpr bool all_fit(std::initializer_list<std::uint32_t> numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](std::uint32_t number) {
    return number <= std::numeric_limits<Integer>::max();
  });
}

biss_channel as_c(const Channel& channel);
/// The channels of a frame. \return their number \pre there is room for max_channels
std::uint32_t put_channels(const Frame& frame, biss_channel* channels);
/// 0: ok.
biss_cause cause_of(const FrameFault& fault);

/// Remembers the last time of a handle.
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
