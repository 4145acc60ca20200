#include "firmware/cost/row.hpp"

BISS_ROW(slave_bit, "slave, one bit of data: both edges of MA", data_bit) {
  const biss::Picoseconds falling{static_cast<std::int64_t>(s.value)};
  s.slave->step(falling, false, false);
  const biss::StepOutput out = s.slave->step(falling + cost::setup.period / 2, true, false);
  return static_cast<std::uint64_t>(out.deadline.count) ^ (out.level ? 1U : 0U);
}
