// Streams of any length, also empty ones: memory stays bounded, and the decoder resynchronizes.
#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <random>
#include <string>
#include <vector>

#include "decode/test_cycle_text.hpp"
#include "decode/test_line.hpp"

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

// The rows of a line whose edges at one time come with MA first, or with SLO first.
std::vector<std::string> rows_of(const TestLine& line, bool ma_first) {
  std::vector<wire::Edge> edges = line.edges();
  std::stable_sort(edges.begin(), edges.end(), [&](const wire::Edge& a, const wire::Edge& b) {
    return a.time != b.time ? a.time < b.time : ma_first && a.line < b.line;
  });
  std::vector<std::string> rows;
  for (const Cycle& cycle : decode(edges, line.last_time() + milliseconds(1))) {
    rows.push_back(text_of(cycle));
  }
  return rows;
}

// Where the clock of the next request is needed to see that one is over, SLO has already answered.
TEST(DecoderStream, SloOfTheNextRequest_DoesNotMoveTheSamplesOfThisOne) {
  constexpr Picoseconds sample = picoseconds(8'328);
  TestLine line;
  const auto put = [&](std::vector<LevelChange>& to, std::initializer_list<int> samples) {
    for (const int at : samples) {
      const bool high = to.back().level == wire::Level::high;
      to.push_back({microseconds(50) + at * sample, high ? wire::Level::low : wire::Level::high});
    }
  };
  put(line.ma, {0, 1, 2, 4, 5, 6, 7, 9, 10, 14, 15, 16, 17, 21, 22, 26, 27, 28, 29, 33});
  put(line.slo, {1, 4, 12, 14, 16});
  EXPECT_EQ(rows_of(line, true), rows_of(line, false));
}

TEST(DecoderStream, EdgesAtOneTime_TheirOrderDoesNotMatter) {
  constexpr std::uint64_t seed = 13'013;
  SCOPED_TRACE(seed);
  std::mt19937_64 random(seed);
  const auto any_time = [&](std::int64_t most) {
    return nanoseconds(static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(most)));
  };
  for (int i = 0; i < 300; ++i) {
    TestLine line(random());
    Shape shape;
    shape.period = nanoseconds(20) + any_time(100);
    for (int k = 0; k < 6; ++k) {
      shape.line_delay = any_time(200);
      shape.timeout = any_time(400);
      shape.gap = nanoseconds(10) + any_time(200);
      shape.jitter_percent = static_cast<int>(random() % 16);
      line.request(shape, random() % 1'000'000);
    }
    line.ma = sampled(line.ma, shape.period / 4);
    line.slo = sampled(line.slo, shape.period / 4);
    const auto earlier = [](const LevelChange& a, const LevelChange& b) { return a.time < b.time; };
    std::stable_sort(line.slo.begin(), line.slo.end(), earlier);
    std::stable_sort(line.ma.begin(), line.ma.end(), earlier);
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
  for (int i = 0; i < 1'000'000; ++i) {
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
  EXPECT_GT(rows, 1000U);
}

}  // namespace decoder_stream_test
}  // namespace biss::decode::test
