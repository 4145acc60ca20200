// An image with a static constructor. It has to fail at the linker.
#include "firmware/platform/startup.hpp"

namespace {

volatile int zero = 0;
const int made_at_start = zero + 1;

}  // namespace

int firmware_main() { return made_at_start; }
