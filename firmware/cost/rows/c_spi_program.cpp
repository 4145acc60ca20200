#include "firmware/cost/c_reader.hpp"
#include "firmware/cost/row.hpp"

BISS_ROW(c_spi_program, "the same program in C", buffer) {
  return cost::make_c_reader() == BISS_OK ? cost::read_in_c(s) : 0;
}
