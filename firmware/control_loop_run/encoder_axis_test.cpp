#include "firmware/control_loop/encoder_axis.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <type_traits>

#include "biss/base/wrapping_time.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
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

BISS_TEST(EncoderAxis, TransferThatWritesNothing_IsNoResponse) {
  Axis a;
  a.good(biss::microseconds(100), 1000);
  a.good(biss::microseconds(200), 1100);
  for (int i = 1; i <= 2; ++i) {
    a.axis.request(biss::microseconds(200 + 100 * i));
    a.spi.busy = false;
    a.axis.transfer_complete();
    BISS_EXPECT(a.axis.latest().output.quality == Quality::held);
    BISS_ASSERT(a.axis.latest().fault);
    BISS_EXPECT_EQ(a.axis.latest().fault->cause, biss::FrameError::no_response);
    BISS_EXPECT_EQ(a.axis.latest().number, 2U);
  }
  a.good(biss::microseconds(500), 1200);
  BISS_EXPECT(a.axis.latest().output.quality == Quality::measured);
  BISS_EXPECT_EQ(a.axis.latest().number, 5U);
  BISS_EXPECT_EQ(a.axis.counts().causes[biss::FrameError::no_response], 2U);
}

BISS_TEST(EncoderAxis, EndThatNothingWaitsFor_ChangesNothing) {
  Axis a;
  a.axis.transfer_complete();
  a.axis.transfer_failed();
  BISS_EXPECT(a.axis.latest().output.quality == Quality::none);
  BISS_EXPECT_EQ(a.axis.latest().output.bad_in_a_row, 0);
  a.good(biss::microseconds(100), 1000);
  for (int i = 0; i < 3; ++i) a.axis.transfer_complete();
  BISS_EXPECT_EQ(a.axis.latest().number, 1U);
  a.axis.request(biss::microseconds(200));
  a.spi.busy = false;
  a.axis.transfer_failed();
  a.axis.transfer_complete();  // both interrupts of one transfer
  BISS_EXPECT_EQ(a.axis.latest().output.bad_in_a_row, 1);
  BISS_EXPECT_EQ(a.axis.counts().unexpected, 6U);
}

// A transfer that is given up ends later, while its successor is running.
BISS_TEST(EncoderAxis, EndOfAnEarlierTransfer_IsNoFrameOfTheNextOne) {
  Axis a;
  a.good(biss::microseconds(100), 1000);
  a.axis.request(biss::microseconds(200));
  const auto given_up = a.spi;
  a.spi.busy = false;
  a.axis.request(biss::microseconds(300));
  const auto running = a.spi;
  a.spi = given_up;
  a.spi.answer(1100);
  a.axis.transfer_complete();
  BISS_ASSERT(a.axis.latest().fault);
  BISS_EXPECT_EQ(a.axis.latest().fault->cause, biss::FrameError::no_response);
  a.spi = running;
  a.spi.answer(1200);
  a.axis.transfer_complete();
  BISS_EXPECT(a.axis.latest().output.quality == Quality::held);
  BISS_EXPECT_EQ(a.axis.counts().unanswered, 1U);
  BISS_EXPECT_EQ(a.axis.counts().unexpected, 1U);
}

BISS_TEST(EncoderAxis, EncoderThatPowersUp_TripsOnlyAfterItsTime) {
  PolicyLimits chosen = limits;
  chosen.power_up = biss::milliseconds(1);
  Axis a{chosen};
  for (int i = 0; i < 10; ++i) {
    a.axis.request(biss::microseconds(100 * i));
    a.spi.busy = false;
    a.axis.transfer_complete();
    BISS_EXPECT(a.axis.latest().output.quality == Quality::none);
  }
  a.good(biss::microseconds(1000), 1000);
  BISS_EXPECT(a.axis.latest().output.quality == Quality::measured);
}

BISS_TEST(EncoderAxis, EncoderThatNeverAnswers_TripsWhenItsTimeToPowerUpIsOver) {
  for (const bool wraps : {false, true}) {
    Axis a;
    const biss::Picoseconds begin{wraps ? std::numeric_limits<std::int64_t>::max() - 1 : 0};
    std::int64_t tripped_at = 0;
    for (std::int64_t ms = 0; ms < 1200 && tripped_at == 0; ++ms) {
      a.axis.request(biss::wrapping_later(begin, biss::milliseconds(ms)));
      a.spi.busy = false;
      a.axis.transfer_complete();
      if (a.axis.latest().output.quality == Quality::tripped) tripped_at = ms;
    }
    BISS_EXPECT_EQ(tripped_at, 1000);
  }
}

// The first position ends the time to power up.
BISS_TEST(EncoderAxis, EncoderThatIsUnpluggedEarly_Trips) {
  Axis a;
  a.good(biss::microseconds(100), 1000);
  for (int i = 2; i < 5; ++i) {
    a.axis.request(biss::microseconds(100 * i));
    a.spi.busy = false;
    a.axis.transfer_complete();
  }
  BISS_EXPECT(a.axis.latest().output.quality == Quality::tripped);
}

