#include "firmware/cost/row.hpp"

namespace {

using Codec = biss::FixedCodec<cost::format>;
constexpr biss::SpiReader<Codec> reader{Codec{}, cost::setup, cost::encoder.timing};

}  // namespace

BISS_ROW(decode_fixed, "SPI buffer to position, 26 bits, format fixed at compile time", buffer) {
  return cost::position_of(reader.read(s.span()));
}
