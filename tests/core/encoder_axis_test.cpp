#include "biss/axis/encoder_axis.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <type_traits>

#include "biss/base/wrapping_time.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"
#include "tests/core/axis_campaign.hpp"
#include "tests/core/test.hpp"

namespace biss::encoder_axis_test {

constexpr CatalogueEntry encoder = catalogue_encoder("resolute-26");
constexpr Picoseconds ma_period = period_of(megahertz(10));
constexpr FrameCodec<CrcFast, 1> codec{encoder.frame_format()};
constexpr SpiSetup spi_setup{.period = ma_period, .line_delay = {.max = nanoseconds(700)}};
constexpr SpiReader<FrameCodec<CrcFast, 1>> reader{codec, spi_setup, encoder.timing};
constexpr AxisSetup setup{.cycle = microseconds(100),
                          .to_sampling = sampling_delay(spi_setup, encoder.timing),
                          .max_step = 1'000'000,
                          .bad_cycles = BadCycleRule::hold,
                          .trip_after = 3};
// Half a clock to the first rising edge, 3.25 us to the sampling moment.
constexpr Picoseconds to_sampling = nanoseconds(50 + 3'250);
static_assert(setup.to_sampling == to_sampling);

struct Spi : test::HeldSpi {
  // A good frame with these positions.
  template <std::size_t channels = 1, class Codec = FrameCodec<CrcFast, 1>>
  constexpr void answer(const std::array<std::uint64_t, channels>& positions,
                        const Codec& of = codec) {
    busy = false;
    BasicFrame<channels> frame;
    frame.channel_count = channels;
    frame.lead_clocks = 3;
    frame.ack_clocks = 40;
    for (std::size_t k = 0; k < channels; ++k) frame.channel_list[k].position = positions[k];
    const auto bits = encode_frame(frame, of);
    std::fill(receive.begin(), receive.end(), std::uint8_t{0});
    for (std::size_t i = 0; i < bits->size_bits(); ++i) {
      if (bits->view()[i]) receive[i / 8] |= static_cast<std::uint8_t>(0x80U >> (i % 8));
    }
  }
};

struct Bench {
  const AxisSetup& chosen = setup;
  Spi spi{};
  EncoderAxis<Spi, SpiReader<FrameCodec<CrcFast, 1>>, reader.bytes()> axis{spi, reader, chosen};

  constexpr void good(Picoseconds now, std::uint64_t position) {
    axis.request(now);
    spi.answer<1>({position});
    axis.transfer_complete();
  }
  // Two frames, the second one at this time.
  constexpr void start(Picoseconds now, std::uint64_t position) {
    good(now - setup.cycle, position);
    good(now, position);
  }
  std::uint32_t count(AxisCause cause) const { return axis.axis().counts()[cause]; }
};

BISS_TEST(EncoderAxis, AnswerOfALateTransfer_HasTheTimeOfItsOwnRequest) {
  Bench a;
  a.start(microseconds(100), 1000);
  a.axis.request(microseconds(200));
  a.axis.request(microseconds(300));  // refused
  BISS_EXPECT_EQ(a.axis.position().cause, AxisCause::late);
  a.spi.answer<1>({1100});
  a.axis.transfer_complete();
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::measured);
  BISS_EXPECT_EQ(a.axis.position().step, 100);
  BISS_EXPECT_EQ(a.axis.position().moment.count, (microseconds(200) + to_sampling).count);
}

BISS_TEST(EncoderAxis, RequestsThatAreNeverAnswered_Trip) {
  Bench a;
  a.start(microseconds(100), 1000);
  for (int i = 2; i <= 4; ++i) {
    a.axis.request(microseconds(100 * i));
    a.spi.busy = false;  // the interrupt was lost
    BISS_EXPECT_EQ(a.axis.position().bad_in_a_row, i - 2);
  }
  a.axis.request(microseconds(500));
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::tripped);
  BISS_EXPECT_EQ(a.axis.position().cause, AxisCause::unanswered);
  BISS_EXPECT_EQ(a.count(AxisCause::unanswered), 3U);
}

BISS_TEST(EncoderAxis, TransferThatFails_IsOneBadCycle) {
  Bench a;
  a.start(microseconds(100), 1000);
  a.axis.request(microseconds(200));
  a.spi.busy = false;
  a.axis.transfer_failed();
  BISS_EXPECT_EQ(a.axis.position().bad_in_a_row, 1);
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::held);
  BISS_EXPECT_EQ(a.axis.position().cause, AxisCause::failed);
  a.good(microseconds(300), 1100);
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::measured);
  BISS_EXPECT_EQ(a.axis.position().position, 1100);
}

