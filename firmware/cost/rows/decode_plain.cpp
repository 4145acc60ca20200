#include "firmware/cost/row.hpp"

namespace {

constexpr biss::SpiReader<cost::PlainCodec> reader{cost::PlainCodec{cost::format}, cost::setup,
                                                   cost::encoder.timing};

}  // namespace

BISS_ROW(decode_plain, "the same without CRC table", buffer) {
  return cost::position_of(reader.read(s.span()));
}
