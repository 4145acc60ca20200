#include "firmware/cost/row.hpp"

BISS_ROW(pins_byte, "without DMA, one byte by two pins: 16 edges of MA and their times",
         pins_byte) {
  s.polled->step();
  return s.bytes[0];
}
