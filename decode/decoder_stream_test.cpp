// Streams of any length, also empty ones: memory stays bounded, and the decoder resynchronizes.
#include <gtest/gtest.h>

#include <random>

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
