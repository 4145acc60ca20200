// Requests for less than a frame, and CDM that is held between requests.
#include "biss/master/request.hpp"
#include "biss/slave/slave.hpp"
#include "tests/core/frames.hpp"
#include "tests/core/requests.hpp"
#include "tests/core/scripted_slo.hpp"
#include "tests/core/test.hpp"
#include "tests/core/wire.hpp"

namespace request_kind_test {

using namespace biss;
using namespace biss::test::request;

using test::ScriptedSlo;

struct Encoder {
  std::uint64_t position = 0;
  bool next_cds = false;
  bool last_cdm = false;
  std::uint32_t frames = 0;

  BasicFrame<1> sample(Picoseconds) const {
    BasicFrame<1> frame;
    frame.channel_count = 1;
    frame.channel_list[0].position = position;
    return frame;
  }
  bool cds(bool) const { return next_cds; }
  void cdm(bool bit) {
    last_cdm = bit;
    ++frames;
  }
};

constexpr FrameFormat both_ways = test::format_of("pos18,nE,nW,crc6");
using BothWays = FixedCodec<both_ways>;
using EncoderSlave = Slave<BothWays, Encoder, 0>;
using Wire = test::Wire<RequestCycle<BothWays>, test::Row<EncoderSlave, 1>>;

Wire wire(const MasterSetup& with, const DeviceTiming& device, Picoseconds delay) {
  return {.master{BothWays{}, with},
          .device{{EncoderSlave(BothWays{}, slave_timing(device, nanoseconds(510)), Encoder{})}},
          .way_out{test::DelayLine(delay / 2)},
          .way_back{test::DelayLine(delay - delay / 2)}};
}

constexpr DeviceTiming device_with(TimeoutRule rule) {
  DeviceTiming device = timing;
  device.timeout = {rule, rule == TimeoutRule::adaptive ? nanoseconds(20) : microseconds(20)};
  device.cycle_min = {};
  return device;
}

/// The SLO of a device without active channels: LAT, ACK, START, CDS, STOP.
test::LineBits short_script(bool cds) { return test::line_of(cds ? "10000011" : "10000010"); }

BISS_TEST(RequestKind, ControlOnlyWithActiveChannels_BringsCdsAndCdmAndStopsEarly) {
  BISS_RANDOM(random, 0x3101);
  for (const TimeoutRule rule : {TimeoutRule::adaptive, TimeoutRule::fixed, TimeoutRule::cycle}) {
    for (const std::int64_t delay : {0, 42, 99, 730, 9'100, 39'900}) {
      const Picoseconds clock = delay < 9'000 ? period : microseconds(1);
      MasterSetup with{.period = clock, .timing = device_with(rule)};
      with.hold_cdm = random.flip();
      Wire link = wire(with, with.timing, nanoseconds(delay));
      Encoder& encoder = link.device.slaves[0].source();
      for (std::uint32_t i = 1; i < 40; ++i) {
        encoder.position = i < 5 ? low_mask(18) * (i & 1U) : random.bits(18);
        encoder.next_cds = random.flip();
        const bool cdm = random.flip();
        const bool whole = random.below(4) == 0;
        const Reading& reading =
            link.request(whole ? RequestKind::frame : RequestKind::control_only, cdm);
        // If the master knows when the encoder is ready, it does not wait for SLO.
        link.rest_until(link.now + nanoseconds(delay));
        BISS_ASSERT(reading.cds.has_value()) << "delay " << delay << ", request " << i;
        BISS_ASSERT_EQ(*reading.cds, encoder.next_cds) << "delay " << delay << ", request " << i;
        BISS_ASSERT_EQ(encoder.frames, i) << "delay " << delay;
        BISS_ASSERT_EQ(encoder.last_cdm, cdm) << "delay " << delay << ", request " << i;
        BISS_ASSERT(reading.line_delay == nanoseconds(delay));
        BISS_ASSERT(reading.ready && link.shortest >= clock / 2);
        if (whole) {
          BISS_ASSERT_EQ(position_of(reading), encoder.position);
          continue;
        }
        BISS_ASSERT(cause_of(reading) == FrameError::truncated);
        // The clock of STOP of a device without channels, the clocks in transit, and one clock to
        // set CDM.
        const Picoseconds under_way = nanoseconds(delay) + clock;
        const auto most = static_cast<std::uint32_t>(under_way.count / clock.count);
        BISS_ASSERT(reading.clocks <= 4U + reading.ack_clocks + (delay == 0 ? 0U : most + 1U));
      }
    }
  }
}

BISS_TEST(RequestKind, CdmThatAnswersCds_ArrivesWithTheSameRequest) {
  BISS_RANDOM(random, 0x3103);
  for (const TimeoutRule rule : {TimeoutRule::adaptive, TimeoutRule::fixed, TimeoutRule::cycle}) {
    for (std::uint32_t i = 0; i < test::rounds(200, 8); ++i) {
      // More bits than the complete payload may be in transit.
      const Picoseconds delay = picoseconds(random.below(i % 2 == 0 ? 9'000'000 : 300'000));
      MasterSetup with{.period = period, .timing = device_with(rule)};
      with.hold_cdm = random.flip();
      with.compensate = i % 8 != 7;
      Wire link = wire(with, with.timing, delay);
      Encoder& encoder = link.device.slaves[0].source();
      for (std::uint32_t k = 1; k < 6; ++k) {
        encoder.position = random.bits(18);
        encoder.next_cds = random.flip();
        const auto kind = random.flip() ? RequestKind::control_only : RequestKind::frame;
        const auto& reading =
            link.request_with(kind, random.flip(), {}, [](bool cds) { return !cds; });
        link.rest_until(link.now + delay);
        BISS_ASSERT_EQ(encoder.frames, k);
        BISS_ASSERT_EQ(encoder.last_cdm, !encoder.next_cds) << "delay " << delay.count;
        BISS_ASSERT(kind != RequestKind::frame || position_of(reading) == encoder.position);
      }
    }
  }
}

BISS_TEST(RequestKind, ControlOnlyWithoutChannels_IsTheShortFrameAndEndsWithSlo) {
  for (const bool hold : {false, true}) {
    for (const bool cdm : {false, true}) {
      for (const bool cds : {false, true}) {
        for (const std::int64_t delay : {0, 470, 3'333}) {
          MasterSetup with = setup;
          with.hold_cdm = hold;
          Master master(Codec{}, with);
          ScriptedSlo device{.script = short_script(cds), .delay = nanoseconds(delay)};
          bool ma = true;
          Picoseconds now{};
          StepOutput out = master.begin(now, true, cdm, RequestKind::control_only);
          Picoseconds rise{};
          while (!master.done()) {
            if (out.level && !ma && master.reading().clocks == 0) rise = now;
            ma = out.level;
            device.step(now, ma);
            now = std::min(out.deadline, device.next());
            device.step(now, ma);
            out = master.step(now, device.line.level(now));
          }
          const Reading& reading = master.reading();
          BISS_EXPECT(reading.cds == cds);
          BISS_EXPECT_EQ(reading.ack_clocks, 5);
          BISS_EXPECT(reading.clocks >= 9U && reading.clocks <= 11U + delay / 100);
          BISS_EXPECT(reading.ready);
          BISS_EXPECT_EQ(device.ma_at_timeout, !cdm) << "delay " << delay;
          BISS_EXPECT_EQ(out.level, !(hold && cdm));
          // The timeout after the last edge, and the line delay in both directions.
          BISS_EXPECT(now - rise <= microseconds(20) + period + nanoseconds(delay));
        }
      }
    }
  }
}

BISS_TEST(RequestKind, ControlOnlyThatStopsAtAOne_HoldsCdmForTheLongestTimeout) {
  for (const bool cdm : {false, true}) {
    Master master(Codec{}, setup);
    ScriptedSlo device{.script = script_of(low_mask(18)), .timeout = microseconds(38)};
    StepOutput out = master.begin({}, true, cdm, RequestKind::control_only);
    bool ma = true;
    Picoseconds now{};
    Picoseconds last{};
    while (!master.done()) {
      // MA was unchanged until now.
      if (out.level != ma) last = now;
      ma = out.level;
      device.step(now, ma);
      now = std::min(out.deadline, device.next());
      device.step(now, ma);
      out = master.step(now, device.line.level(now));
      BISS_ASSERT(master.done() || now < microseconds(3) || out.level == !cdm);
    }
    BISS_EXPECT_EQ(device.ma_at_timeout, !cdm);
    BISS_EXPECT(now == last + microseconds(40));
    BISS_EXPECT(out.level && master.reading().ready);
  }
}

BISS_TEST(RequestKind, Reduced_IsTwoClocksAndCarriesCdm) {
  for (const bool compensate : {true, false}) {
    for (const TimeoutRule rule : {TimeoutRule::adaptive, TimeoutRule::fixed, TimeoutRule::cycle}) {
      for (const std::int64_t delay : {0, 60, 1'234, 39'000}) {
        const Picoseconds clock = delay < 9'000 ? period : microseconds(1);
        MasterSetup with{.period = clock, .timing = device_with(rule), .compensate = compensate};
        with.hold_cdm = delay == 60;
        Wire link = wire(with, with.timing, nanoseconds(delay));
        const Encoder& encoder = link.device.slaves[0].source();
        for (std::uint32_t i = 1; i < 9; ++i) {
          const bool cdm = i % 3 == 1;
          const auto& reading = link.request(RequestKind::reduced, cdm);
          link.rest_until(link.now + nanoseconds(delay));
          BISS_ASSERT(cause_of(reading) == FrameError::truncated) << "delay " << delay;
          BISS_ASSERT(!reading.cds);
          BISS_ASSERT_EQ(reading.clocks, 2);
          BISS_ASSERT(reading.line_delay == nanoseconds(delay));
          BISS_ASSERT_EQ(encoder.frames, i) << "delay " << delay;
          BISS_ASSERT_EQ(encoder.last_cdm, cdm) << "delay " << delay << ", request " << i;
          BISS_ASSERT(reading.ready && link.shortest >= clock / 2);
        }
        // The encoder works normally afterwards.
        BISS_ASSERT(link.request().frame.ok());
      }
    }
  }
}

BISS_TEST(RequestKind, ReducedWithoutAnswer_IsNoResponseAndMaIsHigh) {
  for (const bool hold : {false, true}) {
    MasterSetup with = setup;
    with.hold_cdm = hold;
    Wire link = wire(with, timing, {});
    link.stuck = true;
    const auto& reading = link.request(RequestKind::reduced, true);
    BISS_EXPECT(cause_of(reading) == FrameError::no_response);
    BISS_EXPECT_EQ(reading.clocks, 2);
    BISS_EXPECT(link.driven.level);
    BISS_EXPECT_EQ(link.falls, 3U);
    // CDM was sent anyway: the master waits for the line delay with MA low.
    BISS_EXPECT(link.device.slaves[0].source().last_cdm);
    BISS_EXPECT(link.now >= link.last_edge + microseconds(20));
  }
}

BISS_TEST(RequestKind, HeldCdm_LeavesMaLowUntilJustBeforeTheNextRequest) {
  MasterSetup with = setup;
  with.hold_cdm = true;
  with.idle_min = nanoseconds(70);
  with.timing.cycle_min = {};
  Wire link = wire(with, timing, nanoseconds(330));
  Encoder& encoder = link.device.slaves[0].source();
  encoder.position = 0x2BCDE;
  for (std::uint32_t i = 1; i < 9; ++i) {
    const bool held = !link.driven.level;
    BISS_EXPECT_EQ(held, i % 2 == 0);
    const Picoseconds at = link.now + microseconds(100);
    const auto& reading = link.request(RequestKind::frame, i % 2 == 1, at);
    BISS_ASSERT_EQ(position_of(reading), 0x2BCDE);
    BISS_EXPECT(reading.begin == (held ? at + nanoseconds(70) : at));
    BISS_EXPECT_EQ(encoder.frames, i);
    BISS_EXPECT_EQ(encoder.last_cdm, i % 2 == 1);
    BISS_EXPECT_EQ(reading.clocks, 4U + reading.ack_clocks + payload_bits);
    BISS_EXPECT(link.shortest == period / 2);
  }
}

BISS_TEST(RequestKind, HeldCdm_LateRiseMovesTheBeginning) {
  MasterSetup with = setup;
  with.hold_cdm = true;
  Wire link = wire(with, timing, {});
  link.request(RequestKind::frame, true);
  BISS_EXPECT(!link.driven.level);
  const Picoseconds at = link.now + microseconds(30);
  link.rest_until(at);
  StepOutput out = link.master.begin(at, true, false);
  BISS_EXPECT(out.level && out.deadline == at + period / 2);
  out = link.master.step(at + period, true);
  BISS_EXPECT(!out.level);
  BISS_EXPECT(link.master.reading().begin == at + period);
  BISS_EXPECT(out.deadline == at + period * 3 / 2);
}

BISS_TEST(RequestKind, BadFrame_StillTellsItsCds) {
  for (const std::size_t bit : {8U, 20U, 33U, 34U}) {
    for (const bool cds : {false, true}) {
      ScriptedSlo device{.script = script_of(0x5A5A)};
      device.script.flip(bit);
      if (cds) device.script.flip(7);
      MasterSetup any = setup;
      RequestCycle<BothWays> master(BothWays{}, any);
      test::run(master, device, {});
      BISS_EXPECT(!master.reading().frame.ok());
      BISS_EXPECT(master.reading().cds == cds) << "bit " << bit;
    }
  }
  Master master(Codec{}, setup);
  ScriptedSlo silent{.script = low_from_ack()};
  test::run(master, silent, {});
  BISS_EXPECT(!master.reading().cds);
}

BISS_TEST(RequestKind, RandomSlo_AlwaysEndsAndTheNextIsTaken) {
  BISS_RANDOM(random, 0x3102);
  for (std::uint32_t i = 0; i < test::rounds(4'000, 30); ++i) {
    MasterSetup any = setup;
    any.compensate = random.flip();
    any.hold_cdm = random.flip();
    any.extra_clocks = static_cast<std::uint16_t>(random.below(5));
    Master master(Codec{}, any);
    const std::uint32_t pace = 1U + random.below(random.flip() ? 300'000 : 5'000'000);
    Picoseconds now{};
    bool slo = true;
    for (std::uint32_t k = 0; k < 4; ++k) {
      now = std::max(now, master.earliest());
      const Picoseconds begin = now;
      Picoseconds change = now;
      StepOutput out =
          master.begin(now, true, random.flip(), static_cast<RequestKind>(random.below(3)));
      BISS_ASSERT(!out.level || any.hold_cdm);
      while (!master.done()) {
        BISS_ASSERT(out.deadline >= now && out.has_deadline());
        if (change <= now) change = now + picoseconds(1 + random.below(pace));
        now = std::min(out.deadline, change);
        if (now == change) slo = !slo;
        out = master.step(now, slo);
      }
      BISS_ASSERT(!out.has_deadline());
      BISS_ASSERT(out.level || any.hold_cdm);
      BISS_ASSERT(now - begin < microseconds(40 + 6 + 40 + 40));
    }
  }
}

}  // namespace request_kind_test
