#include "decode/decoder.hpp"

#include <gtest/gtest.h>

#include <string>

#include "decode/test_line.hpp"

namespace biss::decode::test {
namespace decoder_test {

constexpr std::uint64_t position_of(std::uint64_t k) { return k * 0x9E3779B97F4A7C15U >> 3U; }

// Several requests of one shape; every row is right.
void expect_all_right(const Shape& shape, std::string_view format = usual_format,
                      int requests = 5) {
  TestLine line;
  std::vector<Picoseconds> times;
  const unsigned bits = parse_format(format)->channel_list[0].position_bits();
  for (int k = 0; k < requests; ++k) {
    times.push_back(
        line.request(shape, position_of(static_cast<std::uint64_t>(k)) & low_mask(bits), format));
  }
  const auto cycles = decode(line, format);
  ASSERT_EQ(cycles.size(), times.size());
  for (std::size_t k = 0; k < cycles.size(); ++k) {
    const Cycle& cycle = cycles[k];
    ASSERT_EQ(name_of(cycle.status), "ok") << "cycle " << k;
    EXPECT_EQ(cycle.frame->channel_list[0].position, position_of(k) & low_mask(bits));
    EXPECT_EQ(cycle.time, times[k]);
    const std::int64_t jitter = shape.period.count * shape.jitter_percent / 50;
    EXPECT_NEAR(static_cast<double>(cycle.line_delay->count),
                static_cast<double>(std::max(shape.line_delay, Picoseconds{}).count), 1.0);
    EXPECT_NEAR(static_cast<double>(cycle.ack->count),
                static_cast<double>(shape.period.count * shape.ack_clocks),
                static_cast<double>(jitter));
    EXPECT_NEAR(static_cast<double>(cycle.period->count), static_cast<double>(shape.period.count),
                static_cast<double>(shape.period.count) / 50);
  }
}

TEST(Decoder, FormatsOfAllKinds_ReadTheirPosition) {
  for (const std::string_view format :
       {"pos26,nE,nW,crc6;cds0", "mt12,st20,nE,nW,lc6,crc16", "pos1,crc3", "pos8", "pos64,crc16",
        "mt16,st19:gray,E,W,crc8", "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0",
        "pos64,crc16+pos64,crc16+pos64,crc16+pos64,crc16+pos64,crc16+pos64,crc16+pos64,crc16+"
        "pos64,crc16"}) {
    SCOPED_TRACE(format);
    expect_all_right({}, format);
  }
}

TEST(Decoder, ClocksAndLineDelays_AreMeasured) {
  for (const std::int64_t hz : {80'000, 250'000, 1'000'000, 2'500'000, 5'000'000, 10'000'000}) {
    for (const std::int64_t ns : {0, 5, 49, 112, 700, 5'000, 40'000}) {
      SCOPED_TRACE(std::to_string(hz) + " Hz, " + std::to_string(ns) + " ns");
      expect_all_right({.period = period_of(hertz(static_cast<std::uint32_t>(hz))),
                        .line_delay = nanoseconds(ns)});
    }
  }
}

TEST(Decoder, UnevenDuty_IsMeasuredAndHarmless) {
  for (const int duty : {40, 50, 60}) {
    const Shape shape{.high_percent = duty, .timeout = nanoseconds(1'500), .gap = nanoseconds(10)};
    expect_all_right(shape);
    TestLine line;
    line.request(shape, 5);
    EXPECT_EQ(decode(line)[0].duty_per_mille, static_cast<unsigned>(duty * 10));
  }
}

TEST(Decoder, JitterOfAnEighthEitherWay_IsHarmless) {
  TestLine line(7);
  for (std::uint64_t k = 0; k < 50; ++k) line.request({.jitter_percent = 12}, k);
  const auto cycles = decode(line);
  ASSERT_EQ(cycles.size(), 50U);
  for (std::size_t k = 0; k < cycles.size(); ++k) {
    ASSERT_EQ(name_of(cycles[k].status), "ok");
    EXPECT_EQ(cycles[k].frame->channel_list[0].position, k);
  }
}

// The status of three requests with this line delay, all of them the same.
std::string_view status_at(const Shape& shape, const MarginSetup& margin,
                           std::optional<Picoseconds> delay = Picoseconds{}) {
  TestLine line;
  for (std::uint64_t k = 0; k < 3; ++k) line.request(shape, k);
  const auto cycles = decode(line.edges(), line.last_time(), usual_format, {}, margin);
  if (cycles.size() != 3) return "not three rows";
  for (const Cycle& cycle : cycles) {
    if (cycle.status != cycles[0].status) return "not all the same";
    if (cycle.status == CycleStatus::ok) {
      EXPECT_EQ(cycle.line_delay, delay);
    }
  }
  return name_of(cycles[0].status);
}

TEST(Decoder, SloBeforeMaWithinTheResolution_IsDelayZero) {
  for (const std::int64_t period_ns : {100, 1'000}) {
    const Shape shape{.period = nanoseconds(period_ns), .line_delay = nanoseconds(-8)};
    EXPECT_EQ(status_at(shape, {.resolution = nanoseconds(8)}), "ok");
    EXPECT_EQ(status_at(shape, {.resolution = picoseconds(7'999)}), "response_range");
    EXPECT_EQ(status_at(shape, {}), "response_range");
  }
}

TEST(Decoder, SloBeforeMaWithoutResolution_IsResponseRangeHoweverLittle) {
  EXPECT_EQ(status_at({}, {}, nanoseconds(100)), "ok");
  EXPECT_EQ(status_at({.line_delay = Picoseconds{}}, {}), "ok");
  for (const std::int64_t early_ps : {1, 20'000, 100'000, 200'000, 249'000, 300'000, 499'000}) {
    EXPECT_EQ(status_at({.line_delay = picoseconds(-early_ps)}, {}), "response_range") << early_ps;
  }
}

TEST(Decoder, SloLowOverTheEdgeOfAck_IsAnEarlyAnswerFromHalfAPeriodOn) {
  for (const std::int64_t width_ns : {400, 501, 700}) {
    TestLine line;
    for (std::uint64_t k = 0; k < 3; ++k) line.request({}, k);
    const Picoseconds ack = line.ma[line.begins[1] + 3].time;
    const Picoseconds begin = ack - nanoseconds(399);
    for (LevelChange& change : line.slo) {
      if (change.time == ack + nanoseconds(100)) change.time += nanoseconds(300);
    }
    TestLine::add_pulse(line.slo, begin, nanoseconds(width_ns), wire::Level::low);
    const auto cycles = decode(line);
    ASSERT_EQ(cycles.size(), 3U);
    EXPECT_EQ(cycles[1].status == CycleStatus::response_range, width_ns > 500) << width_ns;
  }
}

TEST(Decoder, SloBeforeMaByMoreThanAQuarterPeriod_IsResponseRangeInAnyCapture) {
  const MarginSetup coarse{.resolution = nanoseconds(600)};
  EXPECT_EQ(status_at({.line_delay = nanoseconds(-250)}, coarse), "ok");
  for (const std::int64_t early_ns : {251, 300, 400, 499}) {
    EXPECT_EQ(status_at({.line_delay = nanoseconds(-early_ns)}, coarse), "response_range")
        << early_ns;
  }
}

TEST(Decoder, SloBeforeMaWithinTheJitterOfMa_IsDelayZero) {
  // ACK's edge comes 40 ns late, so that SLO seems to fall before it.
  for (const std::int64_t later_ns : {0, 45}) {
    TestLine line;
    for (std::uint64_t k = 0; k < 3; ++k) line.request({.line_delay = Picoseconds{}}, k);
    for (const std::size_t begin : line.begins) line.ma[begin + 3].time += nanoseconds(40);
    for (LevelChange& change : line.slo) change.time -= nanoseconds(later_ns);
    for (const Cycle& cycle : decode(line)) {
      EXPECT_EQ(name_of(cycle.status), later_ns == 0 ? "ok" : "response_range");
    }
  }
}

TEST(Decoder, CapturesWithFewSamplesAPeriod_ReadEveryPosition) {
  for (const std::int64_t sample_ps : {41'667, 40'000, 20'833, 10'000, 8'000}) {
    for (const std::int64_t delay_ns : {0, 13, 50, 99, 213, 1'234}) {
      SCOPED_TRACE(std::to_string(sample_ps) + " ps, delay " + std::to_string(delay_ns) + " ns");
      TestLine line;
      for (std::uint64_t k = 0; k < 40; ++k) {
        line.request({.period = nanoseconds(100),
                      .line_delay = nanoseconds(delay_ns),
                      .gap = picoseconds(5'000'003 + static_cast<std::int64_t>(k) * 7'001)},
                     position_of(k) & low_mask(26));
      }
      line.ma = sampled(line.ma, picoseconds(sample_ps));
      line.slo = sampled(line.slo, picoseconds(sample_ps));
      const auto cycles = decode(line);
      ASSERT_EQ(cycles.size(), 40U);
      for (std::size_t k = 0; k < cycles.size(); ++k) {
        ASSERT_EQ(name_of(cycles[k].status), "ok") << k;
        EXPECT_EQ(cycles[k].frame->channel_list[0].position, position_of(k) & low_mask(26));
      }
    }
  }
}

TEST(Decoder, CdmOne_ReturningEdgeIsNoClock) {
  for (const Ending ending : {Ending::low_until_timeout, Ending::low_until_next}) {
    for (const Picoseconds timeout : {nanoseconds(1'600), microseconds(20)}) {
      expect_all_right({.timeout = timeout, .ending = ending});
      TestLine line;
      for (int k = 0; k < 3; ++k) line.request({.timeout = timeout, .ending = ending}, 3);
      for (const Cycle& cycle : decode(line)) {
        EXPECT_EQ(cycle.rising_edges, bits_of(usual_format, 3).size_bits());
      }
    }
  }
}

TEST(Decoder, CaptureBeginsWithMaHeldLow_FirstCycleIsWhole) {
  TestLine line;
  line.ma = {low_at({}), high_at(line.now - nanoseconds(100))};
  line.request({}, 77);
  const auto cycles = decode(line);
  ASSERT_EQ(cycles.size(), 1U);
  EXPECT_EQ(name_of(cycles[0].status), "ok");
}

// The encoder is ready 1.5 periods after the last edge, and the master sends the next request
// immediately.
TEST(Decoder, NextRequestRightBehindAdaptiveTimeout_IsACycleOfItsOwn) {
  for (const int duty : {40, 50, 60}) {
    for (const std::int64_t period_ns : {100, 1'000, 4'000}) {
      const Picoseconds period = nanoseconds(period_ns);
      expect_all_right({.period = period,
                        .high_percent = duty,
                        .line_delay = nanoseconds(9),
                        .timeout = period * 3 / 2,
                        .gap = period / 10});
    }
  }
}

// A pause slightly longer than half a period does not hide a request either.
TEST(Decoder, RequestBehindAShortPauseInWhichSloGoesIdle_IsACycleOfItsOwn) {
  for (const std::int64_t pause_ns : {620, 700, 800, 900, 1'000, 1'100, 1'220, 1'300, 1'400}) {
    for (const Ending ending : {Ending::idle_high, Ending::low_until_next}) {
      // MA rises 100 ns before the request, and SLO must rise before that.
      if (ending == Ending::low_until_next && pause_ns < 800) continue;
      for (const std::string_view format : {usual_format, std::string_view()}) {
        SCOPED_TRACE(std::to_string(pause_ns) + " ns, ending " +
                     std::to_string(static_cast<int>(ending)) + ", format " + std::string(format));
        // SLO is released 610 ns after the last edge, just after STOP is sampled.
        const Shape shape{
            .timeout = nanoseconds(510), .gap = nanoseconds(pause_ns - 610), .ending = ending};
        TestLine line;
        std::vector<Picoseconds> times;
        for (std::uint64_t k = 0; k < 19; ++k) times.push_back(line.request(shape, k));
        times.push_back(line.request({}, 19));
        const auto cycles = decode(line, format);
        ASSERT_EQ(cycles.size(), 20U);
        for (std::size_t k = 0; k < 20; ++k) {
          EXPECT_EQ(name_of(cycles[k].status), format.empty() ? "unchecked" : "ok") << k;
          EXPECT_EQ(cycles[k].time, times[k]);
          if (cycles[k].frame) {
            EXPECT_EQ(cycles[k].frame->channel_list[0].position, k);
          }
        }
      }
    }
  }
}

TEST(Decoder, RequestBehindAShortPauseAndADamagedFrame_HasItsOwnRow) {
  const Shape shape{.timeout = nanoseconds(510), .gap = nanoseconds(190)};
  FrameBits damaged = bits_of(usual_format, 5);
  damaged.flip(20);
  FrameBits zeros;
  zeros.append(true);
  zeros.append_run(false, 40);
  TestLine line;
  line.request(shape, 1);
  line.request(shape, damaged);
  line.request(shape, 2);
  line.request(shape, zeros);
  line.request(shape, 3);
  std::vector<std::string_view> seen;
  for (const Cycle& cycle : decode(line)) seen.push_back(name_of(cycle.status));
  EXPECT_EQ(seen, (std::vector<std::string_view>{"ok", "crc", "ok", "no_start", "ok"}));
}

TEST(Decoder, PauseOfTheMasterInsideAFrame_IsNoEndOfIt) {
  // The clock stays high for 300 ns longer, at each clock of the frame in turn.
  for (std::size_t clock = 2; clock < 39; ++clock) {
    TestLine line;
    for (std::uint64_t k = 0; k < 3; ++k) line.request({}, 0x2C5'3A96 + k);
    const Picoseconds at = line.ma[line.begins[1] + 2 * clock].time;
    for (auto* changes : {&line.ma, &line.slo}) {
      for (LevelChange& change : *changes) {
        if (change.time >= at) change.time += nanoseconds(300);
      }
    }
    const auto cycles = decode(line.edges(), line.last_time() + milliseconds(1));
    ASSERT_EQ(cycles.size(), 3U) << clock;
    for (const Cycle& cycle : cycles) EXPECT_EQ(name_of(cycle.status), "ok") << clock;
  }
}

TEST(Decoder, TightCyclesThatAllFail_AreStillCyclesOfTheirOwn) {
  const Shape tight{.timeout = nanoseconds(1'500), .gap = nanoseconds(10)};
  TestLine line;
  for (std::uint64_t k = 0; k < 10; ++k) line.request(tight, 0x2AAAAAA + k);
  const auto cycles = decode(line, "pos36,nE,nW,crc6");
  ASSERT_EQ(cycles.size(), 10U);
  for (const Cycle& cycle : cycles) EXPECT_EQ(name_of(cycle.status), "truncated");

  line.slo.resize(1);
  const auto silent = decode(line);
  ASSERT_EQ(silent.size(), 10U);
  for (const Cycle& cycle : silent) EXPECT_EQ(name_of(cycle.status), "no_response");
}

TEST(Decoder, RequestThatReachesTheEncoderJustWhenItIsReady_IsRead) {
  // The master sees the release of SLO one line delay after its own first edge.
  for (const std::int64_t delay_ns : {50, 142, 542, 1042}) {
    Shape shape{.period = nanoseconds(100), .line_delay = nanoseconds(delay_ns)};
    shape.gap = -shape.line_delay;
    TestLine line;
    for (std::uint64_t k = 0; k < 5; ++k) line.request(shape, 1000 + k);
    const DeviceTiming fixed_cycle{.timeout = {TimeoutRule::cycle, microseconds(31)}};
    const auto cycles = decode(line, usual_format, fixed_cycle);
    ASSERT_EQ(cycles.size(), 5U) << delay_ns;
    for (std::uint64_t k = 0; k < 5; ++k) {
      ASSERT_TRUE(cycles[k].frame) << delay_ns << ": " << name_of(cycles[k].status);
      EXPECT_EQ(cycles[k].frame->channel_list[0].position, 1000 + k);
      EXPECT_EQ(cycles[k].line_delay, shape.line_delay);
    }
  }
}

TEST(Decoder, InvertedSlo_IsNeverReady) {
  const DeviceTiming fixed_cycle{.timeout = {TimeoutRule::cycle, microseconds(31)}};
  TestLine line;
  const Shape shape{.period = nanoseconds(100), .ack_clocks = 40};
  for (std::uint64_t k = 0; k < 5; ++k) line.request(shape, 0x1555555 + k);
  for (LevelChange& change : line.slo) {
    change.level = change.level == wire::Level::low ? wire::Level::high : wire::Level::low;
  }
  for (const Cycle& cycle : decode(line, usual_format, fixed_cycle)) {
    EXPECT_EQ(name_of(cycle.status), "not_ready");
  }
}

TEST(Decoder, ClocksBehindStop_ChangeNothing) {
  for (const int extra : {1, 2, 17, 300}) expect_all_right({.extra_clocks = extra});
}

TEST(Decoder, MasterWithoutClockForStop_IsOk) {
  expect_all_right({.extra_clocks = -1});
  TestLine line;
  line.request({.extra_clocks = -1}, 5);
  EXPECT_FALSE(decode(line)[0].frame->stop_seen);
}

TEST(Decoder, ClockThatChangesBetweenCycles_IsMeasuredEachTime) {
  TestLine line;
  const std::vector<std::int64_t> periods{4'000, 100, 1'000, 12'500, 100, 4'000};
  for (std::size_t k = 0; k < periods.size(); ++k) {
    line.request({.period = nanoseconds(periods[k])}, k);
  }
  const auto cycles = decode(line);
  ASSERT_EQ(cycles.size(), periods.size());
  for (std::size_t k = 0; k < cycles.size(); ++k) {
    ASSERT_EQ(name_of(cycles[k].status), "ok") << k;
    EXPECT_EQ(cycles[k].frame->channel_list[0].position, k);
    EXPECT_EQ(*cycles[k].period, nanoseconds(periods[k]));
  }
}

TEST(Decoder, RawBits_RunFromStartToStop) {
  TestLine line;
  line.request({.extra_clocks = 5}, 0x1234567);
  const Cycle cycle = decode(line)[0];
  const FrameBits bits = bits_of(usual_format, 0x1234567);
  const BitView sent = bits.view().from(4);
  ASSERT_EQ(cycle.raw.size_bits(), sent.size_bits());
  EXPECT_EQ(cycle.raw.view().word(0, 37), sent.word(0, 37));
}

TEST(Decoder, WithoutFormat_GivesStructureAndRawOnly) {
  TestLine line;
  for (std::uint64_t k = 0; k < 5; ++k) line.request({}, k);
  const auto cycles = decode(line, "");
  ASSERT_EQ(cycles.size(), 5U);
  for (const Cycle& cycle : cycles) {
    EXPECT_EQ(name_of(cycle.status), "unchecked");
    EXPECT_FALSE(cycle.frame);
    EXPECT_FALSE(cycle.crc_ok[0]);
    EXPECT_EQ(cycle.raw.size_bits(), 37U);
  }
}

TEST(Decoder, TimesAtTheEndsOfTheirRange_AreReadToo) {
  for (const Picoseconds shift :
       {picoseconds(INT64_MIN + 1), picoseconds(INT64_MAX) - milliseconds(2)}) {
    TestLine line;
    for (std::uint64_t k = 0; k < 3; ++k) line.request({}, k);
    auto edges = line.edges();
    for (wire::Edge& edge : edges) edge.time += shift;
    const auto cycles = decode(edges, picoseconds(INT64_MAX));
    ASSERT_EQ(cycles.size(), 3U);
    for (const Cycle& cycle : cycles) EXPECT_EQ(name_of(cycle.status), "ok");
  }
}

TEST(Decoder, NoEdges_NoRows) {
  EXPECT_TRUE(decode(std::vector<wire::Edge>{}, {}).empty());
  EXPECT_TRUE(decode(TestLine(), usual_format).empty());
}

TEST(Decoder, MaAlone_AnswersNothing) {
  TestLine line;
  line.request({}, 1);
  line.slo.resize(1);
  EXPECT_EQ(name_of(decode(line)[0].status), "no_response");
  line.slo.clear();
  EXPECT_EQ(name_of(decode(line)[0].status), "unknown_level");
}

}  // namespace decoder_test
}  // namespace biss::decode::test
