#include "firmware/control_loop/encoder_axis.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "biss/base/wrapping_time.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/encode.hpp"
#include "biss/master/spi_read.hpp"
#include "tests/core/test.hpp"

namespace control_loop {
namespace encoder_axis_test {

constexpr biss::CatalogueEntry encoder = biss::catalogue_encoder("resolute-26");
constexpr biss::Picoseconds ma_period = biss::period_of(biss::megahertz(10));
constexpr biss::FrameCodec<biss::CrcFast, 1> codec{encoder.frame_format()};
constexpr biss::SpiReader<biss::FrameCodec<biss::CrcFast, 1>> reader{
    codec, {.period = ma_period, .line_delay = {.max = biss::nanoseconds(700)}}, encoder.timing};
constexpr PolicyLimits limits{.rule = BadFrameRule::hold, .trip_after = 3, .max_step = 1'000'000};
// Half a clock to the first rising edge, 3.25 us to the sampling moment.
constexpr biss::Picoseconds to_sampling = biss::nanoseconds(50 + 3'250);

// An SPI whose transfer ends when the test says so.
struct Spi {
  std::span<std::uint8_t> receive{};
  bool busy = false;

  constexpr bool start(std::span<std::uint8_t> into) {
    if (busy) return false;
    busy = true;
    receive = into;
    return true;
  }
  // A good frame with this position.
  constexpr void answer(std::uint64_t position) {
    busy = false;
    biss::BasicFrame<1> frame;
    frame.channel_count = 1;
    frame.lead_clocks = 3;
    frame.ack_clocks = 40;
    frame.channel_list[0].position = position;
    const auto bits = biss::encode_frame(frame, codec);
    std::fill(receive.begin(), receive.end(), std::uint8_t{0});
    for (std::size_t i = 0; i < bits->size_bits(); ++i) {
      if (bits->view()[i]) receive[i / 8] |= static_cast<std::uint8_t>(0x80U >> (i % 8));
    }
  }
};

struct Axis {
  PolicyLimits chosen = limits;
  Spi spi{};
  EncoderAxis<Spi, biss::SpiReader<biss::FrameCodec<biss::CrcFast, 1>>, reader.bytes()> axis{
      spi, reader, ma_period, encoder.timing, chosen};

  constexpr void good(biss::Picoseconds now, std::uint64_t position) {
    axis.request(now);
    spi.answer(position);
    axis.transfer_complete();
  }
};

BISS_TEST(EncoderAxis, AnswerOfALateTransfer_HasTheTimeOfItsOwnRequest) {
  Axis a;
  a.good(biss::microseconds(100), 1000);
  a.axis.request(biss::microseconds(200));
  a.axis.request(biss::microseconds(300));  // refused
  a.spi.answer(1100);
  a.axis.transfer_complete();
  BISS_EXPECT(a.axis.latest().output.quality == Quality::measured);
  BISS_EXPECT_EQ(a.axis.latest().moment.count, (biss::microseconds(200) + to_sampling).count);
}

BISS_TEST(EncoderAxis, RequestsThatAreNeverAnswered_Trip) {
  Axis a;
  a.good(biss::microseconds(100), 1000);
  for (int i = 2; i <= 4; ++i) {
    a.axis.request(biss::microseconds(100 * i));
    a.spi.busy = false;  // the interrupt was lost
    BISS_EXPECT_EQ(a.axis.latest().output.bad_in_a_row, i - 2);
  }
  a.axis.request(biss::microseconds(500));
  BISS_EXPECT(a.axis.latest().output.quality == Quality::tripped);
}

BISS_TEST(EncoderAxis, TransferThatFails_IsOneBadCycle) {
  Axis a;
  a.good(biss::microseconds(100), 1000);
  a.axis.request(biss::microseconds(200));
  a.spi.busy = false;
  a.axis.transfer_failed();
  BISS_EXPECT_EQ(a.axis.latest().output.bad_in_a_row, 1);
  BISS_EXPECT(a.axis.latest().output.quality == Quality::held);
  a.good(biss::microseconds(300), 1100);
  BISS_EXPECT(a.axis.latest().output.quality == Quality::measured);
  BISS_EXPECT_EQ(a.axis.latest().output.position, 1100);
}

BISS_TEST(EncoderAxis, StepBelowHalfATurnWithoutALimit_IsMeasured) {
  Axis a{{.rule = BadFrameRule::hold, .trip_after = 3, .max_step = no_step_limit}};
  a.good(biss::microseconds(100), 1000);
  a.good(biss::microseconds(200), 1000 + (1U << 25U) - 1U);
  BISS_EXPECT(a.axis.latest().output.quality == Quality::measured);
  a.good(biss::microseconds(300), 999);
  BISS_EXPECT(a.axis.latest().output.quality == Quality::held);
}

// The age of a position one period after its request; the clock wraps around in between.
constexpr biss::Picoseconds age_across_the_wrap(biss::Picoseconds before) {
  constexpr biss::Picoseconds period = biss::microseconds(100);
  const biss::Picoseconds end_of_time{std::numeric_limits<std::int64_t>::max()};
  const biss::Picoseconds now = end_of_time - before;
  Axis a;
  a.good(now, 1000);
  return a.axis.latest().age(biss::wrapping_later(now, period));
}
static_assert(age_across_the_wrap(biss::microseconds(1)) == biss::microseconds(100) - to_sampling);
static_assert(age_across_the_wrap(biss::microseconds(50)) == biss::microseconds(100) - to_sampling);

BISS_TEST(EncoderAxis, ClockThatWrapsAround_ChangesNoAge) {
  for (std::int64_t before = 0; before < 100; ++before) {
    BISS_EXPECT_EQ(age_across_the_wrap(biss::microseconds(before)).count,
                   (biss::microseconds(100) - to_sampling).count);
  }
}

}  // namespace encoder_axis_test
}  // namespace control_loop
