#include "firmware/safe_axis/safe_axis.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/frame/encode.hpp"
#include "biss/safety/configurations.hpp"
#include "tests/core/test.hpp"

namespace safe_axis {
namespace safe_axis_test {

using biss::SafetySetup;
using enum biss::SafetyVerdict;

constexpr auto type = biss::safety_configuration("fs-36-28");
constexpr biss::Picoseconds cycle = biss::nanoseconds(31'250);
constexpr biss::Picoseconds bit_period = biss::nanoseconds(100);
constexpr std::size_t buffer_bytes = 32;
constexpr biss::Picoseconds transfer_time = bit_period * (8 * buffer_bytes);

constexpr SafetySetup with_first_value() {
  SafetySetup setup = type.setup;
  setup.counter.first = 1;
  return setup;
}
constexpr SafetySetup with_tolerated_faults() {
  SafetySetup setup = type.setup;
  setup.frame_gap_max = cycle * 4;
  setup.budget = {.faults = 2, .window = biss::milliseconds(10)};
  return setup;
}
constexpr SafetySetup with_timed_transfers() {
  SafetySetup setup = type.setup;
  setup.clocks.bit_period = bit_period;
  return setup;
}

struct Spi {
  std::span<std::uint8_t> receive{};
  bool start(std::span<std::uint8_t> into) {
    if (!receive.empty()) return false;
    receive = into;
    return true;
  }
};

template <SafetySetup setup = type.setup>
struct Bench {
  using Plan = biss::FixedSafetyPlan<type.frame_format(), setup>;

  Spi spi;
  SafeAxis<Spi, biss::SafetyMonitor<Plan>, buffer_bytes> axis{spi};
  biss::Picoseconds now{};
  std::uint32_t counter = 0;  // of the last answer
  bool powered = axis.power_up();

  biss::TwoClocks clocks() const { return {now, now + biss::milliseconds(5)}; }

  void request() {
    now += cycle;
    axis.request(clocks());
  }
  // The DMA's part: a good frame with this position of the SPW, and the end of the transfer.
  void answer(std::uint64_t position, biss::Picoseconds time = transfer_time) {
    counter = counter % 63 + 1;
    typename Plan::Frame frame;
    frame.channel_count = 2;
    frame.lead_clocks = 3;
    frame.ack_clocks = 40;
    frame.channel_list[0] = {position << 8U, 0, true, true};
    frame.channel_list[1] = {position, counter, true, true};
    const auto bits = biss::encode_frame(frame, Plan::codec()).value();
    std::fill(spi.receive.begin(), spi.receive.end(), std::uint8_t{0});
    std::copy_n(bits.bytes().begin(), bits.bytes().size(), spi.receive.begin());
    spi.receive = {};
    axis.transfer_complete(time);
  }
  bool good(std::uint64_t position = 1000) {
    request();
    answer(position);
    return has_position();
  }
  bool has_position() { return axis.position(clocks()).has_value(); }
  void until_safe() {
    for (int i = 0; i < 3; ++i) good();
    BISS_EXPECT(has_position());
  }
};

BISS_TEST(SafeAxis, PositionWithinAStimulus_IsSafeAndOutsideIsAFaultThatHolds) {
  Bench b;
  b.until_safe();
  b.axis.expect_position(990, 1010);
  BISS_EXPECT(b.good(1000));
  BISS_EXPECT(b.good(2000));
  b.axis.expect_position(2100, 2200);
  BISS_EXPECT(!b.good(2000));
  BISS_EXPECT_EQ(b.axis.cause(), stimulus);
  BISS_EXPECT(!b.good(2150));
  BISS_EXPECT_EQ(b.axis.cause(), stimulus);
  b.axis.encoder_restarted();
  BISS_EXPECT_EQ(b.axis.cause(), stimulus);
  BISS_EXPECT(b.axis.acknowledge(stimulus));
  b.until_safe();
}

BISS_TEST(SafeAxis, StimulusDuringATransfer_IsThatOfTheNextRequest) {
  Bench b;
  b.until_safe();
  b.request();
  b.axis.expect_position(2000, 2100);
  b.answer(1000);
  BISS_EXPECT(b.has_position());
  BISS_EXPECT(!b.good(1000));
  BISS_EXPECT_EQ(b.axis.cause(), stimulus);
}

BISS_TEST(SafeAxis, StimulusBeforeARequestThatIsRefused_IsThatOfTheNextOne) {
  Bench b;
  b.until_safe();
  b.request();
  b.axis.expect_position(2000, 2100);
  b.axis.request(b.clocks());  // refused: the transfer has not ended
  BISS_EXPECT(b.axis.acknowledge(b.axis.cause()));
  b.answer(1000);
  b.good(1000);
  BISS_EXPECT_EQ(b.axis.cause(), stimulus);
}

BISS_TEST(SafeAxis, RestartOfTheEncoder_HasNoPositionUntilTheMonitorIsSafeAgain) {
  Bench b;
  b.until_safe();
  b.axis.encoder_restarted();
  BISS_EXPECT(!b.has_position());
  BISS_EXPECT_EQ(b.axis.cause(), starting);
  b.counter = 40;
  b.now += biss::milliseconds(1000);
  BISS_EXPECT(!b.good());
  BISS_EXPECT(!b.good());
  BISS_EXPECT(b.good());
}

BISS_TEST(SafeAxis, AnswerFromBeforeTheRestart_IsNotJudged) {
  Bench<with_first_value()> b;
  b.until_safe();
  b.request();
  b.axis.encoder_restarted();
  b.answer(1000);
  BISS_EXPECT(!b.has_position());
  b.counter = 0;
  b.until_safe();
}

// The end of the transfer of one request is never reported.
BISS_TEST(SafeAxis, RequestWithoutAnswer_HasNoPositionUntilTheNextAnswer) {
  Bench<with_tolerated_faults()> b;
  b.until_safe();
  b.request();
  b.spi.receive = {};
  b.request();
  BISS_EXPECT(!b.has_position());
  BISS_EXPECT_EQ(b.axis.cause(), no_frame);
  b.counter += 1;
  b.answer(1000);
  BISS_EXPECT(b.has_position());
}

BISS_TEST(SafeAxis, InterruptBeforeTheFirstRequest_IsNotTheFirstAnswer) {
  Bench<with_first_value()> b;
  b.axis.transfer_complete();
  b.until_safe();
}

BISS_TEST(SafeAxis, WrongFirstAnswer_IsLeftByARestartOfTheEncoder) {
  Bench<with_first_value()> b;
  b.counter = 7;
  for (int i = 0; i < 5; ++i) BISS_EXPECT(!b.good());
  BISS_EXPECT_EQ(b.axis.cause(), counter_first);
  b.axis.encoder_restarted();
  BISS_EXPECT_EQ(b.axis.cause(), starting);
  b.counter = 0;
  b.until_safe();
}

BISS_TEST(SafeAxis, FaultThatHolds_IsNotClearedByARestartOfTheEncoder) {
  Bench b;
  b.until_safe();
  b.counter += 20;
  b.good();
  BISS_EXPECT_EQ(b.axis.cause(), counter_foreign);
  b.axis.encoder_restarted();
  BISS_EXPECT_EQ(b.axis.cause(), counter_foreign);
  for (int i = 0; i < 5; ++i) BISS_EXPECT(!b.good());
  BISS_EXPECT(b.axis.acknowledge(counter_foreign));
  b.until_safe();
}

BISS_TEST(SafeAxis, BeforeTheSelfTest_ARestartOfTheEncoderIsNoStart) {
  Spi spi;
  SafeAxis<Spi, biss::SafetyMonitor<Bench<>::Plan>, buffer_bytes> axis{spi};
  axis.encoder_restarted();
  BISS_EXPECT_EQ(axis.cause(), self_test);
}

BISS_TEST(SafeAxis, TransferOfTheRightTime_IsSafe) {
  Bench<with_timed_transfers()> b;
  for (int i = 1; i <= 100; ++i) BISS_EXPECT_EQ(b.good(), i >= 3) << i;
}

BISS_TEST(SafeAxis, TransferOfAWrongOrNoTime_IsAClockFault) {
  for (const biss::Picoseconds time :
       {transfer_time * 2, transfer_time / 2, biss::Picoseconds{}, -transfer_time}) {
    Bench<with_timed_transfers()> b;
    b.until_safe();
    b.request();
    b.answer(1000, time);
    BISS_EXPECT(!b.has_position());
    BISS_EXPECT_EQ(b.axis.cause(), clock);
  }
}

BISS_TEST(SafeAxis, WithoutTimedTransfers_TheTimeOfATransferIsIgnored) {
  Bench b;
  b.until_safe();
  b.request();
  b.answer(1000, {});
  BISS_EXPECT(b.has_position());
}

}  // namespace safe_axis_test
}  // namespace safe_axis
