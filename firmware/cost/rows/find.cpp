#include "firmware/cost/row.hpp"

BISS_ROW(find, "BitView::find, 33 to 160 zeros before the 1", ack) {
  return s.bits().find(true, 2);
}
