// Recurses until the stack is full. The fault must be reported.
#include "firmware/platform/startup.hpp"

namespace {

volatile bool endless = true;

int deeper(int depth) {
  volatile int room[64]{};
  room[depth % 64] = depth;
  if (!endless) return 0;
  return deeper(depth + 1) + room[depth % 64];
}

}  // namespace

int firmware_main() { return deeper(0); }
