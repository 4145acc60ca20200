#include "lab/monitor.hpp"

#include <cstring>

namespace biss::lab {

Monitor::Monitor(SharedSafetyPlan plan) : monitor_(plan) {}

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

MonitorState::MonitorState(const Monitor& monitor) {
  std::memcpy(bytes_.data(), static_cast<const void*>(&monitor.monitor_), sizeof monitor.monitor_);
}

void MonitorState::put_into(Monitor& monitor) const {
  std::memcpy(static_cast<void*>(&monitor.monitor_), bytes_.data(), sizeof monitor.monitor_);
}

}  // namespace biss::lab
