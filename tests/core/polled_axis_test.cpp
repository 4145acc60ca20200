// An axis over an SPI without DMA.
#include <array>

#include "biss/axis/encoder_axis.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/encode.hpp"
#include "biss/master/polled_read.hpp"
#include "biss/master/spi_read.hpp"
#include "tests/core/test.hpp"

namespace biss::polled_axis_test {

constexpr CatalogueEntry encoder = catalogue_encoder("lenz-b3");
using Codec = FrameCodec<CrcFast, 1>;
constexpr Codec codec{encoder.frame_format()};
constexpr SpiSetup setup{.period = microseconds(1),
                         .line_delay = {.max = nanoseconds(700)},
                         .max_pause = microseconds(12)};
constexpr SpiReader<Codec> reader{codec, setup, encoder.timing};

constexpr AxisSetup axis_setup{.cycle = milliseconds(1),
                               .to_sampling = sampling_delay(setup, encoder.timing),
                               .max_step = 10'000,
                               .bad_cycles = BadCycleRule::hold,
                               .trip_after = 3};

// The bytes of a frame, one in 8 us; `interrupt` comes before the third.
struct Board {
  static constexpr Picoseconds time_step = nanoseconds(100);
  Picoseconds time{};
  Picoseconds interrupt{};
  std::array<std::uint8_t, reader.bytes()> line{};
  std::size_t sent = 0;

  Picoseconds now() const { return time; }
  std::uint8_t transfer() {
    time += microseconds(8);
    if (sent == 2) time += interrupt;
    return line[sent++];
  }
  void prepare(std::uint64_t position) {
    BasicFrame<1> frame;
    frame.channel_count = 1;
    frame.lead_clocks = 2;
    frame.ack_clocks = encoder.timing.ack_clocks;
    frame.channel_list[0].position = position;
    const auto bits = encode_frame(frame, codec);
    line = {};
    for (std::size_t i = 0; i < bits->size_bits(); ++i) {
      if (bits->view()[i]) line[i / 8] |= static_cast<std::uint8_t>(0x80U >> (i % 8));
    }
    sent = 0;
  }
};

using Request = PolledRequest<Board>;
static_assert(SpiDma<Request>);

BISS_TEST(PolledAxis, PauseThatIsTooLong_IsOneBadCycle) {
  Board board;
  Request request(board, setup, encoder.timing);
  EncoderAxis<Request, decltype(reader), reader.bytes()> axis(request, reader, axis_setup);
  BISS_ASSERT(!axis.error());
  for (unsigned i = 1; i <= 10; ++i) {
    const bool bad = i == 7;
    board.prepare(1000 * i);
    board.interrupt = microseconds(bad ? 12 : 10);
    axis.request(board.time);
    while (request.step() == PolledState::running) continue;
    BISS_EXPECT_EQ(request.state() == PolledState::paused, bad);
    if (bad) {
      axis.transfer_failed();
    } else {
      axis.transfer_complete();
    }
    if (i == 1) continue;  // the second frame confirms it
    BISS_EXPECT_EQ(axis.position().position, bad ? 6000 : 1000 * i);
    BISS_EXPECT_EQ(axis.position().state, bad ? AxisState::held : AxisState::measured);
  }
  BISS_EXPECT_EQ(axis.axis().counts()[AxisCause::failed], 1U);
}

}  // namespace biss::polled_axis_test
