#include "firmware/cost/row.hpp"

namespace {

using Codec = biss::FixedCodec<cost::format, biss::CrcBitwise>;
constexpr biss::SpiReader<Codec> reader{Codec{}, cost::setup, cost::encoder.timing};

}  // namespace

BISS_ROW(decode_plain, "the same without CRC table", buffer) {
  return cost::position_of(reader.read(s.span()));
}
