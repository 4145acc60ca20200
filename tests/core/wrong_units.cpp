// Fractions of a unit, which would be dropped, and rates that do not fit. No line with `refused`
// compiles; refused.cmake tries each.
#include "biss/base/units.hpp"

namespace biss {

void fractions(Picoseconds time, float factor) {
  picoseconds(62.5);                       // refused
  nanoseconds(62.5);                       // refused
  microseconds(31.25F);                    // refused
  milliseconds(0.5L);                      // refused
  hertz(0.5);                              // refused
  kilohertz(2.5);                          // refused
  megahertz(2.5);                          // refused
  millimetres(0.5);                        // refused
  metres(0.5);                             // refused
  millivolts(0.5);                         // refused
  static_cast<void>(time * 1.5);           // refused
  static_cast<void>(factor * time);        // refused
  static_cast<void>(time / 2.5);           // refused
  static_cast<void>(Picoseconds(62.5));    // refused
  static_cast<void>(Hertz(2.5));           // refused
  static_cast<void>(Millimetres(factor));  // refused
  static_cast<void>(Nanovolts(62.5));      // refused
}

void rates() {
  hertz(-1);             // refused
  hertz(5'000'000'000);  // refused
  kilohertz(-1);         // refused
  megahertz(-1);         // refused
}

}  // namespace biss
