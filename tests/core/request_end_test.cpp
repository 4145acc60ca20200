// The end of failed requests, and the earliest time of the next one.
#include "biss/master/request.hpp"
#include "tests/core/requests.hpp"
#include "tests/core/test.hpp"

namespace request_end_test {

using namespace biss;
using namespace biss::test::request;

using test::run;
using test::ScriptedSlo;
using test::Seen;

BISS_TEST(RequestEnd, NoAnswer_EndsWithMaHighForTheResetTime) {
  for (const bool compensate : {true, false}) {
    MasterSetup lonely = setup;
    lonely.compensate = compensate;
    lonely.line_delay_max = microseconds(4);
    lonely.cdm = true;
    Master master(Codec{}, lonely);
    test::LineBits ones;
    ones.append_run(true, 500);
    ScriptedSlo device{.script = ones};
    const Seen seen = run(master, device, {}, true);
    BISS_EXPECT(cause_of(master.reading()) == FrameError::no_response);
    BISS_EXPECT(!master.reading().line_delay);
    BISS_EXPECT(seen.last_rise >= microseconds(4) && seen.last_rise <= microseconds(5));
    BISS_EXPECT(seen.end >= seen.last_rise + microseconds(20));
    BISS_EXPECT(seen.end <= seen.last_rise + microseconds(21));
    BISS_EXPECT(seen.shortest == period / 2);
    BISS_EXPECT(seen.last_edge == seen.last_rise);
    BISS_EXPECT(master.reading().ready);
  }
}

BISS_TEST(RequestEnd, AckLongerThanTheDeviceAllows_EndsWithMaHighForTheResetTime) {
  Master master(Codec{}, setup);
  ScriptedSlo device{.script = low_from_ack()};
  const Seen seen = run(master, device, {});
  BISS_EXPECT(cause_of(master.reading()) == FrameError::no_start);
  BISS_EXPECT_EQ(master.reading().ack_clocks, 6);
  BISS_EXPECT_EQ(seen.rises, 9U);
  BISS_EXPECT(seen.end >= seen.last_rise + microseconds(20));
  BISS_EXPECT(master.reading().ready);
  // The next request is read.
  device.script = script_of(77, 6);
  run(master, device, master.earliest());
  BISS_EXPECT_EQ(position_of(master.reading()), 77);
}

BISS_TEST(RequestEnd, ResetTime_IsTheRestOfTheFullCycleOrAsAsked) {
  const auto rest_after = [](Timeout timeout, Picoseconds reset) {
    MasterSetup other = setup;
    other.timing.timeout = timeout;
    other.reset_time = reset;
    Master master(Codec{}, other);
    ScriptedSlo device{.script = low_from_ack()};
    const Seen seen = run(master, device, {});
    return seen.end - seen.last_rise - period;
  };
  // The full cycle has 37 clocks, ACK at its longest; the request stopped after 8.5 of them.
  BISS_EXPECT(rest_after({TimeoutRule::fixed, microseconds(13)}, {}) == nanoseconds(15'850));
  BISS_EXPECT(rest_after({TimeoutRule::adaptive, {}}, {}) == microseconds(40));
  BISS_EXPECT(rest_after({TimeoutRule::adaptive, microseconds(50)}, {}) == nanoseconds(53'050));
  BISS_EXPECT(rest_after({TimeoutRule::cycle, nanoseconds(31'250)}, {}) == nanoseconds(30'400));
  BISS_EXPECT(rest_after({TimeoutRule::cycle, nanoseconds(100)}, {}) == microseconds(3));
  BISS_EXPECT(rest_after({}, microseconds(3)) == microseconds(3));
}

BISS_TEST(RequestEnd, StartBeforeTheDeviceCanAnswer_IsAckRange) {
  Master master(Codec{}, setup);
  ScriptedSlo device{.script = script_of(0x155, 3)};
  run(master, device, {});
  BISS_EXPECT(cause_of(master.reading()) == FrameError::ack_range);
  BISS_EXPECT_EQ(master.reading().clocks, 4U + 3U + payload_bits);
}

BISS_TEST(RequestEnd, SloLowAtTheBeginning_IsRefusedAndMaStaysHigh) {
  Master master(Codec{}, setup);
  const StepOutput out = master.begin(microseconds(1), false);
  BISS_EXPECT(out == StepOutput{});
  BISS_EXPECT(master.done());
  BISS_EXPECT(master.reading().refusal == Refusal::slo_low);
  BISS_EXPECT(cause_of(master.reading()) == FrameError::not_ready);
  BISS_EXPECT(!master.reading().ready);
  BISS_EXPECT(master.begin(microseconds(2), true).level == false);
}

BISS_TEST(RequestEnd, BeforeTheShortestCycle_IsRefusedWithTheTimeItMayCome) {
  Master master(Codec{}, setup);
  ScriptedSlo device{.script = script_of(1), .timeout = nanoseconds(12'500)};
  const Seen seen = run(master, device, microseconds(3));
  BISS_EXPECT(seen.end < microseconds(28));
  BISS_EXPECT(master.reading().ready);
  BISS_EXPECT(master.earliest() == microseconds(28));
  const StepOutput early = master.begin(microseconds(28) - picoseconds(1), true);
  BISS_EXPECT(early.level && early.deadline == microseconds(28));
  BISS_EXPECT(master.done());
  BISS_EXPECT(master.reading().refusal == Refusal::too_early);
  BISS_EXPECT(cause_of(master.reading()) == FrameError::not_ready);
  BISS_EXPECT(!master.begin(early.deadline, true).level);
}

BISS_TEST(RequestEnd, SloLowBeforeAckCanCome_IsResponseRange) {
  for (const bool compensate : {true, false}) {
    MasterSetup either = setup;
    either.compensate = compensate;
    Master master(Codec{}, either);
    ScriptedSlo device{.script = test::line_of("0")};
    const Seen seen = run(master, device, {});
    BISS_EXPECT(cause_of(master.reading()) == FrameError::response_range);
    BISS_EXPECT_EQ(seen.rises, 2U);
    BISS_EXPECT(seen.end >= seen.last_rise + microseconds(20));
  }
}

BISS_TEST(RequestEnd, LineDelayOfTheLongest_IsReadAndOneMoreIsNot) {
  MasterSetup close = setup;
  close.line_delay_max = nanoseconds(730);
  for (const std::int64_t delay : {730'000, 730'001}) {
    Master master(Codec{}, close);
    ScriptedSlo device{.script = script_of(0x3A5A5), .delay = picoseconds(delay)};
    run(master, device, {});
    if (delay == 730'000) {
      BISS_EXPECT_EQ(position_of(master.reading()), 0x3A5A5);
    } else {
      BISS_EXPECT(cause_of(master.reading()) == FrameError::response_range);
    }
  }
}

BISS_TEST(RequestEnd, SloThatStaysLow_EndsWithTheFrameAndRefusesTheNext) {
  for (const bool cdm : {false, true}) {
    Master master(Codec{}, setup);
    ScriptedSlo device{.script = script_of(0x2222), .timeout = milliseconds(1)};
    const Seen seen = run(master, device, {}, cdm);
    BISS_EXPECT_EQ(position_of(master.reading()), 0x2222);
    BISS_EXPECT(!master.reading().ready);
    BISS_EXPECT(seen.end <= microseconds(50));
    BISS_EXPECT(master.begin(microseconds(60), false) == StepOutput{});
    BISS_EXPECT(master.reading().refusal == Refusal::slo_low);
  }
}

BISS_TEST(RequestEnd, Cdm_IsMasLevelUntilSloRises) {
  MasterSetup quick = setup;
  quick.timing.cycle_min = {};
  for (const bool cdm : {false, true}) {
    Master master(Codec{}, quick);
    ScriptedSlo device{.script = script_of(0x1234), .delay = nanoseconds(470)};
    const Seen seen = run(master, device, {}, cdm);
    BISS_EXPECT_EQ(position_of(master.reading()), 0x1234);
    BISS_EXPECT_EQ(device.ma_at_timeout, !cdm);
    BISS_EXPECT_EQ(master.reading().clocks, 4U + 5U + payload_bits);
    BISS_EXPECT_EQ(seen.falls, master.reading().clocks + (cdm ? 1U : 0U));
    BISS_EXPECT_EQ(seen.rises, seen.falls);
    BISS_EXPECT(seen.shortest == period / 2);
    BISS_EXPECT(seen.end == seen.last_edge || !cdm);
    // MA was low until now, so it must be high for half a period.
    BISS_EXPECT(master.earliest() == seen.last_edge + period / 2);
  }
}

BISS_TEST(RequestEnd, DamagedBits_KeepTheirCauseAndWaitForTheTimeout) {
  Master master(Codec{}, setup);
  for (const std::size_t bit : {6U, 7U, 8U, 20U, 33U, 34U}) {
    ScriptedSlo device{.script = script_of(0x5A5A), .timeout = nanoseconds(12'500)};
    device.script.flip(bit);
    const bool cds = bit == 7;
    const bool stop = bit == 34;
    const Seen seen = run(master, device, master.earliest() + milliseconds(1));
    if (bit == 6) continue;  // START: any bits may follow
    BISS_EXPECT(cause_of(master.reading()) == (cds    ? FrameError::cds
                                               : stop ? FrameError::stop_bit
                                                      : FrameError::crc))
        << "bit " << bit;
    BISS_EXPECT(seen.end >= seen.last_rise + microseconds(20));
  }
}

BISS_TEST(RequestEnd, GlitchWithoutAnAnswer_IsNoResponse) {
  for (const bool compensate : {true, false}) {
    MasterSetup either = setup;
    either.compensate = compensate;
    Master master(Codec{}, either);
    test::LineBits ones;
    ones.append_run(true, 500);
    ScriptedSlo device{.script = ones};
    device.line.put_at(nanoseconds(520), false);
    device.line.put_at(nanoseconds(530), true);
    run(master, device, {});
    BISS_EXPECT(cause_of(master.reading()) == FrameError::no_response);
    BISS_EXPECT(!master.reading().line_delay);
  }
}

BISS_TEST(RequestEnd, ReadyBeforeCdmIsSent_SendsItForHalfAPeriodAllTheSame) {
  MasterSetup longer = setup;
  longer.extra_clocks = 20;
  Master master(Codec{}, longer);
  ScriptedSlo device{.script = script_of(0x1111)};
  device.script.append_run(false, 5);
  device.script.append_run(true, 15);
  const Seen seen = run(master, device, {}, true);
  BISS_EXPECT_EQ(position_of(master.reading()), 0x1111);
  BISS_EXPECT_EQ(seen.falls, master.reading().clocks + 1U);
  BISS_EXPECT(seen.shortest == period / 2);
  BISS_EXPECT(seen.end == seen.last_edge);
}

BISS_TEST(RequestEnd, ResetTimeOfAFewClocks_DoesNotCutAGoodFramesTimeout) {
  MasterSetup hasty = setup;
  hasty.reset_time = nanoseconds(300);
  Master master(Codec{}, hasty);
  ScriptedSlo device{.script = script_of(0x2222)};
  const Seen seen = run(master, device, {});
  BISS_EXPECT(master.reading().ready);
  BISS_EXPECT(seen.end == seen.last_rise + microseconds(20));
}

constexpr DeviceTiming by_time{.start_min = nanoseconds(500),
                               .ack_max = nanoseconds(600),
                               .timeout = {TimeoutRule::cycle, microseconds(10)},
                               .cycle_min = microseconds(10)};
constexpr MasterSetup trusting{.period = period, .timing = by_time, .trust_cycle_time = true};

/// A master that has read a frame and is done while SLO is still low.
Master after_a_frame(const MasterSetup& with = trusting, bool cdm = false) {
  Master master(Codec{}, with);
  // SLO would rise 20 us after the last edge, which is after the end of these tests.
  ScriptedSlo device{.script = script_of(0x155), .delay = nanoseconds(300)};
  run(master, device, {}, cdm);
  BISS_EXPECT_EQ(position_of(master.reading()), 0x155);
  return master;
}

/// The result of a request at the earliest time, with SLO high only from `rise` to `fall`.
FrameError cause_with_slo(Master master, Picoseconds rise, Picoseconds fall) {
  const Picoseconds begin = master.earliest();
  StepOutput out = master.begin(begin, false);
  BISS_EXPECT(!master.done());
  Picoseconds now = begin;
  while (!master.done()) {
    Picoseconds next = out.deadline;
    if (now < begin + rise) next = std::min(next, begin + rise);
    if (now < begin + fall) next = std::min(next, begin + fall);
    now = next;
    out = master.step(now, now >= begin + rise && now < begin + fall);
  }
  return cause_of(master.reading());
}

BISS_TEST(RequestEnd, FixedCycleTimeTrusted_EndsWithItAndTakesSloLow) {
  Master master = after_a_frame();
  BISS_EXPECT(master.earliest() == microseconds(10));
  BISS_EXPECT(master.reading().ready);
  BISS_EXPECT(master.ready_by_time(microseconds(10)));
  // After the line delay and half a period of grace, SLO must be high.
  BISS_EXPECT(master.ready_by_time(nanoseconds(10'349)));
  BISS_EXPECT(!master.ready_by_time(nanoseconds(10'350)));
  Master late = master;
  late.begin(nanoseconds(10'350), false);
  BISS_EXPECT(late.reading().refusal == Refusal::slo_low);
  Master early = master;
  const StepOutput out = early.begin(nanoseconds(9'999), false);
  BISS_EXPECT(early.reading().refusal == Refusal::too_early);
  BISS_EXPECT(out.deadline == microseconds(10));
  early.begin(microseconds(10), false);
  BISS_EXPECT(!early.done());
}

BISS_TEST(RequestEnd, FixedCycleTimeNotTrustedOrCdm1_WaitsForSlo) {
  MasterSetup waiting = trusting;
  waiting.trust_cycle_time = false;
  BISS_EXPECT(!after_a_frame(waiting).ready_by_time(microseconds(10)));
  BISS_EXPECT(!after_a_frame(trusting, true).ready_by_time(microseconds(10)));
  MasterSetup other = trusting;
  other.timing.timeout = {TimeoutRule::fixed, microseconds(10)};
  BISS_EXPECT(!after_a_frame(other).ready_by_time(microseconds(10)));
}

BISS_TEST(RequestEnd, SloThatDoesNotRiseInTime_IsResponseRange) {
  const Master master = after_a_frame();
  BISS_EXPECT(cause_with_slo(master, nanoseconds(351), microseconds(90)) ==
              FrameError::response_range);
  BISS_EXPECT(cause_with_slo(master, nanoseconds(349), microseconds(90)) ==
              FrameError::no_response);
  // A high level shorter than a clock does not end a cycle.
  BISS_EXPECT(cause_with_slo(master, nanoseconds(200), nanoseconds(299)) ==
              FrameError::response_range);
  BISS_EXPECT(cause_with_slo(master, nanoseconds(300), nanoseconds(400)) == FrameError::no_start);
}

}  // namespace request_end_test
