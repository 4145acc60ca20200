// An image that allocates. It has to fail at the linker.
#include "firmware/platform/startup.hpp"

int firmware_main() {
  volatile int size = 4;
  const int* made = new int[static_cast<unsigned>(size)]();
  return made[0];
}
