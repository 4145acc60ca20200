// What a configuration is told, and what it asks for.
#pragma once

#include <cstdint>
#include <limits>

#include "biss/base/units.hpp"
#include "biss/configure/configuration.hpp"
#include "biss/control/control_outcome.hpp"
#include "biss/eds/remark.hpp"
#include "biss/master/request_setup.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

struct ConfigureOptions {
  /// Deactivates the channels meanwhile, which makes each request short. Slaves need not obey.
  bool switch_channels = true;
  /// From one request's CDS to the next request. Shorter: at the caller's risk.
  Picoseconds cycle = common_cycle;
  /// MA high before and behind INIT, at least (D2: 40 µs).
  Picoseconds init_rest = biss_static_timeout_max;
  /// Each access is tried again so many times.
  ControlOptions control{.retries = 3};
  /// Of a device that does not say: what every slave takes.
  Hertz unstated_clock_max = common_clock_max;
  /// A whole chain of eight with all data sheets needs some 80 000 requests, 20 s.
  std::uint32_t max_requests = 200'000;
  /// What no document settles about EDS and profiles.
  EdsDeviceOptions eds{};
};

/// The next request to make.
struct ConfigureRequest {
  RequestKind kind = RequestKind::reduced;
  /// CDM where answer() gives no other.
  bool cdm = false;
  /// Not before.
  Picoseconds at{std::numeric_limits<std::int64_t>::min()};
};

}  // namespace biss
