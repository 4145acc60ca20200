#include "biss/axis/encoder_axis.hpp"

#include <array>

#include "firmware/cost/row.hpp"

namespace {

using Codec = biss::FixedCodec<cost::format>;
using Reader = biss::SpiReader<Codec>;
constexpr Reader reader{Codec{}, cost::setup, cost::encoder.timing};

// In place of the DMA, it copies the sample.
struct Spi {
  const std::uint8_t* bytes = nullptr;

  bool start(std::span<std::uint8_t> receive) {
    using Words = std::array<std::uint32_t, (reader.bytes() + 3) / 4>;
    *reinterpret_cast<Words*>(receive.data()) = *reinterpret_cast<const Words*>(bytes);
    return true;
  }
};

using Axis = biss::EncoderAxis<Spi, Reader, reader.bytes()>;
// The limits of the documents.
static_assert(sizeof(Axis) - 2 * ((reader.bytes() + 3) / 4 * 4) <= 160 || sizeof(void*) != 4);

constinit Spi spi;
constinit Axis axis{spi, reader, cost::axis_setup};

}  // namespace

// Enough samples for rare events.
BISS_ROW_TIMES(axis, "axis: request, SPI buffer to position with turns, limits and rules", cycle,
               10'000) {
  spi.bytes = s.bytes.data();
  axis.request(biss::Picoseconds{static_cast<std::int64_t>(s.value)});
  axis.transfer_complete();
  return cost::result_of(axis.position());
}
