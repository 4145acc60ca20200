#include "decode/limits.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "decode/test_line.hpp"

namespace biss::decode {
namespace limits_test {

// As Renishaw's encoders.
constexpr DeviceTiming by_cycle{.clock_min = kilohertz(250),
                                .timeout = {TimeoutRule::cycle, nanoseconds(31'250)},
                                .cycle_min = nanoseconds(31'250),
                                .clock_constant = true};
constexpr DeviceTiming adaptive{.timeout = {TimeoutRule::adaptive, {}}};
constexpr DeviceTiming fixed{.timeout = {TimeoutRule::fixed, microseconds(20)}};
constexpr Picoseconds cycle_time = nanoseconds(31'250);

// Requests that this encoder answers; SLO rises `until` after the start of each, and the next request
// comes `interval` after it.
test::TestLine line_of(test::Shape shape, Picoseconds until, Picoseconds interval,
                       int requests = 20, std::uint64_t seed = 1) {
  test::TestLine line(seed);
  const FrameBits bits = test::bits_of(test::usual_format, 5, shape.ack_clocks);
  const auto clocks = static_cast<std::int64_t>(bits.size_bits()) + shape.extra_clocks;
  const Picoseconds last_rise = clocks * shape.period - shape.period * shape.high_percent / 100;
  shape.timeout = until - last_rise;
  shape.gap = interval - until - shape.line_delay;
  for (int i = 0; i < requests; ++i) line.request(shape, bits);
  return line;
}

// The cells of the column, one after the other if they differ; `-` is an empty cell.
std::string limits_of(const std::vector<wire::Edge>& edges, const DeviceTiming& timing,
                      Picoseconds resolution = {}) {
  LimitWatch watch(timing);
  std::string all;
  std::string last = "none";
  const auto cycles = test::decode(edges, edges.back().time + milliseconds(1), test::usual_format,
                                   timing, {.resolution = resolution});
  for (const Cycle& cycle : cycles) {
    EXPECT_TRUE(cycle.status == CycleStatus::ok) << name_of(cycle.status);
    const std::string cell = text_of(watch.judge(cycle));
    if (cell == last) continue;
    if (last != "none") all += ' ';
    all += cell.empty() ? "-" : cell;
    last = cell;
  }
  return all;
}

std::string limits_of(const test::TestLine& line, const DeviceTiming& timing) {
  return limits_of(line.edges(), timing);
}

// The line as an analyser with this sample period sees it.
std::string sampled_limits(test::TestLine line, const DeviceTiming& timing, Picoseconds sample,
                           Picoseconds phase) {
  line.ma = test::sampled(line.ma, sample, phase);
  line.slo = test::sampled(line.slo, sample, phase);
  return limits_of(line.edges(), timing, sample);
}

// From `turn` after the start of each request on, `gain` thousandths of the time pass, and a pause
// comes before.
std::vector<wire::Edge> warped(const test::TestLine& line, Picoseconds turn, std::int64_t gain,
                               Picoseconds pause = {}) {
  std::vector<wire::Edge> edges = line.edges();
  for (wire::Edge& edge : edges) {
    Picoseconds begin{};
    for (const std::size_t first : line.begins) {
      if (line.ma[first].time <= edge.time) begin = line.ma[first].time;
    }
    const Picoseconds late = edge.time - begin - turn;
    if (begin.count == 0 || late.count <= 0) continue;
    edge.time = begin + turn + pause + late * gain / 1000;
  }
  return edges;
}

TEST(Limits, Names_AreSeparated) {
  EXPECT_EQ(text_of(0), "");
  EXPECT_EQ(text_of(set_of(Limit::release)), "release");
  EXPECT_EQ(text_of(static_cast<LimitSet>(set_of(Limit::clock_max) | set_of(Limit::cycle_min))),
            "clock_max;cycle_min");
}

TEST(Limits, ClockAtItsBounds_IsWithinThem) {
  for (const std::int64_t period : {100, 200, 1'000, 4'000}) {
    DeviceTiming timing;
    timing.clock_min = timing.clock_max = rate_of(nanoseconds(period));
    test::Shape shape{.period = nanoseconds(period)};
    shape.extra_clocks = 3;
    EXPECT_EQ(limits_of(line_of(shape, 80 * shape.period, 100 * shape.period), timing), "-");
    shape.period = shape.period * 995 / 1000;
    EXPECT_EQ(limits_of(line_of(shape, 80 * shape.period, 100 * shape.period), timing),
              "clock_max");
    shape.period = nanoseconds(period) * 1005 / 1000;
    EXPECT_EQ(limits_of(line_of(shape, 80 * shape.period, 100 * shape.period), timing),
              "clock_min");
  }
}

TEST(Limits, WithoutADevice_AreThoseOfBissC) {
  const auto at = [](std::int64_t period_ns) {
    const test::Shape shape{.period = nanoseconds(period_ns)};
    return limits_of(line_of(shape, 60 * shape.period, 70 * shape.period), {});
  };
  EXPECT_EQ(at(100), "-");
  EXPECT_EQ(at(95), "clock_max");
  EXPECT_EQ(at(12'500), "-");
  EXPECT_EQ(at(13'000), "clock_min");
}

TEST(Limits, Request_SoonerThanTheDeviceAllows_IsNamedInItsRow) {
  const test::Shape shape{.period = nanoseconds(100), .line_delay = nanoseconds(50)};
  DeviceTiming timing = by_cycle;
  EXPECT_EQ(limits_of(line_of(shape, cycle_time, cycle_time), timing), "-");
  EXPECT_EQ(limits_of(line_of(shape, cycle_time, cycle_time + nanoseconds(200)), timing), "-");
  timing.timeout = {};
  // The first row has none before it.
  EXPECT_EQ(limits_of(line_of(shape, microseconds(28), microseconds(31)), timing), "- cycle_min");
  timing.cycle_min = {};
  EXPECT_EQ(limits_of(line_of(shape, microseconds(28), microseconds(31)), timing), "-");
}

TEST(Limits, SloReleasedByAnotherRule_IsRelease) {
  const test::Shape shape{.period = nanoseconds(100), .line_delay = nanoseconds(50)};
  const auto after = [&](Picoseconds until, const DeviceTiming& timing, int extra_clocks = 0) {
    test::Shape changed = shape;
    changed.extra_clocks = extra_clocks;
    return limits_of(line_of(changed, until, microseconds(60)), timing);
  };
  EXPECT_EQ(after(microseconds(10), by_cycle), "release");
  EXPECT_EQ(after(nanoseconds(31'100), by_cycle), "release");
  EXPECT_EQ(after(cycle_time, by_cycle), "-");
  EXPECT_EQ(after(nanoseconds(31'400), by_cycle), "release");
  EXPECT_EQ(after(microseconds(10), DeviceTiming{}), "-");
  // MA ends 4.05 us after its first edge.
  EXPECT_EQ(after(nanoseconds(4'200), adaptive), "-");
  EXPECT_EQ(after(nanoseconds(4'150), adaptive), "release");
  EXPECT_EQ(after(microseconds(16), fixed), "release");
  EXPECT_EQ(after(microseconds(24), fixed), "-");
  // While the master still sends clocks.
  EXPECT_EQ(after(microseconds(10), by_cycle, 100), "release");
  EXPECT_EQ(after(cycle_time, by_cycle, 100), "-");
}

// At 1 MHz the frame is longer than the time of its cycle: when SLO rises is not known.
TEST(Limits, FrameLongerThanTheTimeOfItsCycle_HasNoRelease) {
  const test::Shape shape{.period = microseconds(1), .ack_clocks = 3};
  for (const std::int64_t until : {42, 50, 70}) {
    EXPECT_EQ(limits_of(line_of(shape, microseconds(until), microseconds(100)), by_cycle), "-");
  }
}

// A pulse in the timeout is not an end of it.
TEST(Limits, PulseAfterTheFrame_IsNoRelease) {
  const test::Shape shape{.period = nanoseconds(100)};
  test::TestLine line = line_of(shape, cycle_time, microseconds(40));
  for (const std::size_t first : line.begins) {
    test::TestLine::add_pulse(line.slo, line.ma[first].time + microseconds(12), nanoseconds(20));
  }
  EXPECT_EQ(limits_of(line, by_cycle), "-");
}

TEST(Limits, ClockThatFallsToTwoThirds_IsAChange) {
  for (const std::int64_t period : {100, 200, 1'000}) {
    const test::Shape shape{.period = nanoseconds(period), .line_delay = nanoseconds(5)};
    const test::TestLine line = line_of(shape, 60 * shape.period, 120 * shape.period);
    DeviceTiming timing{.clock_max = megahertz(20), .clock_constant = true};
    for (const std::int64_t clocks : {3, 20, 36}) {
      // While MA is high, after SLO has changed.
      const Picoseconds turn = clocks * shape.period + shape.period * 3 / 4;
      EXPECT_EQ(limits_of(warped(line, turn, 667), timing), "clock_change");
      EXPECT_EQ(limits_of(warped(line, turn, 1'500), timing), "clock_change");
      EXPECT_EQ(limits_of(warped(line, turn, 1'000, shape.period / 2), timing), "clock_change");
    }
    EXPECT_EQ(limits_of(line, timing), "-");
    timing.clock_constant = false;
    EXPECT_EQ(limits_of(warped(line, 20 * shape.period, 667), timing), "-");
  }
}

// 20 samples a period: no single period shows it for certain.
TEST(Limits, ClockThatChangesInASampledCapture_IsSeenInSeveralPeriods) {
  const test::Shape shape{.period = nanoseconds(200)};
  test::TestLine line = line_of(shape, 60 * shape.period, 120 * shape.period);
  const std::vector<wire::Edge> edges = warped(line, 20 * shape.period, 800);
  line.ma.clear();
  line.slo.clear();
  for (const wire::Edge& edge : edges) {
    (edge.line == 0 ? line.ma : line.slo).push_back({edge.time, edge.level});
  }
  const DeviceTiming timing{.clock_constant = true};
  EXPECT_EQ(sampled_limits(line, timing, nanoseconds(10), nanoseconds(3)), "clock_change");
}

// Jitter, resolution and phase of a capture never report a limit for a value that is exactly at the
// limit.
TEST(Limits, CapturesAtTheBounds_ExceedNone) {
  std::uint64_t seed = 1;
  for (const std::int64_t period : {100, 200, 333, 500}) {
    for (const std::int64_t sample : {0, 1, 2, 5, 10}) {
      for (const int jitter : {0, 1, 3, 6}) {
        DeviceTiming timing = by_cycle;
        timing.clock_min = timing.clock_max = rate_of(nanoseconds(period));
        test::Shape shape{.period = nanoseconds(period), .line_delay = nanoseconds(120)};
        shape.jitter_percent = jitter;
        shape.extra_clocks = static_cast<int>(seed % 4);
        const test::TestLine line = line_of(shape, cycle_time, cycle_time, 30, ++seed);
        SCOPED_TRACE(testing::Message() << period << " ns, sample " << sample << " ns, jitter "
                                        << jitter << " %, seed " << seed);
        if (sample == 0) {
          EXPECT_EQ(limits_of(line, timing), "-");
        } else {
          EXPECT_EQ(sampled_limits(line, timing, nanoseconds(sample), picoseconds(737)), "-");
        }
      }
    }
  }
}

TEST(Limits, CyclesThatAreNoWholeRequest_AreNotCompared) {
  for (const CycleStatus status : {CycleStatus::cut_start, CycleStatus::cut_end,
                                   CycleStatus::ma_glitch, CycleStatus::unknown_level}) {
    LimitWatch watch(by_cycle);
    Cycle cycle;
    cycle.period = nanoseconds(10);
    cycle.rising_edges = 40;
    EXPECT_EQ(text_of(watch.judge(cycle)), "clock_max");
    cycle.status = status;
    cycle.time += microseconds(1);
    EXPECT_EQ(text_of(watch.judge(cycle)), "") << name_of(status);
    cycle.status = CycleStatus::ok;
    cycle.time += microseconds(1);
    const bool pulse = status == CycleStatus::ma_glitch;
    EXPECT_EQ(text_of(watch.judge(cycle)), pulse ? "clock_max;cycle_min" : "clock_max");
  }
}

TEST(Limits, EachKnown_FollowsFromTheDevice) {
  const LimitWatch unknown(DeviceTiming{});
  const LimitWatch all(by_cycle);
  for (std::size_t i = 0; i < limit_count; ++i) {
    const auto limit = static_cast<Limit>(i);
    const bool clock = limit == Limit::clock_max || limit == Limit::clock_min;
    EXPECT_EQ(unknown.knows(limit), clock) << name_of(limit);
    EXPECT_TRUE(all.knows(limit)) << name_of(limit);
  }
}

}  // namespace limits_test
}  // namespace biss::decode
