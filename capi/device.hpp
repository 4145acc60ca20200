// What both handles of the C interface need: texts and numbers of C as the core's types.
#pragma once

#include <cstdlib>
#include <new>
#include <optional>

#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"
#include "biss/timing/device_timing.hpp"
#include "capi/biss_c.h"

namespace biss::capi {

/// A format and how its device behaves in time.
struct Device {
  FrameFormat format;
  DeviceTiming timing;
};

/// The catalogue's entry of that name, or the format that the text describes. \pre not null
std::optional<Device> find_device(const char* format);

/// Replaces the timing unless `timing` is null. False: no device can have it.
bool override_timing(const biss_timing* timing, Device& device);

constexpr bool is_duration(std::int64_t count) { return count >= 0 && count <= BISS_DURATION_MAX; }
constexpr bool is_time(std::int64_t count) {
  return count >= -BISS_TIME_MAX && count <= BISS_TIME_MAX;
}

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

/// On the C heap, so that C programs link without the C++ library. Null: no memory.
template <class Handle, class... Arguments>
Handle* make_handle(const Arguments&... arguments) {
  void* memory = std::malloc(sizeof(Handle));
  return memory == nullptr ? nullptr : new (memory) Handle(arguments...);
}

template <class Handle>
void destroy_handle(Handle* handle) {
  if (handle == nullptr) return;
  handle->~Handle();
  std::free(handle);
}

}  // namespace biss::capi
