// Digital CSV of Saleae Logic: read by the event CSV reader, written in its own dialect.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "capture/event_csv.hpp"
#include "capture/test_capture.hpp"

namespace biss::capture {
namespace saleae_csv_test {

using testing::ElementsAre;

TEST(SaleaeCsv, Logic2Export_GivesItsChanges) {
  const Read read = read_csv(
      "Time [s],Channel 0,MA\r\n-0.000001000,1,1\r\n0.000000000,0,1\r\n"
      "2.0000000000000003e-08,0,0\r\n0.000125020,X,0\r\n");
  EXPECT_FALSE(read.error);
  EXPECT_THAT(read.lines, ElementsAre("Channel 0", "MA"));
  EXPECT_THAT(read.edges,
              ElementsAre(edge(-1'000'000, 0, '1'), edge(-1'000'000, 1, '1'), edge(0, 0, '0'),
                          edge(20'000, 1, '0'), edge(125'020'000, 0, 'x')));
}

TEST(SaleaeCsv, Logic1Export_GivesItsChanges) {
  const Read read = read_csv(
      "Time[s], Channel 0, Channel 1\n0.000000000000000, 1, 1\n"
      "0.000000500000000, 0, 1\n");
  EXPECT_FALSE(read.error);
  EXPECT_THAT(read.lines, ElementsAre("Channel 0", "Channel 1"));
  EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '1'), edge(0, 1, '1'), edge(500'000, 0, '0')));
}

TEST(SaleaeCsvWriter, Edges_BecomeRowsOfSeconds) {
  const std::vector<wire::Edge> edges{edge(-1'500, 1, '0'), edge(0, 0, '1'),
                                      edge(42'007'500, 0, '0'), edge(1'000'000'000'001, 1, 'x')};
  std::string text;
  StringSink sink(text);
  EventCsvWriter writer({"MA", "SLO"}, sink, CsvDialect::saleae);
  EXPECT_TRUE(writer.write(edges).ok());
  EXPECT_TRUE(writer.finish(milliseconds(2'000)).ok());
  EXPECT_EQ(text,
            "Time [s],MA,SLO\n-0.000000001500,X,0\n0.000000000000,1,0\n0.000042007500,0,0\n"
            "1.000000000001,0,X\n2.000000000000,0,X\n");
  EXPECT_EQ(read_csv(text).edges.size(), 5U);
  EXPECT_EQ(read_csv(text).end_time, milliseconds(2'000));
}

TEST(SaleaeCsvWriter, LargestTimes_ComeBack) {
  const std::vector<wire::Edge> edges{edge(-INT64_MAX, 0, '0'), edge(INT64_MAX, 0, '1')};
  std::string text;
  StringSink sink(text);
  EventCsvWriter writer({"MA"}, sink, CsvDialect::saleae);
  EXPECT_TRUE(writer.write(edges).ok());
  EXPECT_TRUE(writer.finish({}).ok());
  EXPECT_EQ(read_csv(text).edges, edges);
}

}  // namespace saleae_csv_test
}  // namespace biss::capture
