// Uses the installed core the way another project would.
#include <cstdint>
#include <cstdio>

#include "biss/base/bits.hpp"
#include "biss/base/units.hpp"

int main() {
  biss::BitBuffer<64> bits;
  bits.append(0x2A, 6);
  const bool same = bits.view().word(0, 6) == 0x2A;
  const bool period = biss::period_of(biss::megahertz(10)) == biss::nanoseconds(100);
  std::puts(same && period ? "the installed core works" : "the installed core is wrong");
  return same && period ? 0 : 1;
}
