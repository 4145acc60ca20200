#include "decode/cycle_edges.hpp"

#include <gtest/gtest.h>

#include "decode/test_line.hpp"

namespace biss::decode {
namespace cycle_edges_test {

using test::Shape;
using test::TestLine;

CycleReader usual_reader() { return CycleReader(*parse_format(test::usual_format), {}); }

TEST(CycleEdges, EachCycle_HasItsOwnEdgesAndReadsAgainTheSame) {
  TestLine line;
  std::vector<Picoseconds> begins;
  for (std::uint64_t i = 0; i < 30; ++i) begins.push_back(line.request(Shape(), i * 1'000'003));
  std::size_t cycles = 0;
  CycleReader again = usual_reader();
  CycleEdgeReader reader(usual_reader(), {.ma = 0, .slo = 1}, [&](const CycleEdges& edges) {
    ASSERT_LT(edges.number, begins.size());
    EXPECT_EQ(edges.number, cycles++);
    EXPECT_EQ(edges.cycle.time, begins[edges.number]);
    EXPECT_EQ(edges.ma.front().time, begins[edges.number]);
    EXPECT_EQ(edges.ma.size(), 2U * edges.cycle.rising_edges);
    EXPECT_TRUE(edges.ma_after.empty());
    EXPECT_EQ(edges.slo_before, wire::Level::high);
    for (const LevelChange& change : edges.slo) {
      EXPECT_GE(change.time, begins[edges.number]);
      EXPECT_LT(change.time, edges.limit);
    }
    const Cycle same = read_again(edges, again).cycle;
    EXPECT_EQ(same.status, edges.cycle.status);
    EXPECT_EQ(same.line_delay, edges.cycle.line_delay);
    ASSERT_TRUE(same.frame && edges.cycle.frame);
    EXPECT_EQ(same.frame->channel_list, edges.cycle.frame->channel_list);
    EXPECT_EQ(again.sample_times().size(), edges.cycle.rising_edges);
    EXPECT_EQ(read_again(edges, again, true).cycle.status, CycleStatus::not_ready);
    EXPECT_TRUE(again.sample_times().empty());
  });
  reader.push(line.edges());
  reader.finish(line.last_time() + milliseconds(1));
  EXPECT_EQ(cycles, begins.size());
}

TEST(CycleEdges, PulseAfterTheFrame_BelongsToTheCycleBeforeIt) {
  TestLine line;
  const Picoseconds begin = line.request(Shape(), 1);
  const Picoseconds idle = line.ma.back().time + microseconds(8);
  line.request(Shape(), 2);
  TestLine::add_pulse(line.slo, idle + microseconds(13), nanoseconds(30));
  std::vector<std::size_t> changes;
  CycleEdgeReader reader(usual_reader(), {.ma = 0, .slo = 1}, [&](const CycleEdges& edges) {
    if (edges.cycle.time != begin) return;
    for (const LevelChange& change : edges.slo) {
      if (change.time >= idle + microseconds(13)) changes.push_back(edges.number);
    }
  });
  reader.push(line.edges());
  reader.finish(line.last_time() + milliseconds(1));
  EXPECT_EQ(changes.size(), 2U);
}

TEST(CycleEdges, MoreEdgesThanAreKept_LoseTheOldestOnes) {
  std::vector<wire::Edge> edges{{{}, 0, wire::Level::high}, {{}, 1, wire::Level::high}};
  TestLine line;
  line.request(Shape(), 5);
  for (const LevelChange& change : line.ma) edges.push_back({change.time, 0, change.level});
  Picoseconds now = line.last_time() + microseconds(100);
  for (std::size_t i = 0; i < 3 * CycleEdgeReader::max_edges; ++i) {
    now += nanoseconds(100);
    edges.push_back({now, 1, i % 2 == 0 ? wire::Level::low : wire::Level::high});
  }
  std::size_t cycles = 0;
  CycleEdgeReader reader(usual_reader(), {.ma = 0, .slo = 1}, [&](const CycleEdges& each) {
    ++cycles;
    EXPECT_LE(each.slo.size(), CycleEdgeReader::max_edges);
  });
  reader.push(edges);
  reader.finish(now + milliseconds(1));
  EXPECT_EQ(cycles, 1U);
}

}  // namespace cycle_edges_test
}  // namespace biss::decode
