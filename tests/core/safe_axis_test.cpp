#include "biss/axis/safe_axis.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "biss/frame/encode.hpp"
#include "biss/safety/configurations.hpp"
#include "tests/core/test.hpp"

namespace biss::safe_axis_test {

using enum SafetyVerdict;

constexpr auto type = safety_configuration("fs-36-28");
constexpr Picoseconds cycle = nanoseconds(31'250);
constexpr Picoseconds bit_period = nanoseconds(100);
constexpr std::size_t buffer_bytes = 32;
constexpr Picoseconds transfer_time = bit_period * (8 * buffer_bytes);

constexpr SafetySetup with_first_value() {
  SafetySetup setup = type.setup;
  setup.counter.first = 1;
  return setup;
}
constexpr SafetySetup with_tolerated_faults() {
  SafetySetup setup = type.setup;
  setup.frame_gap_max = cycle * 4;
  setup.budget = {.faults = 2, .window = milliseconds(10)};
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
  using Plan = FixedSafetyPlan<type.frame_format(), setup>;

  using Axis = SafeAxis<Spi, SafetyMonitor<Plan>, buffer_bytes>;

  Spi spi;
  Axis axis{spi};
  Picoseconds now{};
  std::uint32_t counter = 0;  // of the last answer
  std::uint16_t lead_clocks = 3;
  std::uint16_t ack_clocks = 40;
  bool powered = axis.power_up();

  TwoClocks clocks() const { return {now, now + milliseconds(5)}; }

  void request() {
    now += cycle;
    axis.request(clocks());
  }
  // The next frame of an encoder without faults.
  FrameBits next(std::uint64_t cpw_position, bool nE = true) {
    counter = counter % 63 + 1;
    typename Plan::Frame frame;
    frame.channel_count = 2;
    frame.lead_clocks = lead_clocks;
    frame.ack_clocks = ack_clocks;
    frame.channel_list[0] = {cpw_position, 0, nE, true};
    frame.channel_list[1] = {cpw_position >> 8U, counter, true, true};
    return encode_frame(frame, Plan::codec()).value();
  }
  // The DMA's part.
  void write(const FrameBits& bits) {
    std::fill(spi.receive.begin(), spi.receive.end(), std::uint8_t{0});
    std::copy_n(bits.bytes().begin(), std::min(bits.bytes().size(), spi.receive.size()),
                spi.receive.begin());
  }
  void end(Picoseconds time = transfer_time) {
    spi.receive = {};
    axis.transfer_complete(time);
  }
  // A good frame with this position of the SPW, and the end of the transfer.
  void answer(std::uint64_t position, Picoseconds time = transfer_time) {
    write(next(position << 8U));
    end(time);
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
  b.now += milliseconds(1000);
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

// The frame of the request before is not judged twice.
BISS_TEST(SafeAxis, RequestThatIsRefused_IsOneLostAnswer) {
  Bench<with_tolerated_faults()> b;
  b.until_safe();
  b.request();
  b.request();  // refused: the SPI is busy
  BISS_EXPECT_EQ(b.axis.cause(), no_frame);
  b.answer(1000);  // of the first request
  BISS_EXPECT(!b.has_position());
  b.good();
  BISS_EXPECT(b.good());
  BISS_EXPECT_EQ(b.axis.counts()[no_frame], 1U);
}

BISS_TEST(SafeAxis, TransferThatFails_HasNoPositionUntilTheNextAnswer) {
  Bench<with_tolerated_faults()> b;
  b.until_safe();
  b.request();
  b.write(b.next(1000));
  b.spi.receive = {};
  b.axis.transfer_failed();
  BISS_EXPECT(!b.has_position());
  BISS_EXPECT_EQ(b.axis.cause(), no_frame);
  BISS_EXPECT_EQ(b.axis.counts()[no_frame], 1U);
  b.axis.transfer_failed();  // no request waits for it
  b.axis.transfer_complete();
  BISS_EXPECT_EQ(b.axis.counts()[no_frame], 1U);
  BISS_EXPECT(b.good());
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

// Constant-initialised, like everything that lives before firmware_main().
constinit Spi untested_spi;
constinit Bench<>::Axis untested_axis{untested_spi};

BISS_TEST(SafeAxis, BeforeTheSelfTest_ARestartOfTheEncoderIsNoStart) {
  untested_axis.encoder_restarted();
  BISS_EXPECT_EQ(untested_axis.cause(), self_test);
}

BISS_TEST(SafeAxis, BeforeTheSelfTest_AGoodAnswerIsNoPosition) {
  Bench b;
  untested_axis.request(b.clocks());
  std::swap(untested_spi, b.spi);
  b.write(b.next(1000));
  untested_spi = {};
  untested_axis.transfer_complete(transfer_time);
  BISS_EXPECT(!untested_axis.position(b.clocks()).has_value());
  BISS_EXPECT_EQ(untested_axis.cause(), self_test);
}

BISS_TEST(SafeAxis, EndThatNoRequestWaitsFor_LeavesThePosition) {
  Bench b;
  b.until_safe();
  b.request();
  b.answer(1234);
  b.axis.transfer_complete(transfer_time);
  const auto position = b.axis.position(b.clocks());
  BISS_ASSERT(position.has_value());
  BISS_EXPECT_EQ(control_position(Bench<>::Plan(), *position), 1234U << 8U);
}

BISS_TEST(SafeAxis, TransferOfTheRightTime_IsSafe) {
  Bench<with_timed_transfers()> b;
  for (int i = 1; i <= 100; ++i) BISS_EXPECT_EQ(b.good(), i >= 3) << i;
}

BISS_TEST(SafeAxis, TransferOfAWrongOrNoTime_IsAClockFault) {
  for (const Picoseconds time :
       {transfer_time * 2, transfer_time / 2, Picoseconds{}, -transfer_time}) {
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

enum class Fault : std::uint8_t {
  flip,
  no_dma,
  no_interrupt,
  silent,
  error_bit,
  asked_twice,
  clock_jumps
};
constexpr std::array causes{cpw_crc, no_frame, watchdog, watchdog, cpw_error, no_frame, clock};

BISS_TEST(SafeAxis, CyclesWithFaults_HaveEachPositionAndNoneFromAFaultToItsAcknowledgement) {
  BISS_RANDOM(random, 0x5AFE'0001);
  Bench b;
  std::uint64_t position = 0;
  std::uint32_t good_in_a_row = 0;
  for (std::uint32_t n = 0; n < 3000; ++n) {
    const bool faulty = n % 50 == 49;
    const auto fault = static_cast<Fault>(n / 50 % causes.size());
    const auto is = [&](Fault one) { return faulty && fault == one; };
    b.now = cycle * n;
    auto asked = b.clocks();
    if (is(Fault::clock_jumps)) asked.now += microseconds(2);
    b.axis.request(asked);
    const auto request_again = [&](Picoseconds later) {
      b.now += later;
      b.axis.request(b.clocks());
      b.now -= later;
    };
    // Before the watchdog reacts: the request that the board refuses is reported.
    if (is(Fault::asked_twice)) request_again(cycle / 4);
    position = (position + 123'456'789) & low_mask(36);
    b.lead_clocks = static_cast<std::uint16_t>(2U + random.below(5));
    b.ack_clocks = static_cast<std::uint16_t>(33U + random.below(60));
    FrameBits bits = b.next(position, !is(Fault::error_bit));
    const std::size_t cds = bits.size_bits() - 2U - Bench<>::Plan::payload_bits();
    if (is(Fault::flip)) bits.flip(cds + 1U + random.below(38));
    if (!is(Fault::no_dma)) b.write(bits);
    if (!is(Fault::no_interrupt) && !is(Fault::silent)) b.end();
    // The next request is refused, too: the SPI is still busy.
    if (is(Fault::no_interrupt)) request_again(cycle - microseconds(1));
    b.now += is(Fault::silent) ? 2 * cycle : cycle;
    const auto found = b.axis.position(b.clocks());
    good_in_a_row = faulty ? 0 : good_in_a_row + 1;
    BISS_EXPECT_EQ(found.has_value(), good_in_a_row >= type.setup.start_frames) << n;
    if (found) {
      BISS_EXPECT_EQ(control_position(Bench<>::Plan(), *found), position) << n;
    }
    if (!faulty) continue;
    BISS_EXPECT_EQ(b.axis.cause(), causes[static_cast<std::size_t>(fault)]) << n;
    b.spi.receive = {};
    BISS_EXPECT(b.axis.acknowledge(b.axis.cause())) << n;
    BISS_EXPECT_EQ(b.axis.cause(), starting) << n;
  }
}

}  // namespace biss::safe_axis_test