BISS_TEST(EncoderAxis, TransferThatWritesNothing_IsNoResponse) {
  Bench a;
  a.start(microseconds(100), 1000);
  a.good(microseconds(200), 1100);
  for (int i = 1; i <= 2; ++i) {
    a.axis.request(microseconds(200 + 100 * i));
    a.spi.busy = false;
    a.axis.transfer_complete();
    BISS_EXPECT_EQ(a.axis.position().state, AxisState::held);
    BISS_EXPECT_EQ(a.axis.position().cause, AxisCause::no_response);
    BISS_EXPECT_EQ(a.axis.position().number, 3U);
  }
  a.good(microseconds(500), 1200);
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::measured);
  BISS_EXPECT_EQ(a.axis.position().number, 6U);
  BISS_EXPECT_EQ(a.count(AxisCause::no_response), 2U);
}

BISS_TEST(EncoderAxis, EndThatNothingWaitsFor_ChangesNothing) {
  Bench a;
  a.axis.transfer_complete();
  a.axis.transfer_failed();
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::no_position);
  BISS_EXPECT_EQ(a.axis.position().bad_in_a_row, 0);
  a.start(microseconds(100), 1000);
  for (int i = 0; i < 3; ++i) a.axis.transfer_complete();
  BISS_EXPECT_EQ(a.axis.position().number, 2U);
  a.axis.request(microseconds(200));
  a.spi.busy = false;
  a.axis.transfer_failed();
  a.axis.transfer_complete();  // both interrupts of one transfer
  BISS_EXPECT_EQ(a.axis.position().bad_in_a_row, 1);
  BISS_EXPECT_EQ(a.count(AxisCause::unexpected), 6U);
}

// A transfer that is given up ends later, while its successor is running.
BISS_TEST(EncoderAxis, EndOfAnEarlierTransfer_IsNoFrameOfTheNextOne) {
  Bench a;
  a.start(microseconds(100), 1000);
  a.axis.request(microseconds(200));
  const auto given_up = a.spi;
  a.spi.busy = false;
  a.axis.request(microseconds(300));
  const auto running = a.spi;
  a.spi = given_up;
  a.spi.answer<1>({1100});
  a.axis.transfer_complete();
  BISS_EXPECT_EQ(a.axis.position().cause, AxisCause::no_response);
  a.spi = running;
  a.spi.answer<1>({1200});
  a.axis.transfer_complete();
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::held);
  BISS_EXPECT_EQ(a.count(AxisCause::unanswered), 1U);
  BISS_EXPECT_EQ(a.count(AxisCause::unexpected), 1U);
}

// Refused requests are bad cycles like others while the encoder powers up.
BISS_TEST(EncoderAxis, LateRequestsWhileTheEncoderPowersUp_DoNotTrip) {
  Bench a;
  a.axis.request(microseconds(100));
  for (int i = 2; i < 12; ++i) a.axis.request(microseconds(100 * i));
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::no_position);
  BISS_EXPECT_EQ(a.count(AxisCause::late), 10U);
}

BISS_TEST(EncoderAxis, EncoderThatNeverAnswers_TripsWhenItsTimeToPowerUpIsOver) {
  for (const bool wraps : {false, true}) {
    Bench a;
    const Picoseconds begin{wraps ? std::numeric_limits<std::int64_t>::max() - 1 : 0};
    std::int64_t tripped_at = 0;
    for (std::int64_t ms = 0; ms < 1200 && tripped_at == 0; ++ms) {
      a.axis.request(wrapping_later(begin, milliseconds(ms)));
      a.spi.busy = false;
      a.axis.transfer_complete();
      if (a.axis.position().state == AxisState::tripped) tripped_at = ms;
    }
    BISS_EXPECT_EQ(tripped_at, 1000);
  }
}

