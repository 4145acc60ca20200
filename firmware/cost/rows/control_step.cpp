#include "firmware/cost/row.hpp"

// The size in the title.
static_assert(sizeof(biss::ControlSession) == 80);

BISS_ROW(control_step, "control session (80 bytes), one step", control_frame) {
  const bool cdm = s.control->step(biss::Picoseconds{static_cast<std::int64_t>(s.value)},
                                   static_cast<biss::CdsBit>(s.index));
  return (s.control->done() ? 2U : 0U) | (cdm ? 1U : 0U);
}
