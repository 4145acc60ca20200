#include "firmware/cost/row.hpp"

namespace {

constexpr biss::CrcFast engine{biss::crc6};

}  // namespace

BISS_ROW(crc6, "CRC6 of 28 bits", crc) { return engine(s.value, 28); }
