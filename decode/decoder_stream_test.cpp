// Streams of any length, also empty ones: memory stays bounded, and the decoder resynchronizes.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "decode/test_cycle_text.hpp"
#include "decode/test_line.hpp"
#include "tests/common/long_run.hpp"

namespace biss::decode::test {
namespace decoder_stream_test {

TEST(DecoderStream, FreeRunningClock_IsOneRowInBoundedMemory) {
  std::vector<Cycle> cycles;
  Decoder decoder(CycleReader(parse_format(usual_format).value(), {}),
                  [&](const Cycle& cycle) { cycles.push_back(cycle); });
  decoder.push_ma(high_at({}));
  decoder.push_slo(high_at({}));
  Picoseconds now = microseconds(20);
  for (int i = 0; i < 1'000'000; ++i) {
    decoder.push_ma(i % 2 == 0 ? low_at(now) : high_at(now));
    // SLO moves too, more often than any history holds.
    decoder.push_slo(i % 2 == 0 ? high_at(now) : low_at(now));
    now += nanoseconds(500);
  }
  // A request follows.
  TestLine line;
  line.now = now + milliseconds(1);
  decoder.push_slo(high_at(now));
  line.request({}, 99);
  auto edges = line.edges();
  edges.erase(edges.begin(), edges.begin() + 2);
  decoder.push(edges, {0, 1});
  decoder.finish(line.last_time() + milliseconds(1));
  ASSERT_EQ(cycles.size(), 2U);
  EXPECT_NE(name_of(cycles[0].status), "ok");
  ASSERT_EQ(name_of(cycles[1].status), "ok");
  EXPECT_EQ(cycles[1].frame->channel_list[0].position, 99U);
}

TEST(DecoderStream, SloMovesWhileMaRests_NextRequestIsRight) {
  TestLine line;
  Picoseconds now = nanoseconds(100);
  for (int i = 0; i < 200'000; ++i) {
    line.slo.push_back(i % 2 == 0 ? low_at(now) : high_at(now));
    now += nanoseconds(10);
  }
  line.now = now + microseconds(10);
  line.request({}, 5);
  const auto cycles = decode(line);
  ASSERT_EQ(cycles.size(), 1U);
  EXPECT_EQ(name_of(cycles[0].status), "ok");
}

// The rows of a line whose edges with the same time come with MA first, or with SLO first.
std::vector<std::string> rows_of(const TestLine& line, bool ma_first) {
  std::vector<wire::Edge> edges = line.edges();
  std::stable_sort(edges.begin(), edges.end(), [&](const wire::Edge& a, const wire::Edge& b) {
    if (a.time != b.time) return a.time < b.time;
    return ma_first ? a.line < b.line : b.line < a.line;
  });
  std::vector<std::string> rows;
  for (const Cycle& cycle : decode(edges, line.last_time() + milliseconds(1))) {
    rows.push_back(text_of(cycle));
  }
  return rows;
}

// Both lines change at these multiples of 10 ns.
TestLine sampled_line(const std::vector<int>& ma, const std::vector<int>& slo) {
  TestLine line;
  const auto put = [](std::vector<LevelChange>& to, const std::vector<int>& samples) {
    for (const int at : samples) {
      const bool high = to.back().level == wire::Level::high;
      to.push_back(
          {microseconds(50) + at * nanoseconds(10), high ? wire::Level::low : wire::Level::high});
    }
  };
  put(line.ma, ma);
  put(line.slo, slo);
  return line;
}

// If the end of a request shows only by the clock of the next one, SLO has already changed.
TEST(DecoderStream, SloOfTheNextRequest_DoesNotMoveTheSamplesOfThisOne) {
  const TestLine line = sampled_line(
      {0,  3,  6,  9,  12, 15, 18, 21, 24, 27, 30, 33, 38, 41,  44,  47,  50,  53,  56,
       59, 62, 65, 68, 71, 74, 76, 79, 84, 87, 91, 95, 98, 101, 104, 107, 110, 113, 116},
      {9, 36, 38, 40, 41, 44, 95, 122});
  EXPECT_EQ(rows_of(line, true), rows_of(line, false));
}

// Requests with uneven clocks, close to one another, and SLO that changes anywhere, mostly with MA.
TEST(DecoderStream, EdgesAtOneTime_TheirOrderDoesNotMatter) {
  constexpr unsigned seed = 13'013;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  const auto below = [&](int most) {
    return static_cast<int>(random() % static_cast<unsigned>(most));
  };
  const std::uint64_t lines = biss::test::rounds(20'000, 1'000);
  for (std::uint64_t i = 0; i < lines; ++i) {
    std::vector<int> ma;
    std::vector<int> slo;
    const int half = 2 + below(3);
    int time = 0;
    for (int requests = 1 + below(3); requests != 0; --requests) {
      for (int edges = 8 + 2 * below(12); edges != 0; --edges) {
        ma.push_back(time);
        time += std::max(1, half + (below(8) == 0 ? below(4) - 1 : 0));
      }
      time += below((below(2) == 0 ? 2 : 8) * half);
    }
    for (int changes = time / (4 * half); changes != 0; --changes) {
      slo.push_back(below(3) == 0 ? below(time) : ma[random() % ma.size()]);
    }
    std::sort(slo.begin(), slo.end());
    slo.erase(std::unique(slo.begin(), slo.end()), slo.end());
    const TestLine line = sampled_line(ma, slo);
    ASSERT_EQ(rows_of(line, true), rows_of(line, false)) << i;
  }
}

TEST(DecoderStream, RandomEdges_GiveRowsInOrderAndEndIsFound) {
  constexpr std::uint64_t seed = 20'240'521;
  SCOPED_TRACE(seed);
  std::mt19937_64 random(seed);
  std::size_t rows = 0;
  Picoseconds last{INT64_MIN};
  Decoder decoder(CycleReader(parse_format(usual_format).value(), {}), [&](const Cycle& cycle) {
    ++rows;
    EXPECT_GE(cycle.time, last);
    last = cycle.time;
  });
  Picoseconds now{};
  const std::uint64_t edges = biss::test::rounds(1'000'000, 100'000);
  for (std::uint64_t i = 0; i < edges; ++i) {
    // Idle and busy periods of many lengths.
    now += picoseconds(static_cast<std::int64_t>(random() >> (40U + random() % 24U)));
    const auto level = random() % 64 == 0  ? wire::Level::unknown
                       : random() % 2 == 0 ? wire::Level::low
                                           : wire::Level::high;
    if (random() % 2 == 0) {
      decoder.push_ma({now, level});
    } else {
      decoder.push_slo({now, level});
    }
  }
  decoder.finish(now);
  EXPECT_GT(rows, edges / 1'000);
}

}  // namespace decoder_stream_test
}  // namespace biss::decode::test
