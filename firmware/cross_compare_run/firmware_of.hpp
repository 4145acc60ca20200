// A processor's firmware, as one table of functions.
#pragma once

#include <memory>

#include "firmware/cross_compare/processor.hpp"
#include "firmware/cross_compare_run/processors.hpp"

namespace cross_compare_run {

/// The firmware with this evaluation; each processor's source makes one.
template <class Evaluation>
struct FirmwareOf {
  static inline constinit cross_compare::Processor<Plan, Evaluation> processor;

  static constexpr Firmware functions{
      // A power-up begins with a memory that was reset.
      .power_up =
          [] {
            std::construct_at(&processor);
            return processor.power_up();
          },
      .evaluate = [](std::uint32_t request,
                     const biss::BitView& bits) { return processor.evaluate(request, bits); },
      .compare =
          [](const biss::TwoClocks& now, const cross_compare::Message& message) {
            return processor.compare(now, message);
          },
      .is_safe = [](const biss::TwoClocks& now) { return processor.is_safe(now); },
      .state = [] { return processor.state(); },
      .cause = [] { return processor.cause(); },
      .acknowledge = [](biss::SafetyVerdict cause) { return processor.acknowledge(cause); }};
};

}  // namespace cross_compare_run
