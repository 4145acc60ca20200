// The two firmwares as the simulation sees them: each is compiled by itself.
#pragma once

#include <cstdint>

#include "biss/base/bits.hpp"
#include "biss/safety/configurations.hpp"
#include "biss/safety/monitor.hpp"
#include "firmware/cross_compare/message.hpp"

namespace cross_compare_run {

inline constexpr auto type = biss::safety_configuration("fs-36-28");
using Plan = biss::FixedSafetyPlan<type.frame_format(), type.setup>;

/// The number of this pair of processors.
inline constexpr std::uint16_t connection = 0x0102;

/// The functions of a processor; see cross_compare::Processor.
struct Firmware {
  bool (*power_up)();
  cross_compare::Message (*evaluate)(std::uint32_t request, const biss::BitView& bits);
  biss::GuardedPosition (*compare)(const biss::TwoClocks& now,
                                   const cross_compare::Message& message);
  bool (*is_safe)(const biss::TwoClocks& now);
  biss::SafetyState (*state)();
  biss::SafetyVerdict (*cause)();
  bool (*acknowledge)(biss::SafetyVerdict cause);
};

extern const Firmware processor_a;
extern const Firmware processor_b;

}  // namespace cross_compare_run
