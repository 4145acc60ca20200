#include "firmware/cost/row.hpp"

// The size in the title.
static_assert(sizeof(cost::SafetyMonitor) == 96);

// Enough samples for rare events: random and hostile frames.
BISS_ROW_TIMES(safety_frame, "safety monitor (96 bytes), frame of 36 + 28 bits, with decode",
               safety_frame, 100'000) {
  const biss::SafetyJudgement judgement =
      s.safety->step(cost::clocks_at(static_cast<std::int64_t>(s.value)), s.bits());
  return cost::result_of(judgement);
}
