// For machines without threads: takes the place of cycle_flow.cpp.
#include "flow/cycle_flow.hpp"

namespace biss::flow {

void CycleFlow::run(unsigned /*threads*/, const std::function<bool()>& go_on) {
  while (step() && (!go_on || go_on())) {
  }
}

}  // namespace biss::flow
