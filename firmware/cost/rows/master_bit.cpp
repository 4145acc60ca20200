#include "firmware/cost/row.hpp"

BISS_ROW(master_bit, "master, one bit of data: edges of MA and SLO, sample", data_sample) {
  const biss::Picoseconds rise{static_cast<std::int64_t>(s.value)};
  const biss::Picoseconds fall = rise + cost::setup.period / 2;
  const bool slo = s.index == 0;
  s.master->step(rise, !slo);
  s.master->step(rise + cost::master_line_delay, slo);
  s.master->step(fall, slo);
  const biss::StepOutput out = s.master->step(fall + cost::master_line_delay, slo);
  return static_cast<std::uint64_t>(out.deadline.count) ^ (out.level ? 1U : 0U);
}
