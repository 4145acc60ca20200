#include "firmware/cost/row.hpp"

BISS_ROW(word, "BitView::word, 28 bits at any offset", word) { return s.bits().word(s.index, 28); }
