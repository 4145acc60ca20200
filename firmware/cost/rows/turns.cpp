#include "firmware/cost/row.hpp"

// The counter was prepared with the sample before.
BISS_ROW(turns, "TurnCounter::update, 26 bits", step) {
  s.counter->update(s.value);
  return static_cast<std::uint64_t>(s.counter->turns());
}
