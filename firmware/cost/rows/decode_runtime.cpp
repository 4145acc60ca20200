#include "firmware/cost/row.hpp"

BISS_ROW(decode_runtime, "the same, format known at run time", buffer) {
  return cost::position_of(s.reader->read(s.span()));
}
