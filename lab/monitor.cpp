#include "lab/monitor.hpp"

#include <cstring>

namespace biss::lab {

Monitor::Monitor(SharedSafetyPlan plan) : monitor_(plan) {}

Monitor::Monitor(const Monitor& other) : monitor_(other.monitor_.plan()) { *this = other; }

Monitor& Monitor::operator=(const Monitor& other) {
  std::memmove(static_cast<void*>(&monitor_), &other.monitor_, sizeof monitor_);
  return *this;
}

bool Monitor::self_test() { return monitor_.self_test(monitor_.plan().fingerprint()); }

SafetyJudgement Monitor::step(Picoseconds now, const BitView& bits) {
  return monitor_.step(OneClock{now}, bits);
}

SafetyJudgement Monitor::step(Picoseconds now, const SafetyFinding& finding) {
  return monitor_.step(OneClock{now}, finding, finding);
}

SafetyJudgement Monitor::watch(Picoseconds now) { return monitor_.watch(OneClock{now}); }

std::optional<Picoseconds> Monitor::deadline() const { return monitor_.deadline(); }

void Monitor::expect_position(std::uint64_t low, std::uint64_t high) {
  monitor_.expect_position(low, high);
}

void Monitor::acknowledge() { monitor_.acknowledge(monitor_.latched_cause()); }

void Monitor::encoder_restarted() { monitor_.encoder_restarted(); }

SafetyState Monitor::state() const { return monitor_.state(); }

}  // namespace biss::lab
