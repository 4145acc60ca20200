#include "lab/monitor.hpp"

namespace biss::lab {

Monitor::Monitor(SharedSafetyPlan plan) : monitor_(plan) {}

bool Monitor::self_test() { return monitor_.self_test(); }

SafetyJudgement Monitor::step(Picoseconds now, const BitView& bits) {
  return monitor_.step(now, bits);
}

SafetyJudgement Monitor::step(Picoseconds now, const SafetyFinding& finding) {
  return monitor_.step(now, finding, finding);
}

SafetyJudgement Monitor::watch(Picoseconds now) { return monitor_.watch(now); }

std::optional<Picoseconds> Monitor::deadline() const { return monitor_.deadline(); }

void Monitor::acknowledge() { monitor_.acknowledge(); }

void Monitor::restart() { monitor_.restart(); }

SafetyState Monitor::state() const { return monitor_.state(); }

}  // namespace biss::lab