BISS_TEST(EncoderAxis, Reset_StartsAgainWithPowerUpAndTurns) {
  Bench a;
  a.start(milliseconds(100), 1000);
  a.good(milliseconds(100) + setup.cycle, (1U << 26U) - 1000);  // turn -1
  BISS_EXPECT_EQ(a.axis.position().position, -1000);
  for (int i = 0; i < 3; ++i) {
    a.axis.request(milliseconds(102 + i));
    a.spi.busy = false;
    a.axis.transfer_complete();
  }
  a.good(milliseconds(5'000), 2000);
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::tripped);
  a.axis.request(milliseconds(5'001));
  a.axis.reset();
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::no_position);
  BISS_EXPECT_EQ(a.axis.position().number, 0U);
  BISS_EXPECT(!a.axis.line_delay_seen());
  a.spi.answer<1>({7000});
  a.axis.transfer_complete();  // of the request before
  BISS_EXPECT_EQ(a.count(AxisCause::unexpected), 1U);
  BISS_EXPECT_EQ(a.count(AxisCause::unanswered), 1U);
  for (int i = 0; i < 900; ++i) {  // the plug is in again, the encoder powers up
    a.axis.request(milliseconds(6'000 + i));
    a.spi.busy = false;
    a.axis.transfer_complete();
  }
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::no_position);
  a.start(milliseconds(6'900), (1U << 26U) - 1000);
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::measured);
  BISS_EXPECT_EQ(a.axis.position().position, (1 << 26) - 1000);
}

BISS_TEST(EncoderAxis, LineDelay_IsThatOfAllGoodFrames) {
  Bench a;
  BISS_EXPECT(!a.axis.line_delay_seen());
  a.start(microseconds(100), 1000);
  BISS_ASSERT(a.axis.line_delay_seen());
  BISS_EXPECT_EQ(a.axis.line_delay_seen()->first, 1);
  BISS_EXPECT_EQ(a.axis.line_delay_seen()->second, 1);
}

// ---- A chain

BISS_TEST(EncoderAxis, Chain_HasAnAxisForEachChannel) {
  constexpr FrameFormat two = frame_format("pos26,nE,nW,crc6+pos12,nE,nW,crc6");
  static constexpr FrameCodec<CrcFast, 2> of_two{two};
  static constexpr SpiReader two_reader{of_two, spi_setup, encoder.timing};
  static constexpr AxisSetup reversed{.cycle = setup.cycle,
                                      .to_sampling = setup.to_sampling,
                                      .max_step = 100,
                                      .bad_cycles = BadCycleRule::extrapolate,
                                      .reversed = true};
  Spi spi;
  EncoderAxis<Spi, std::remove_cvref_t<decltype(two_reader)>, two_reader.bytes(), 2> chain(
      spi, two_reader, {&setup, &reversed});
  BISS_ASSERT(!chain.error());
  for (int i = 1; i < 4; ++i) {
    chain.request(setup.cycle * std::int64_t{i});
    const auto step = static_cast<std::uint64_t>(10 * i);
    spi.answer<2>({1000 + step, i == 3 ? 3000 : 2000 + step}, of_two);
    chain.transfer_complete();
  }
  BISS_EXPECT_EQ(chain.position(0).position, 1030);
  BISS_EXPECT_EQ(chain.position(0).state, AxisState::measured);
  BISS_EXPECT_EQ(chain.position(1).position, -2030);
  BISS_EXPECT_EQ(chain.position(1).state, AxisState::extrapolated);
  BISS_EXPECT_EQ(chain.position(1).cause, AxisCause::step);
}

// ---- Parts that do not fit

// The reader of another encoder, chosen at run time: its bytes do not fit the buffer.
BISS_TEST(EncoderAxis, ReaderThatNeedsMoreThanTheBuffer_IsRefusedAndWritesNothing) {
  Spi spi;
  struct Memory {
    EncoderAxis<Spi, std::remove_cvref_t<decltype(reader)>, 8> axis;
    std::array<std::uint8_t, 64> after{};
  };
  Memory memory{EncoderAxis<Spi, std::remove_cvref_t<decltype(reader)>, 8>(spi, reader, setup)};
  BISS_ASSERT(memory.axis.error());
  BISS_EXPECT(*memory.axis.error() == AxisError::buffer);
  for (int i = 0; i < 5; ++i) {
    memory.axis.request(microseconds(100 * i));
    BISS_EXPECT(spi.receive.empty());
    memory.axis.transfer_complete();
  }
  BISS_EXPECT_EQ(memory.axis.position().state, AxisState::tripped);
  memory.axis.reset();
  BISS_EXPECT_EQ(memory.axis.position().state, AxisState::tripped);
  for (const std::uint8_t byte : memory.after) BISS_EXPECT_EQ(byte, 0);
}

// A constant axis that does not fit does not compile.
template <std::int64_t max_step>
constexpr AxisSetup chosen = [] {
  AxisSetup other = setup;
  other.max_step = max_step;
  return other;
}();
template <std::size_t bytes, std::int64_t max_step>
constexpr bool make() {
  Spi spi;
  const EncoderAxis<Spi, std::remove_cvref_t<decltype(reader)>, bytes> axis(spi, reader,
                                                                            chosen<max_step>);
  return !axis.error();
}
template <std::size_t bytes, std::int64_t max_step>
concept Compiles = requires {
  typename std::bool_constant<make<bytes, max_step>()>;
};
static_assert(Compiles<reader.bytes(), 1> && !Compiles<reader.bytes() - 1, 1>);
static_assert(!Compiles<reader.bytes(), 0>);

BISS_TEST(EncoderAxis, ReaderFormatOrSetupThatDoesNotFit_HasItsCause) {
  Spi spi;
  const auto error = [&spi](const FrameFormat& format, std::int64_t max_step) {
    using Reader = SpiReader<FrameCodec<CrcFast, 1>>;
    const Reader other(FrameCodec<CrcFast, 1>(format), {.period = ma_period}, encoder.timing);
    AxisSetup changed = setup;
    changed.max_step = max_step;
    const EncoderAxis<Spi, Reader, 128> axis(spi, other, changed);
    return axis.error();
  };
  BISS_EXPECT(!error(encoder.frame_format(), 1));
  BISS_EXPECT(error(encoder.frame_format(), 0) == AxisError::max_step);
  BISS_EXPECT(error(*parse_format("pos26,crc6"), 1) == AxisError::reader);
  BISS_EXPECT(error(*parse_format("pos26,nE,nW"), 1) == AxisError::reader);
  BISS_EXPECT(error(*parse_format("pad8,nE,nW,crc6"), 1) == AxisError::format);
}

// The age of a position one period after its request; the clock wraps around in between.
constexpr Picoseconds age_across_the_wrap(Picoseconds before) {
  constexpr Picoseconds period = microseconds(100);
  const Picoseconds now = Picoseconds{std::numeric_limits<std::int64_t>::max()} - before;
  Bench a;
  a.start(now, 1000);
  return a.axis.position().age(wrapping_later(now, period));
}
static_assert(age_across_the_wrap(microseconds(1)) == microseconds(100) - to_sampling);
static_assert(age_across_the_wrap(microseconds(50)) == microseconds(100) - to_sampling);

BISS_TEST(EncoderAxis, ClockThatWrapsAround_ChangesNoAge) {
  for (std::int64_t before = 0; before < 100; ++before) {
    BISS_EXPECT_EQ(age_across_the_wrap(microseconds(before)).count,
                   (microseconds(100) - to_sampling).count);
  }
}

// The transfer fills the buffer of the axis, and not the buffer of a copy.
static_assert(!std::is_copy_constructible_v<decltype(Bench::axis)>);
static_assert(!std::is_move_constructible_v<decltype(Bench::axis)>);
// A setup that is gone after the statement.
static_assert(!std::is_constructible_v<decltype(Bench::axis), Spi&, decltype(reader)&, AxisSetup>);

// ---- Faults of the line and of the DMA

// 1000 cycles each.
#ifdef BISS_AXES
constexpr std::uint64_t axes = BISS_AXES;
#else
constexpr std::uint64_t axes = test::rounds(400, 100);
#endif

BISS_TEST(EncoderAxis, CampaignOfFaults_HasNoPositionOutsideOfItsUncertainty) {
  constexpr std::uint64_t seed = 0xB155'D3A1;
  BISS_RANDOM(random, seed);
  std::array<std::uint32_t, axis_cause_count> seen{};
  std::array<std::uint32_t, axis_state_names.size()> states{};
  for (std::uint64_t k = 0; k < axes; ++k) {
    test::AxisCampaign campaign(random.next());
    BISS_EXPECT(campaign.run(1000)) << campaign.problem() << ", axis " << k << ", fault "
                                    << static_cast<int>(campaign.last_fault());
    for (std::size_t i = 0; i < seen.size(); ++i) seen[i] += campaign.seen[i];
    for (std::size_t i = 0; i < states.size(); ++i) states[i] += campaign.states[i];
  }
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto cause = static_cast<AxisCause>(i);
    const bool never = cause == AxisCause::truncated || cause == AxisCause::cds;
    BISS_EXPECT(never || seen[i] > 5) << name_of(cause).data() << " " << seen[i];
  }
  for (std::size_t i = 0; i < states.size(); ++i) BISS_EXPECT(states[i] > 100) << i;
}

}  // namespace biss::encoder_axis_test
