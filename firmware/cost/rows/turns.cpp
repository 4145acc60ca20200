#include "firmware/cost/row.hpp"

// prepare::step() has counted the sample before this one.
BISS_ROW(turns, "TurnCounter::update, 26 bits", step) {
  s.counter->update(s.value);
  return static_cast<std::uint64_t>(s.counter->turns());
}
