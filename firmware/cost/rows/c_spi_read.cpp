#include "firmware/cost/c_reader.hpp"
#include "firmware/cost/row.hpp"

// The size in the title.
static_assert(sizeof(biss_spi) == 1504);

BISS_ROW(c_spi_read, "in C: biss_spi_read (1504 bytes) and biss_frame_trusted", buffer) {
  return cost::read_in_c(s);
}
