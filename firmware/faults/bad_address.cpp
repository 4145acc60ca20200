// Calls into memory that never executes. The fault must be reported.
#include <cstdint>

#include "firmware/platform/startup.hpp"

int firmware_main() {
  volatile std::uintptr_t nowhere = 0xA000'0001U;
  reinterpret_cast<void (*)()>(nowhere)();
  return 0;
}