BISS_TEST(EncoderAxis, Reset_StartsAgainWithPowerUpAndTurns) {
  Axis a;
  a.good(biss::milliseconds(100), 1000);
  a.good(biss::milliseconds(101), (1U << 26U) - 1000);  // turn -1
  BISS_EXPECT_EQ(a.axis.latest().output.position, -1000);
  for (int i = 0; i < 3; ++i) {
    a.axis.request(biss::milliseconds(102 + i));
    a.spi.busy = false;
    a.axis.transfer_complete();
  }
  a.good(biss::milliseconds(5'000), 2000);
  BISS_EXPECT(a.axis.latest().output.quality == Quality::tripped);
  a.axis.request(biss::milliseconds(5'001));
  a.axis.reset();
  BISS_EXPECT(a.axis.latest().output.quality == Quality::none);
  BISS_EXPECT_EQ(a.axis.latest().number, 0U);
  a.spi.answer(7000);
  a.axis.transfer_complete();  // of the request before
  BISS_EXPECT(a.axis.latest().output.quality == Quality::none);
  for (int i = 0; i < 900; ++i) {  // the plug is in again, the encoder powers up
    a.axis.request(biss::milliseconds(6'000 + i));
    a.spi.busy = false;
    a.axis.transfer_complete();
  }
  BISS_EXPECT(a.axis.latest().output.quality == Quality::none);
  a.good(biss::milliseconds(6'900), (1U << 26U) - 1000);
  BISS_EXPECT(a.axis.latest().output.quality == Quality::measured);
  BISS_EXPECT_EQ(a.axis.latest().output.position, (1 << 26) - 1000);
}

// ---- Parts that do not fit

// The reader of another encoder, chosen at run time: its bytes do not fit the buffer.
BISS_TEST(EncoderAxis, ReaderThatNeedsMoreThanTheBuffer_IsRefusedAndWritesNothing) {
  Spi spi;
  struct {
    EncoderAxis<Spi, decltype(reader), 8> axis;
    std::array<std::uint8_t, 64> after;
  } memory{EncoderAxis<Spi, decltype(reader), 8>(spi, reader, ma_period, encoder.timing, limits),
           {}};
  BISS_ASSERT(memory.axis.error());
  BISS_EXPECT(*memory.axis.error() == AxisError::buffer);
  for (int i = 0; i < 5; ++i) {
    memory.axis.request(biss::microseconds(100 * i));
    BISS_EXPECT(spi.receive.empty());
    memory.axis.transfer_complete();
  }
  BISS_EXPECT(memory.axis.latest().output.quality == Quality::tripped);
  memory.axis.reset();
  BISS_EXPECT(memory.axis.latest().output.quality == Quality::tripped);
  for (const std::uint8_t byte : memory.after) BISS_EXPECT_EQ(byte, 0);
}

// A constant axis that does not fit does not compile.
template <std::size_t bytes, std::int64_t max_step>
constexpr bool make() {
  Spi spi;
  PolicyLimits chosen = limits;
  chosen.max_step = max_step;
  const EncoderAxis<Spi, decltype(reader), bytes> axis(spi, reader, ma_period, encoder.timing,
                                                       chosen);
  return !axis.error();
}
template <std::size_t bytes, std::int64_t max_step>
concept Compiles = requires {
  typename std::bool_constant<make<bytes, max_step>()>;
};
static_assert(Compiles<reader.bytes(), 1> && !Compiles<reader.bytes() - 1, 1>);
static_assert(!Compiles<reader.bytes(), 0>);

BISS_TEST(EncoderAxis, ReaderFormatOrLimitThatDoesNotFit_HasItsCause) {
  Spi spi;
  const auto error = [&spi](const biss::FrameFormat& format, std::int64_t max_step) {
    using Reader = biss::SpiReader<biss::FrameCodec<biss::CrcFast, 1>>;
    const Reader other(biss::FrameCodec<biss::CrcFast, 1>(format), {.period = ma_period},
                       encoder.timing);
    PolicyLimits chosen = limits;
    chosen.max_step = max_step;
    const EncoderAxis<Spi, Reader, 128> axis(spi, other, ma_period, encoder.timing, chosen);
    return axis.error();
  };
  BISS_EXPECT(!error(encoder.frame_format(), 1));
  BISS_EXPECT(error(encoder.frame_format(), 0) == AxisError::max_step);
  BISS_EXPECT(error(*biss::parse_format("pos26,crc6"), 1) == AxisError::reader);
  BISS_EXPECT(error(*biss::parse_format("pos26,nE,nW"), 1) == AxisError::reader);
  BISS_EXPECT(error(*biss::parse_format("pad8,nE,nW,crc6"), 1) == AxisError::format);
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

// The clock wraps around: half of its range is 106 days.
BISS_TEST(EncoderAxis, SecondRequestAfterMonths_IsNotInTheTimeToPowerUp) {
  for (const std::int64_t days : {1, 106, 107, 200, 213}) {
    Axis a;
    a.axis.request({});
    a.spi.busy = false;
    a.axis.transfer_complete();
    BISS_EXPECT(a.axis.latest().output.quality == Quality::none);
    const biss::Picoseconds later =
        biss::wrapping_later(biss::milliseconds(86'400'000) * (days / 2),
                             biss::milliseconds(86'400'000) * (days - days / 2));
    for (int i = 0; i < limits.trip_after; ++i) {
      a.axis.request(later);
      a.spi.busy = false;
      a.axis.transfer_complete();
    }
    BISS_EXPECT(a.axis.latest().output.quality == Quality::tripped) << days;
  }
}

// The transfer fills the buffer of the axis, and not the buffer of a copy.
static_assert(!std::is_copy_constructible_v<decltype(Axis::axis)>);
static_assert(!std::is_move_constructible_v<decltype(Axis::axis)>);

}  // namespace encoder_axis_test
}  // namespace control_loop
