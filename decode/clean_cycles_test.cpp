// The quick way gives the cycles that reading edge by edge gives, whatever is on the line and
// however it is cut into runs.
#include "decode/clean_cycles.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <random>
#include <span>
#include <string>

#include "decode/run_join.hpp"
#include "decode/test_cycle_text.hpp"
#include "decode/test_line.hpp"

namespace biss::decode::test {
namespace clean_cycles_test {

struct Reading {
  /// The format of the frames on the line.
  std::string format;
  DeviceTiming timing;
  MarginSetup margin;
  /// The reader is not given it.
  bool format_unknown = false;

  std::optional<FrameFormat> known() const {
    return format_unknown ? std::nullopt : std::optional(*parse_format(format));
  }
};

std::vector<std::string> edge_by_edge(const std::vector<wire::Edge>& edges, Picoseconds end,
                                      const Reading& setup) {
  std::vector<std::string> rows;
  Decoder decoder(CycleReader(setup.known(), setup.timing, setup.margin),
                  [&](const Cycle& cycle) { rows.push_back(text_of(cycle)); });
  decoder.push(edges, {0, 1});
  decoder.finish(end);
  return rows;
}

struct Quick {
  std::vector<std::string> rows;
  std::size_t clean = 0;
};

// In runs of about that many edges, joined or each alone; of the joined ones, some as edges.
Quick quickly(const std::vector<wire::Edge>& edges, Picoseconds end, const Reading& setup,
              std::size_t run_edges, std::mt19937_64& random) {
  Quick quick;
  Decoder decoder(CycleReader(setup.known(), setup.timing, setup.margin),
                  [&](const Cycle& cycle) { quick.rows.push_back(text_of(cycle)); });
  CleanCycleFinder finder(setup.known(), setup.timing, setup.margin);
  std::vector<CleanCycle> clean;
  RunJoin join(finder, decoder);
  const bool joins = random() % 2 == 0;
  std::array<std::optional<bool>, 2> level{};
  for (std::size_t at = 0; at < edges.size();) {
    const std::size_t end_at = std::min(edges.size(), at + 1 + random() % (2 * run_edges));
    if (joins && random() % 4 == 0) {
      // A piece that is not regular: the source gives it as edges.
      const auto piece = std::span(edges).subspan(at, end_at - at);
      join.push(piece, {0, 1});
      for (const wire::Edge& edge : piece) level[edge.line] = edge.level == wire::Level::high;
      at = end_at;
      continue;
    }
    std::array<std::vector<std::int64_t>, 2> times;
    std::array<bool, 2> first{};
    // Some sources say at the beginning of a piece what the level is.
    const bool repeats = random() % 2 == 0;
    for (std::size_t line = 0; repeats && line < 2; ++line) {
      if (!level[line]) continue;
      times[line].push_back(edges[at].time.count);
      first[line] = *level[line];
    }
    for (; at < end_at; ++at) {
      const wire::Edge& edge = edges[at];
      if (times[edge.line].empty()) first[edge.line] = edge.level == wire::Level::high;
      times[edge.line].push_back(edge.time.count);
      level[edge.line] = edge.level == wire::Level::high;
    }
    const PairRun run{{times[0], first[0]}, {times[1], first[1]}};
    finder.find(run, clean);
    quick.clean += clean.size();
    if (joins) {
      join.push(run, clean);
    } else {
      decoder.push(run, clean);
    }
  }
  join.flush();
  decoder.finish(end);
  return quick;
}

// Compares with the edge path. Returns how many cycles took the quick path.
std::size_t expect_same(const std::vector<wire::Edge>& edges, Picoseconds end, const Reading& setup,
                        std::mt19937_64& random) {
  const auto expected = edge_by_edge(edges, end, setup);
  std::size_t clean = 0;
  for (const std::size_t run_edges : {std::size_t{1'000'000}, std::size_t{700}, std::size_t{20}}) {
    const Quick quick = quickly(edges, end, setup, run_edges, random);
    EXPECT_EQ(quick.rows.size(), expected.size());
    for (std::size_t i = 0; i < std::min(quick.rows.size(), expected.size()); ++i) {
      EXPECT_EQ(quick.rows[i], expected[i]) << "row " << i << ", runs of " << run_edges;
      if (quick.rows[i] != expected[i]) break;
    }
    if (run_edges == 1'000'000) clean = quick.clean;
  }
  return clean;
}

Shape random_shape(std::mt19937_64& random) {
  Shape shape;
  const auto among = [&](std::int64_t least, std::int64_t most) {
    return least +
           static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(most - least + 1));
  };
  shape.period = nanoseconds(among(95, 1900));
  shape.high_percent = static_cast<int>(among(35, 65));
  shape.line_delay = nanoseconds(among(0, 700));
  shape.timeout = nanoseconds(among(300, 30'000));
  shape.gap = nanoseconds(among(20, 60'000));
  shape.extra_clocks = static_cast<int>(among(-1, 6));
  shape.ack_clocks = static_cast<std::uint16_t>(among(1, 40));
  shape.ending = static_cast<Ending>(among(0, 2));
  shape.jitter_percent = random() % 2 == 0 ? 0 : static_cast<int>(among(1, 12));
  return shape;
}

void damage(TestLine& line, const Shape& shape, std::mt19937_64& random) {
  for (int i = 0; i < 6; ++i) {
    auto& hit = random() % 2 == 0 ? line.ma : line.slo;
    const auto at = static_cast<std::int64_t>(
        random() % static_cast<std::uint64_t>(line.last_time().count - 50'000'000));
    const auto width = static_cast<std::int64_t>(
        1 + random() % static_cast<std::uint64_t>(2 * shape.period.count));
    TestLine::add_pulse(hit, picoseconds(50'000'000 + at), picoseconds(width));
  }
}

TEST(CleanCycles, RandomLines_SameRowsAsEdgeByEdge) {
  constexpr std::uint64_t seed = 13'001;
  const std::vector<std::string> formats{"pos26,nE,nW,crc6", "pos32,nE,nW,crc6", "pos18,crc5",
                                         "mt12,st24,nE,nW,crc6",
                                         "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0"};
  std::size_t clean = 0;
  std::size_t cycles = 0;
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    SCOPED_TRACE(fmt::format("seed {}, trial {}", seed, trial));
    std::mt19937_64 random(seed + trial);
    Reading setup{.format = formats[random() % formats.size()], .timing = {}, .margin = {}};
    setup.timing.clock_constant = random() % 3 == 0;
    setup.format_unknown = random() % 4 == 0;
    TestLine line(trial);
    const Shape shape = random_shape(random);
    for (int i = 0; i < 20; ++i) {
      line.request(random() % 4 == 0 ? random_shape(random) : shape, random(), setup.format);
    }
    const bool damaged = trial % 3 == 0;
    if (damaged) damage(line, shape, random);
    const bool coarse = trial % 2 == 0;
    const Picoseconds end = line.last_time() + milliseconds(1);
    if (coarse) {
      const Picoseconds sample = shape.period / static_cast<std::int64_t>(4 + random() % 20);
      setup.margin.resolution = sample;
      setup.margin.signal = random() % 2 == 0;
      line.ma = sampled(line.ma, sample);
      line.slo = sampled(line.slo, sample);
    }
    clean += expect_same(line.edges(), end, setup, random);
    cycles += 20;
    if (HasFailure()) return;
  }
  // The test compares two ways only if the quick one is taken.
  EXPECT_GT(clean * 2, cycles) << clean << " of " << cycles;
}

TEST(CleanCycles, GoodLine_NearlyAllAreClean) {
  std::mt19937_64 random(13'002);
  TestLine line;
  for (std::uint64_t i = 0; i < 200; ++i) line.request({.period = nanoseconds(100)}, random());
  const std::size_t clean =
      expect_same(line.edges(), line.last_time() + milliseconds(1),
                  {.format = "pos26,nE,nW,crc6", .timing = {}, .margin = {}}, random);
  // The first one has nothing before it, the last one no request after it.
  EXPECT_GE(clean, 198U);
}

TEST(CleanCycles, JitterAsInTheSamplesOfAnAnalyser_NearlyAllAreClean) {
  std::mt19937_64 random(13'003);
  TestLine line;
  for (std::uint64_t i = 0; i < 500; ++i) {
    line.request({.period = picoseconds(101'730),
                  .line_delay = nanoseconds(static_cast<std::int64_t>(60 + random() % 100)),
                  .jitter_percent = 3},
                 random());
  }
  line.ma = sampled(line.ma, nanoseconds(10));
  line.slo = sampled(line.slo, nanoseconds(10));
  const Reading setup{
      .format = "pos26,nE,nW,crc6", .timing = {}, .margin = {.resolution = nanoseconds(10)}};
  const std::size_t clean =
      expect_same(line.edges(), line.last_time() + milliseconds(1), setup, random);
  EXPECT_GE(clean, 480U);
}

// The first levels have vectors, the last one has none.
TEST(CleanCycles, EachSimdLevel_SameRowsAndAsManyClean) {
  const std::int64_t processor = hwy::SupportedTargets();
  for (const bool coarse : {false, true}) {
    std::optional<std::size_t> expected;
    for (const std::int64_t level : {HWY_AVX3, HWY_AVX2, HWY_STATIC_TARGET}) {
      if ((processor & level) == 0 && level != HWY_STATIC_TARGET) continue;
      SCOPED_TRACE(fmt::format("SIMD level {}, {}", level, coarse ? "samples" : "changes"));
      hwy::SetSupportedTargetsForTest(level | HWY_STATIC_TARGET);
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      std::mt19937_64 random(13'006);
      TestLine line;
      Reading setup{.format = "pos32,nE,nW,crc6", .timing = {}, .margin = {}};
      setup.timing.clock_constant = true;
      for (int i = 0; i < 200; ++i) {
        Shape shape = random_shape(random);
        shape.ack_clocks = static_cast<std::uint16_t>(1 + random() % 180);
        line.request(shape, random(), setup.format);
      }
      if (coarse) {
        setup.margin.resolution = nanoseconds(20);
        line.ma = sampled(line.ma, nanoseconds(20));
        line.slo = sampled(line.slo, nanoseconds(20));
      }
      const std::size_t clean =
          expect_same(line.edges(), line.last_time() + milliseconds(1), setup, random);
      if (!expected) expected = clean;
      EXPECT_EQ(clean, *expected);
      EXPECT_GT(clean, 50U);
    }
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

// One gap of MA a little longer than the others, in which the encoder went idle: two requests.
TEST(CleanCycles, RequestBehindAShortPause_IsNotReadIntoTheOneBefore) {
  std::mt19937_64 random(13'004);
  for (const std::int64_t pause_ns : {620, 700, 800, 1'000, 1'220}) {
    SCOPED_TRACE(pause_ns);
    TestLine line;
    for (int i = 0; i < 10; ++i) {
      line.request({.timeout = nanoseconds(510), .gap = nanoseconds(pause_ns - 610)}, random());
      line.request({}, random());
    }
    const Reading setup{.format = "pos26,nE,nW,crc6", .timing = {}, .margin = {}};
    expect_same(line.edges(), line.last_time() + milliseconds(1), setup, random);
  }
}

// SLO falls at the very time at which the second request begins: that fall is part of it.
TEST(CleanCycles, SloFallsAsTheRequestBehindAShortPauseBegins_IsNotReadIntoTheOneBefore) {
  std::mt19937_64 random(13'007);
  const Reading setup{
      .format = "pos26,nE,nW,crc6", .timing = {}, .margin = {}, .format_unknown = true};
  for (const std::int64_t pause_ns : {560, 600, 640, 700}) {
    SCOPED_TRACE(fmt::format("pause {} ns", pause_ns));
    TestLine line;
    for (int i = 0; i < 10; ++i) {
      line.request({.timeout = nanoseconds(pause_ns - 200), .gap = nanoseconds(100)}, random());
      const Picoseconds begin = line.request({}, random());
      TestLine::add_pulse(line.slo, begin, nanoseconds(30));
    }
    const Picoseconds end = line.last_time() + milliseconds(1);
    EXPECT_EQ(edge_by_edge(line.edges(), end, setup).size(), 20U);
    expect_same(line.edges(), end, setup, random);
  }
}

// Each edge of MA before a change of SLO at the same time, as a file of samples delivers them.
std::vector<wire::Edge> ma_first(const TestLine& line) {
  std::vector<wire::Edge> edges = line.edges();
  std::stable_sort(edges.begin(), edges.end(), [](const wire::Edge& a, const wire::Edge& b) {
    return a.time != b.time ? a.time < b.time : a.line < b.line;
  });
  return edges;
}

// SLO falls just before a request and rises at the very time at which it begins: that rise is part of
// the request, and no pulse ends in the one before, whichever edge a capture delivers first.
TEST(CleanCycles, SloRisesAsTheNextRequestBegins_EndsNoPulseOfTheOneBefore) {
  std::mt19937_64 random(13'009);
  TestLine line;
  for (int i = 0; i < 10; ++i) {
    const Picoseconds begin = line.request({}, random());
    TestLine::add_pulse(line.slo, begin - nanoseconds(30), nanoseconds(30));
  }
  const Picoseconds end = line.last_time() + milliseconds(1);
  const Reading setup{.format = "pos26,nE,nW,crc6", .timing = {}, .margin = {.signal = true}};
  for (const auto& edges : {line.edges(), ma_first(line)}) {
    for (const Cycle& cycle : decode(edges, end, setup.format, {}, setup.margin)) {
      EXPECT_EQ(cycle.signal.value().slo_pulses, 0U);
    }
    expect_same(edges, end, setup, random);
  }
}

// The next request comes within the line delay of the last bits. A change of SLO at the very time at
// which it begins counts for none of LineSignal::Changes of the request before.
TEST(CleanCycles, SloChangesAsAnEarlyRequestBegins_IsNoChangeOfTheOneBefore) {
  std::mt19937_64 random(13'010);
  const Reading setup{.format = "pos26,nE,nW,crc6", .timing = {}, .margin = {.signal = true}};
  TestLine line;
  const Picoseconds late = nanoseconds(40);
  for (int i = 0; i < 10; ++i) {
    line.request({.line_delay = microseconds(3)}, random());
    const Picoseconds last_edge = line.ma.back().time;
    auto change = line.slo.begin();
    while (change->time < last_edge + nanoseconds(1'500)) ++change;
    change->time += late;
    line.now = change->time;
    line.slo.erase(change + 1, line.slo.end());
    if (line.slo.back().level == wire::Level::low) line.slo.pop_back();
    line.request({}, random());
  }
  const Picoseconds end = line.last_time() + milliseconds(1);
  for (const auto& edges : {line.edges(), ma_first(line)}) {
    for (const Cycle& cycle : decode(edges, end, setup.format, {}, setup.margin)) {
      if (!cycle.signal || !cycle.signal->changes) continue;
      EXPECT_LT(cycle.signal->changes->latest, microseconds(3) + late);
    }
    expect_same(edges, end, setup, random);
  }
}

// Moves the edges before `begin` to 104 days before zero, and the rest to `more` later.
void move_apart(TestLine& line, Picoseconds begin, std::uint64_t more) {
  for (auto* const changes : {&line.ma, &line.slo}) {
    for (LevelChange& change : *changes) {
      std::uint64_t time =
          static_cast<std::uint64_t>(change.time.count) - std::uint64_t{9'000'000'000'000'000'000};
      if (change.time >= begin) time += more;
      change.time = Picoseconds{static_cast<std::int64_t>(time)};
    }
  }
}

// Captures may have times up to 106 days before and after zero: their distance has more than 63 bits.
TEST(CleanCycles, RequestsFarApart_SameRowsAsEdgeByEdge) {
  std::mt19937_64 random(13'008);
  for (const std::uint64_t seen_us : {19U, 17U, 14U}) {
    TestLine line;
    for (int i = 0; i < 40; ++i) line.request({.period = nanoseconds(400)}, random());
    const std::size_t later = line.begins[20];
    const Picoseconds begin = line.ma[later].time;
    // From the last edge before to the next request: its lower 32 bits alone are a time before SLO is
    // released.
    const std::uint64_t gap = (std::uint64_t{4'190'000'000} << 32U) + seen_us * 1'000'000U;
    const std::uint64_t more =
        gap - static_cast<std::uint64_t>((begin - line.ma[later - 1].time).count);
    move_apart(line, begin, more);
    const Reading setup{.format = "pos26,nE,nW,crc6", .timing = {}, .margin = {}};
    expect_same(line.edges(), line.last_time() + milliseconds(1), setup, random);
  }
}

// The last request before the long time has a wrong checksum: it may wait for the one after it.
TEST(CleanCycles, WrongFrameLongBeforeTheNextRequest_SameRowsAsEdgeByEdge) {
  std::mt19937_64 random(13'011);
  TestLine line;
  for (int i = 0; i < 20; ++i) line.request({}, random());
  TestLine::add_pulse(line.slo, line.ma[line.begins[9] + 30].time, nanoseconds(1'000));
  move_apart(line, line.ma[line.begins[10]].time, std::uint64_t{18'000'000'000'000'000'000U});
  const Reading setup{.format = "pos26,nE,nW,crc6", .timing = {}, .margin = {}};
  const Picoseconds end = line.last_time() + milliseconds(1);
  EXPECT_EQ(edge_by_edge(line.edges(), end, setup).size(), 20U);
  expect_same(line.edges(), end, setup, random);
}

// SLO changes once more, long after a clean request and just before the next one.
TEST(CleanCycles, SloChangesLongAfterARequest_SameSignalAsEdgeByEdge) {
  std::mt19937_64 random(13'012);
  TestLine line;
  for (int i = 0; i < 20; ++i) {
    const Picoseconds begin = line.request({}, random());
    TestLine::add_pulse(line.slo, begin - nanoseconds(1'500), nanoseconds(1'000));
  }
  move_apart(line, line.ma[line.begins[10]].time - nanoseconds(2'000),
             std::uint64_t{18'000'000'000'000'000'000U});
  const Reading setup{.format = "pos26,nE,nW,crc6", .timing = {}, .margin = {.signal = true}};
  const Picoseconds end = line.last_time() + milliseconds(1);
  EXPECT_GE(expect_same(line.edges(), end, setup, random), 18U);
}

// Whether a frame without STOP waits for its clock depends on the request just before it, also if
// that request is read edge by edge in the same run: here it has more clocks than its predecessor.
TEST(CleanCycles, PauseBeforeStopAfterALongerRequest_SameRowsAsEdgeByEdge) {
  std::mt19937_64 random(13'013);
  const Reading setup{.format = "pos26,nE,nW,crc6", .timing = {}, .margin = {.signal = true}};
  TestLine line;
  for (int i = 0; i < 10; ++i) {
    line.request({.ack_clocks = 1}, random());
    const Picoseconds begin = line.request({.ack_clocks = 13}, random());
    TestLine::add_pulse(line.slo, begin + nanoseconds(200), nanoseconds(30));
    const auto stop = static_cast<std::int64_t>(bits_of(setup.format, 0, 13).size_bits()) - 1;
    line.request({.ack_clocks = 13, .pauses = {stop}, .pause = microseconds(10)}, random());
  }
  const Picoseconds end = line.last_time() + milliseconds(1);
  EXPECT_EQ(edge_by_edge(line.edges(), end, setup).size(), 30U);
  std::size_t clean = 0;
  for (int trial = 0; trial < 4; ++trial) clean += expect_same(line.edges(), end, setup, random);
  EXPECT_GT(clean, 0U);
}

// If both lines jitter, the sampling point is found by an even clock, and `marginal` shows it.
TEST(CleanCycles, JitterOfBothLines_SameSamplingPoints) {
  std::mt19937_64 random(13'005);
  std::size_t clean = 0;
  for (int trial = 0; trial < 20; ++trial) {
    TestLine line(static_cast<std::uint64_t>(trial));
    for (int i = 0; i < 40; ++i) {
      line.request({.period = nanoseconds(100), .jitter_percent = 7}, random());
    }
    // Up to 32 % of a period either way, more than a sample may be away from the middle.
    for (std::size_t i = 1; i < line.slo.size(); ++i) {
      line.slo[i].time += picoseconds(static_cast<std::int64_t>(random() % 64'000) - 32'000);
    }
    const Reading setup{.format = "pos26,nE,nW,crc6", .timing = {}, .margin = {}};
    clean += expect_same(line.edges(), line.last_time() + milliseconds(1), setup, random);
  }
  EXPECT_GT(clean, 100U);
}

}  // namespace clean_cycles_test
}  // namespace biss::decode::test
