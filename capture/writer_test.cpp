#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "capture/event_csv.hpp"
#include "capture/test_capture.hpp"
#include "capture/vcd.hpp"

namespace biss::capture {
namespace writer_test {

const std::vector<wire::Edge> some_edges{edge(0, 0, '1'),          edge(0, 1, '1'),
                                         edge(42'007'500, 0, '0'), edge(42'007'500, 0, '0'),
                                         edge(42'057'501, 0, '1'), edge(42'057'501, 1, 'x')};

template <class Writer>
std::string written(const std::vector<std::string>& lines, std::span<const wire::Edge> edges,
                    Picoseconds end) {
  std::string text;
  StringSink sink(text);
  Writer writer(lines, sink);
  EXPECT_TRUE(writer.write(edges).ok());
  EXPECT_TRUE(writer.finish(end).ok());
  return text;
}

TEST(VcdWriter, Edges_BecomeTimesAndChanges) {
  EXPECT_EQ(written<VcdWriter>({"MA", "S LO"}, some_edges, picoseconds(50'000'000)),
            "$timescale 1ps $end\n$scope module capture $end\n$var wire 1 ! MA $end\n"
            "$var wire 1 \" S_LO $end\n$upscope $end\n$enddefinitions $end\n"
            "#0\n1!\n1\"\n#42007500\n0!\n#42057501\n1!\nx\"\n#50000000\n");
}

TEST(VcdWriter, EndAtTheLastEdge_AddsNothing) {
  const std::string text = written<VcdWriter>({"MA", "SLO"}, some_edges, picoseconds(42'057'501));
  EXPECT_TRUE(text.ends_with("x\"\n")) << text;
}

TEST(VcdWriter, TimeBeforeZero_IsRefused) {
  std::string text;
  StringSink sink(text);
  VcdWriter writer({"MA"}, sink);
  const std::array<wire::Edge, 1> edges{edge(-1, 0, '1')};
  const Written result = writer.write(edges);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error(), WriteCause::time_before_zero);
  EXPECT_FALSE(writer.finish({}).ok());
}

TEST(EventCsvWriter, Edges_BecomeRows) {
  EXPECT_EQ(written<EventCsvWriter>({"MA", "S,LO"}, some_edges, picoseconds(50'000'000)),
            "time_ns,MA,\"S,LO\"\n0.000,1,1\n42007.500,0,1\n42057.501,1,x\n50000.000,1,x\n");
}

TEST(EventCsvWriter, LevelsNotYetKnownAndNegativeTimes_AreWritten) {
  const std::array<wire::Edge, 2> edges{edge(-1'500, 1, '0'), edge(2, 0, '1')};
  EXPECT_EQ(written<EventCsvWriter>({"MA", "SLO"}, edges, picoseconds(2)),
            "time_ns,MA,SLO\n-1.500,,0\n0.002,1,0\n");
}

TEST(EdgeWriter, EdgesOutOfOrderOrOfUnknownLines_AreRefused) {
  std::string text;
  StringSink sink(text);
  EventCsvWriter writer({"MA"}, sink);
  const std::array<wire::Edge, 2> backwards{edge(5, 0, '1'), edge(4, 0, '0')};
  EXPECT_EQ(writer.write(backwards).error(), WriteCause::time_backwards);
  VcdWriter other({"MA"}, sink);
  const std::array<wire::Edge, 1> stranger{edge(5, 1, '1')};
  EXPECT_EQ(other.write(stranger).error(), WriteCause::no_such_line);
}

TEST(EdgeWriter, ChangesWritten_AreCounted) {
  std::string text;
  StringSink sink(text);
  VcdWriter writer({"MA", "SLO"}, sink);
  EXPECT_EQ(*writer.write(some_edges), 5U);
  EXPECT_EQ(*writer.finish({}), 5U);
}

TEST(EdgeWriter, FullDisk_ReportsWriteFailed) {
  for (const bool writes : {false, true}) {
    FailingSink sink(writes);
    VcdWriter writer({"MA", "SLO"}, sink);
    EXPECT_TRUE(writer.write(some_edges).ok());
    const Written result = writer.finish({});
    ASSERT_FALSE(result.ok()) << writes;
    EXPECT_EQ(result.error(), WriteCause::write_failed);
  }
}

TEST(EdgeWriter, WriteThatFails_EndsTheCapture) {
  FailingSink sink(false);
  EventCsvWriter writer({"MA"}, sink);
  EXPECT_EQ(writer.finish({}).error(), WriteCause::write_failed);
}

}  // namespace writer_test
}  // namespace biss::capture
