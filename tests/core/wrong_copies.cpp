// Copies of a SafetyMonitor, which would undo its faults, and of a buffer, which the transfer would
// not fill. No line with `refused` compiles; refused.cmake tries each.
#include <utility>

#include "biss/axis/freshness.hpp"
#include "biss/safety/configurations.hpp"
#include "biss/safety/monitor.hpp"

namespace biss {

constexpr auto type = safety_configuration("fs-36-28");
using Monitor = SafetyMonitor<FixedSafetyPlan<type.frame_format(), type.setup>>;

struct Machine {
  Monitor monitor;
};

void copies(Monitor& monitor, Monitor& other, Machine& machine, Machine& spare) {
  const Monitor saved = monitor;             // refused
  const Monitor moved = std::move(monitor);  // refused
  monitor = other;                           // refused
  monitor = std::move(other);                // refused
  monitor = Monitor();                       // refused
  const Machine kept = machine;              // refused
  machine = spare;                           // refused
}

Monitor power_up() {
  Monitor monitor;
  static_cast<void>(monitor.self_test());
  return monitor;  // refused
}

void copies(FreshBuffer<8>& buffer, FreshBuffer<8>& other) {
  const FreshBuffer<8> saved = buffer;             // refused
  const FreshBuffer<8> moved = std::move(buffer);  // refused
  buffer = other;                                  // refused
  buffer = std::move(other);                       // refused
}

}  // namespace biss
