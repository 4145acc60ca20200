// The readings of a master: line delay, sampling point, clocks.
#include "biss/master/request.hpp"
#include "biss/frame/format_text.hpp"
#include "tests/core/requests.hpp"
#include "tests/core/test.hpp"

namespace request_test {

using namespace biss;
using namespace biss::test::request;

using test::run;
using test::ScriptedSlo;
using test::Seen;

BISS_TEST(Request, DeviceWithoutDelay_IsReadWithJustItsClocks) {
  Master master(Codec{}, setup);
  ScriptedSlo device{.script = script_of(0x2ABCD)};
  const Seen seen = run(master, device, microseconds(7));
  const Reading& reading = master.reading();
  BISS_EXPECT_EQ(position_of(reading), 0x2ABCD);
  BISS_EXPECT(reading.frame->stop_seen);
  BISS_EXPECT(reading.refusal == Refusal::none);
  BISS_EXPECT(reading.begin == microseconds(7));
  BISS_EXPECT(reading.line_delay == Picoseconds{});
  BISS_EXPECT_EQ(reading.lead_clocks, 1);
  BISS_EXPECT_EQ(reading.ack_clocks, 5);
  BISS_EXPECT_EQ(reading.clocks, 4U + 5U + payload_bits);
  BISS_EXPECT(!reading.marginal);
  BISS_EXPECT(reading.ready);
  BISS_EXPECT_EQ(seen.rises, reading.clocks);
  BISS_EXPECT_EQ(seen.falls, reading.clocks);
  BISS_EXPECT(seen.shortest == period / 2);
  // The master is ready as soon as SLO is high again.
  BISS_EXPECT(seen.end == seen.last_rise + microseconds(20));
}

BISS_TEST(Request, AnyLineDelay_IsMeasuredAndMadeUpFor) {
  BISS_RANDOM(random, 0x3001);
  for (std::uint32_t i = 0; i < test::rounds(3'000, 30); ++i) {
    const auto delay = picoseconds(random.below(i % 2 == 0 ? 40'000'001 : 300'000));
    const Picoseconds clock = nanoseconds(i % 3 == 0 ? 4'000 : 100 + random.below(400));
    DeviceTiming slow = timing;
    slow.ack_max = clock * 6;
    Master master(Codec{}, {.period = clock, .timing = slow});
    const std::uint64_t position = random.bits(18);
    const unsigned ack = 4 + random.below(3);
    ScriptedSlo device{.script = script_of(position, ack), .delay = delay};
    run(master, device, microseconds(5));
    const Reading& reading = master.reading();
    BISS_ASSERT_EQ(position_of(reading), position) << "delay " << delay.count;
    BISS_ASSERT_EQ(reading.line_delay.value_or(never).count, delay.count);
    BISS_ASSERT(!reading.marginal && reading.ready);
    // The clock stops after STOP unless the complete rest of the frame is in transit.
    const std::int64_t under_way = (delay.count + clock.count) / clock.count;
    BISS_ASSERT(reading.clocks >= 4U + ack + payload_bits);
    BISS_ASSERT(under_way > payload_bits || reading.clocks == 4U + ack + payload_bits);
  }
}

BISS_TEST(Request, ChangesUpToAQuarterOfAPeriodLate_AreRead) {
  for (std::int64_t delay = 0; delay < 250; delay += 7) {
    Master master(Codec{}, setup);
    ScriptedSlo device{
        .script = script_of(0x15555), .delay = nanoseconds(delay), .jitter = period / 4};
    run(master, device, {});
    BISS_ASSERT_EQ(position_of(master.reading()), 0x15555) << "delay " << delay;
    BISS_ASSERT(!master.reading().marginal);
  }
}

BISS_TEST(Request, CoarsestSteps_NeverSampleWhereSloChanges) {
  for (std::int64_t delay = 0; delay < 200; ++delay) {
    Master master(Codec{}, {.period = period, .timing = timing, .sample_step = 2 * period});
    BISS_ASSERT(master.setup().sample_step == period / 4);
    ScriptedSlo device{.script = script_of(0x2AAAA), .delay = nanoseconds(delay)};
    run(master, device, {});
    BISS_ASSERT_EQ(position_of(master.reading()), 0x2AAAA) << "delay " << delay;
    BISS_ASSERT(!master.reading().marginal);
  }
}

BISS_TEST(Request, SamplingWhereSloChanges_IsMarginal) {
  for (const std::int64_t percent : {-50, -46, -45, -44, 44, 45, 46, 50}) {
    Master master(Codec{}, {.period = period,
                            .timing = timing,
                            .sample_step = picoseconds(1),
                            .sample_shift = period * percent / 100});
    ScriptedSlo device{.script = script_of(0x15555), .delay = nanoseconds(30)};
    run(master, device, {});
    const bool near = percent <= -45 || percent >= 45;
    BISS_EXPECT_EQ(master.reading().marginal, near) << "at " << percent;
  }
}

BISS_TEST(Request, WithoutCompensation_ShortDelayIsReadAndNearHalfAPeriodIsMarginal) {
  MasterSetup plain = setup;
  plain.compensate = false;
  for (std::int64_t delay = 0; delay < 1'000; ++delay) {
    Master master(Codec{}, plain);
    ScriptedSlo device{.script = script_of(0x2F0F3), .delay = nanoseconds(delay)};
    run(master, device, {});
    const Reading& reading = master.reading();
    // Far from the change of SLO, every bit is read, only later.
    const std::int64_t from_change = (delay + 50) % 100;
    const bool near = from_change <= 5 || from_change >= 95;
    BISS_ASSERT_EQ(reading.marginal, near) << "delay " << delay;
    BISS_ASSERT_EQ(position_of(reading), 0x2F0F3) << "delay " << delay;
    BISS_ASSERT_EQ(reading.lead_clocks, 1 + (delay + 50) / 100);
    BISS_ASSERT(reading.line_delay == nanoseconds(delay));
    BISS_ASSERT_EQ(reading.clocks, reading.lead_clocks + 3U + 5U + payload_bits);
  }
}

BISS_TEST(Request, ChangeAndSampleAtOnce_EitherMayBeToldFirst) {
  MasterSetup plain = setup;
  plain.compensate = false;
  Master change_first(Codec{}, plain);
  Master sample_first(Codec{}, plain);
  // With half a period of delay, changes of SLO coincide with samples. `run` reports both in one
  // call.
  ScriptedSlo device{.script = script_of(0x12345), .delay = period / 2};
  ScriptedSlo same = device;
  run(change_first, device, {});
  bool ma = true;
  bool slo = true;
  StepOutput out = sample_first.begin({}, true);
  Picoseconds now{};
  while (!sample_first.done()) {
    same.step(now, ma);
    out = sample_first.step(now, slo);
    slo = same.line.level(now);
    out = sample_first.step(now, slo);
    ma = out.level;
    same.step(now, ma);
    now = std::min(out.deadline, same.next());
  }
  BISS_EXPECT_EQ(position_of(change_first.reading()), position_of(sample_first.reading()));
  BISS_EXPECT_EQ(change_first.reading().clocks, sample_first.reading().clocks);
}

BISS_TEST(Request, ChainOfThree_MayTakeTwoClocksMore) {
  MasterSetup chain = setup;
  chain.slaves = 3;
  for (const unsigned ack : {5U, 6U, 8U, 9U}) {
    Master master(Codec{}, chain);
    ScriptedSlo device{.script = script_of(0x155, ack)};
    run(master, device, {});
    BISS_EXPECT_EQ(master.reading().frame.ok(), ack == 6 || ack == 8) << "ACK " << ack;
  }
}

BISS_TEST(Request, GlitchBeforeAck_IsNoAck) {
  for (std::int64_t at = 20; at < 480; at += 3) {
    Master master(Codec{}, setup);
    ScriptedSlo device{.script = script_of(0x2BEEF), .delay = nanoseconds(500)};
    device.line.put_at(nanoseconds(at), false);
    device.line.put_at(nanoseconds(at + 4), true);
    run(master, device, {});
    if (at < 150 && at + 4 >= 150) {
      BISS_EXPECT(cause_of(master.reading()) == FrameError::response_range);
      continue;
    }
    BISS_EXPECT_EQ(position_of(master.reading()), 0x2BEEF) << "at " << at;
    BISS_EXPECT(master.reading().line_delay == nanoseconds(500));
  }
}

BISS_TEST(Request, ExtraClocks_AreSent) {
  MasterSetup longer = setup;
  longer.extra_clocks = 9;
  Master master(Codec{}, longer);
  ScriptedSlo device{.script = script_of(3), .delay = nanoseconds(170)};
  run(master, device, {});
  BISS_EXPECT_EQ(position_of(master.reading()), 3);
  BISS_EXPECT_EQ(master.reading().clocks, 4U + 5U + payload_bits + 9U);
}

BISS_TEST(Request, LateCalls_ShortenNoClockAndLoseNoBit) {
  MasterSetup uneven = setup;
  uneven.low_time = nanoseconds(40);
  for (std::int64_t delay = 0; delay < 100; delay += 10) {
    Master master(Codec{}, uneven);
    ScriptedSlo device{.script = script_of(0x1B2D3), .delay = nanoseconds(delay)};
    const Seen seen = run(master, device, {}, false, nanoseconds(15));
    BISS_EXPECT_EQ(position_of(master.reading()), 0x1B2D3) << "delay " << delay;
    BISS_EXPECT(seen.shortest >= nanoseconds(40));
    BISS_EXPECT_EQ(seen.rises, 4U + 5U + payload_bits);
  }
}

BISS_TEST(Request, SamplingPoint_LiesOnTheGrid) {
  Master master(Codec{}, {.period = period, .timing = timing, .sample_step = nanoseconds(25)});
  master.begin({}, true);
  for (const std::int64_t edge : {50, 100, 150}) master.step(nanoseconds(edge), true);
  // 15 ns and half a period are 65, the nearest step is 75.
  master.step(nanoseconds(165), false);
  const StepOutput out = master.step(nanoseconds(200), false);
  BISS_EXPECT(!out.level);
  BISS_EXPECT(out.deadline == nanoseconds(225));
}

// ---- What does not fit

struct Refused {
  const char* format;
  MasterSetup setup;
  std::optional<SpiSetupError> error;
};
constexpr DeviceTiming at_5_mhz{.clock_max = megahertz(5)};
constexpr std::array<Refused, 10> refused{
    Refused{"pos18,nE,nW,crc6", setup, {}},
    Refused{"pos18,nE,nW,crc6", {.period = nanoseconds(25)}, SpiSetupError::clock},
    Refused{"pos18,nE,nW,crc6", {.period = period, .timing = at_5_mhz}, SpiSetupError::clock},
    Refused{"pos18,nE,nW,crc6", {.period = nanoseconds(200), .timing = at_5_mhz}, {}},
    Refused{"pos18,crc6", {.period = period, .unchecked = true}, SpiSetupError::error_flag},
    Refused{"pos18,crc6", {.period = period, .no_error_flag = true}, {}},
    Refused{"pos18,nE,nW", {.period = period, .no_error_flag = true}, SpiSetupError::crc},
    Refused{"pos18,nE,nW", {.period = period, .unchecked = true}, {}},
    Refused{"pad18", {.period = period, .unchecked = true}, {}},
    Refused{"pos18,nE,crc6+pos18,crc6", {.period = period}, SpiSetupError::error_flag}};

BISS_TEST(Request, SetupThatAnEncoderOrAFormatForbids_MakesNoRequestAndSaysWhy) {
  for (const Refused& one : refused) {
    const auto parsed = parse_format(one.format);
    BISS_ASSERT(parsed.ok());
    RequestCycle<FrameCodec<CrcBitwise, 2>> master(FrameCodec<CrcBitwise, 2>(*parsed), one.setup);
    BISS_EXPECT(master.error() == one.error) << one.format;
    const StepOutput out = master.begin(microseconds(1), true);
    BISS_EXPECT_EQ(master.done(), one.error.has_value()) << one.format;
    BISS_EXPECT_EQ(out.level, one.error.has_value()) << one.format;
    if (!one.error) continue;
    BISS_EXPECT(master.reading().refusal == Refusal::setup) << one.format;
    BISS_ASSERT(!master.reading().frame.ok());
    BISS_EXPECT(master.reading().frame.error().cause == FrameError::not_ready) << one.format;
    BISS_EXPECT(out.deadline == never && !master.reading().ready) << one.format;
  }
}

template <std::int64_t ns>
constexpr bool make() {
  const RequestCycle master(Codec{}, MasterSetup{.period = nanoseconds(ns), .timing = timing});
  return !master.error();
}
template <std::int64_t ns>
concept Compiles = requires {
  typename std::bool_constant<make<ns>()>;
};
static_assert(Compiles<100> && !Compiles<99>);

}  // namespace request_test
