#include "capture/merge.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "capture/sampled_csv.hpp"
#include "capture/samples.hpp"
#include "capture/test_capture.hpp"

namespace biss::capture {
namespace merge_test {

using testing::ElementsAre;

std::unique_ptr<MergedSource> merge(std::string_view first, std::string_view second) {
  std::vector<NamedSource> sources;
  sources.push_back({*open_event_csv(memory_bytes(first)), "a.csv"});
  sources.push_back({*open_event_csv(memory_bytes(second)), "b.csv"});
  return std::make_unique<MergedSource>(std::move(sources));
}

TEST(Merge, TwoSources_ComeInTheOrderOfTime) {
  const Read read = read_all(merge("time_ps,MA\n0,1\n5,0\n9,1\n", "time_ps,SLO\n-2,1\n5,0\n7,1\n"));
  EXPECT_THAT(read.lines, ElementsAre("a.csv:MA", "b.csv:SLO"));
  EXPECT_THAT(read.edges, ElementsAre(edge(-2, 1, '1'), edge(0, 0, '1'), edge(5, 0, '0'),
                                      edge(5, 1, '0'), edge(7, 1, '1'), edge(9, 0, '1')));
  EXPECT_EQ(read.end_time, picoseconds(9));
}

TEST(Merge, Names_BeginWithTheirSource) {
  EXPECT_THAT(merge("time_ps,MA,SLO\n", "time_ps,SLO,X\n")->lines(),
              ElementsAre("a.csv:MA", "a.csv:SLO", "b.csv:SLO", "b.csv:X"));
}

TEST(Merge, SamplePeriod_IsTheLongest) {
  const auto raw = [](Hertz rate) {
    return *open_raw(memory_bytes("\x01"), {rate, 1, {{"D0", 0}}});
  };
  std::vector<NamedSource> sources;
  sources.push_back({raw(megahertz(50)), "a.bin"});
  sources.push_back({raw(megahertz(20)), "b.bin"});
  sources.push_back({*open_event_csv(memory_bytes("time_ps,MA\n0,1\n")), "c.csv"});
  EXPECT_EQ(MergedSource(std::move(sources)).sample_period(), nanoseconds(50));
  EXPECT_EQ(merge("time_ps,MA\n", "time_ps,SLO\n")->sample_period(), Picoseconds{});
}

TEST(Merge, ManyEdges_ComeInBoundedBlocks) {
  std::string first = "time_ps,MA\n";
  std::string second = "time_ps,SLO\n";
  for (int i = 0; i < 30'000; ++i) {
    first += std::to_string(2 * i) + (i % 2 == 0 ? ",0\n" : ",1\n");
    second += std::to_string(3 * i) + (i % 2 == 0 ? ",0\n" : ",1\n");
  }
  const auto merged = merge(first, second);
  std::size_t count = 0;
  Picoseconds last;
  for (;;) {
    const auto block = merged->next_block();
    ASSERT_TRUE(block.ok());
    if (block->empty()) break;
    EXPECT_LE(block->size(), 8'192U);
    for (const wire::Edge& one : *block) {
      EXPECT_GE(one.time, last);
      last = one.time;
    }
    count += block->size();
  }
  EXPECT_EQ(count, 60'000U);
}

TEST(Merge, SourceThatFails_NamesItAfterTheEdgesBefore) {
  const auto merged = merge("time_ps,MA\n0,1\n5,0\n9,1\n", "time_ps,SLO\n1,1\n6,0\noops\n");
  const auto block = merged->next_block();
  ASSERT_TRUE(block.ok());
  EXPECT_THAT(std::vector(block->begin(), block->end()),
              ElementsAre(edge(0, 0, '1'), edge(1, 1, '1'), edge(5, 0, '0'), edge(6, 1, '0')));
  for (int i = 0; i < 2; ++i) {
    const auto failed = merged->next_block();
    ASSERT_FALSE(failed.ok());
    EXPECT_EQ(failed.error().cause, CaptureCause::malformed);
    EXPECT_EQ(failed.error().line, 4U);
    EXPECT_EQ(merged->failed_source(), 1U);
  }
}

std::unique_ptr<MergedSource> merge_samples(std::string_view first, std::string_view second) {
  std::vector<NamedSource> sources;
  for (const std::string_view bytes : {first, second}) {
    sources.push_back({*open_raw(memory_bytes(bytes), {megahertz(1'000), 1, {{"D0", 0}}}), "x"});
  }
  return std::make_unique<MergedSource>(std::move(sources));
}

TEST(Merge, SamplesThatEndBeforeTheOthers_HaveNoLevelFromThereOn) {
  const std::string_view bits("\1\0\1\0\0\1", 6);
  const Read read = read_all(merge_samples(bits, bits.substr(0, 3)));
  EXPECT_THAT(read.edges,
              ElementsAre(edge(0, 0, '1'), edge(0, 1, '1'), edge(1'000, 0, '0'),
                          edge(1'000, 1, '0'), edge(2'000, 0, '1'), edge(2'000, 1, '1'),
                          edge(2'000, 1, 'x'), edge(3'000, 0, '0'), edge(5'000, 0, '1')));
  EXPECT_EQ(read.end_time, read_all(merge_samples(bits, bits)).end_time);
}

TEST(Merge, SamplesThatEndTogether_KeepTheirLevels) {
  const std::string_view bits("\1\0\1", 3);
  EXPECT_THAT(read_all(merge_samples(bits, bits)).edges,
              ElementsAre(edge(0, 0, '1'), edge(0, 1, '1'), edge(1'000, 0, '0'),
                          edge(1'000, 1, '0'), edge(2'000, 0, '1'), edge(2'000, 1, '1')));
}

// The first channel has a sample that is not a number, last of all: one edge says so, not two.
TEST(Merge, SamplesWhoseLastLevelIsUnknown_EndWithoutAnotherEdge) {
  const auto volts = [](std::string_view rows) {
    const std::string text = "Time [s],Channel 0\n" + std::string(rows);
    const AnalogOptions at_one_volt{.threshold = Threshold{millivolts(1'000), {}},
                                    .differentials = {}};
    return *open_sampled_csv(memory_bytes(text), at_one_volt);
  };
  std::vector<NamedSource> sources;
  sources.push_back({volts("0,0.1\n1e-6,nan\n"), "a"});
  sources.push_back({volts("0,0.1\n1e-6,0.1\n2e-6,0.1\n3e-6,0.1\n"), "b"});
  const Read read = read_all(std::make_unique<MergedSource>(std::move(sources)));
  EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '0'), edge(0, 1, '0'), edge(1'000'000, 0, 'x')));
  EXPECT_EQ(read.end_time, microseconds(3));
}

// What the other one has read ahead does not count.
TEST(Merge, SourceThatFails_EndsTheCaptureWhereItWasRead) {
  EXPECT_EQ(
      read_all(merge("time_ps,MA\n0,1\n5,0\n99,1\n", "time_ps,SLO\n1,1\n6,0\noops\n")).end_time,
      picoseconds(6));
  EXPECT_EQ(read_all(merge("time_ps,MA\n0,1\noops\n", "time_ps,SLO\n1,1\n6,0\n")).end_time,
            picoseconds(0));
}

TEST(Merge, NoSources_IsAnEmptyCapture) {
  MergedSource merged({});
  EXPECT_TRUE(merged.next_block()->empty());
}

}  // namespace merge_test
}  // namespace biss::capture
