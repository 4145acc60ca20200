#include "firmware/cost/c_reader.hpp"
#include "firmware/cost/row.hpp"

// The size in the title.
static_assert(sizeof(biss_spi) == 1528);

BISS_ROW(c_spi_read, "in C: biss_spi_read (1528 bytes) and biss_frame_trusted", buffer) {
  return cost::read_in_c(s);
}
