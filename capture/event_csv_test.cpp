#include "capture/event_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "capture/test_capture.hpp"

namespace biss::capture {
namespace event_csv_test {

using testing::ElementsAre;

TEST(EventCsvHeader, TimeColumns_GiveTheirUnit) {
  for (const char* name : {"time", "Time", "TIME", "time_s", "Time [s]", "time(s)", " time "}) {
    EXPECT_EQ(event_csv_time_scale(name),
              name == std::string(" time ") ? std::nullopt : std::optional(12))
        << name;
  }
  for (const char* name : {"time_ms", "time [ms]"}) EXPECT_EQ(event_csv_time_scale(name), 9);
  for (const char* name : {"time_us", "time(us)", "Time (\xC2\xB5s)", "time [\xCE\xBCs]"}) {
    EXPECT_EQ(event_csv_time_scale(name), 6) << name;
  }
  for (const char* name : {"time_ns", "Time [ns]", "time/ns", "time ns"}) {
    EXPECT_EQ(event_csv_time_scale(name), 3) << name;
  }
  EXPECT_EQ(event_csv_time_scale("time_ps"), 0);
  for (const char* name : {"", "t", "MA", "time_min", "times_", "time_fs"}) {
    EXPECT_EQ(event_csv_time_scale(name), std::nullopt) << name;
  }
}

TEST(EventCsv, PlainFile_GivesItsChanges) {
  const Read read = read_csv("time_ns,MA,SLO\n0.000,1,1\n42007.500,0,1\n42057.500,1,0\n");
  EXPECT_FALSE(read.error);
  EXPECT_THAT(read.lines, ElementsAre("MA", "SLO"));
  EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '1'), edge(0, 1, '1'), edge(42'007'500, 0, '0'),
                                      edge(42'057'500, 0, '1'), edge(42'057'500, 1, '0')));
  EXPECT_EQ(read.end_time, picoseconds(42'057'500));
}

TEST(EventCsv, EveryDialect_GivesTheSameEdges) {
  const Read plain = read_csv("time_us,MA,SLO\n-1.5,1,1\n0.25,0,x\n");
  ASSERT_EQ(plain.edges.size(), 4U);
  for (const char* text : {
           "\xEF\xBB\xBFtime_us,MA,SLO\r\n-1.5,1,1\r\n0.25,0,x\r\n",
           "time [us];MA;SLO\n-1,5;1;1\n0,25;0;X\n",
           "Time (us)\tMA\tSLO\n-1,5\t1\t1\n0.25\t0\tz\n",
           "\"time_us\",\"MA\",\"SLO\"\n-1.5,1,1\n0.25,0,Z\n",
           "\"time_us\" , \"MA\" , \"SLO\"\n \"-1.5\" , \"1\" , \"1\"\n \"0.25\" , \"0\" , \"x\"\n",
           "  time_us , MA ,SLO \n -1.5 , 1 ,1 \n\t0.25 , 0 , x \n",
           "# made by hand\n\n#more\ntime_us,MA,SLO\n-1.5,1,1\n\n# in between\n \n0.25,0,x\n\n",
           "time,MA,SLO\n-1.5e-6,1,1\n2.5E-7,0,x",
           "time_ns,MA,SLO\n-1500,1,1\n-3,,\n250,0,x\n",
           "time_us,MA,SLO\r\n-1.5,1,1\r\n-1,1,\r\n0.25,0,x\r",
       }) {
    const Read read = read_csv(text);
    EXPECT_FALSE(read.error) << text;
    EXPECT_EQ(read.lines, plain.lines) << text;
    EXPECT_EQ(read.edges, plain.edges) << text;
  }
}

TEST(EventCsv, EmptyCell_LeavesTheLevel) {
  EXPECT_THAT(read_csv("time_ps,MA,SLO\n0,,1\n1,1,\n2,,0\n3,0, \n").edges,
              ElementsAre(edge(0, 1, '1'), edge(1, 0, '1'), edge(2, 1, '0'), edge(3, 0, '0')));
}

TEST(EventCsv, NamesWithSeparatorsAndQuotes_AreKept) {
  EXPECT_THAT(read_csv("time_ns,\"M,A\",\"S\"\"L;O\"\n0,1,1\n").lines,
              ElementsAre("M,A", "S\"L;O"));
}

TEST(EventCsv, EqualNames_AreNumbered) {
  EXPECT_THAT(read_csv("time_ns,MA,MA\n0,1,1\n").lines, ElementsAre("MA", "MA#2"));
}

TEST(EventCsv, TimesBelowAPicosecond_AreRoundedExactly) {
  const Read read = read_csv("time,MA\n0.0000000000005,1\n0.1234567890124999,0\n");
  EXPECT_THAT(read.edges, ElementsAre(edge(1, 0, '1'), edge(123'456'789'012, 0, '0')));
}

TEST(EventCsv, BadRows_ReportMalformedWhereTheyAre) {
  const std::string start = "time_ns,MA,SLO\n0,1,1\n";
  struct Case {
    const char* row;
    std::uint64_t column;
  };
  for (const Case& bad :
       {Case{"1,0", 4}, Case{"1,0,1,0", 6}, Case{"1,0,2", 5}, Case{"1,-,1", 3}, Case{"x,0,1", 1},
        Case{",0,1", 1}, Case{"1.2.3,0,1", 1}, Case{"1", 2}, Case{"1;0;1", 1}, Case{"1,10,1", 3},
        Case{"1,0,1,", 6}, Case{"nan,0,1", 1}}) {
    const Read read = read_csv(start + bad.row + "\n2,0,0\n");
    ASSERT_EQ(read.cause(), CaptureCause::malformed) << bad.row;
    EXPECT_EQ(read.error->line, 3U) << bad.row;
    EXPECT_EQ(read.error->column, bad.column) << bad.row;
    EXPECT_NE(read.error->expected, nullptr);
    EXPECT_EQ(read.edges.size(), 2U) << bad.row;
  }
}

TEST(EventCsv, BadHeaders_ReportMalformed) {
  for (const char* header : {"time_min,MA", "MA,SLO", "1,2,3", "hello", "time_ns", "time_ns,",
                             "time_ns,MA,,SLO", "time,\"\"", "X,CH1,CH2,Start,Increment,"}) {
    const Read read = read_csv(std::string("\n") + header + "\n0,1,1\n");
    ASSERT_EQ(read.cause(), CaptureCause::malformed) << header;
    EXPECT_EQ(read.error->line, 2U) << header;
  }
}

TEST(EventCsv, TimeThatFalls_ReportsTimeBackwards) {
  const Read read = read_csv("time_ns,MA\n5,1\n4.999,0\n");
  ASSERT_EQ(read.cause(), CaptureCause::time_backwards);
  EXPECT_EQ(read.error->line, 3U);
  EXPECT_EQ(read.edges.size(), 1U);
}

TEST(EventCsv, TimeBeyondTheRange_ReportsTimeOutOfRange) {
  for (const char* time : {"1e20", "-1e20", "9223372.036854775808", "9999999999999999999999"}) {
    const Read read = read_csv("time,MA\n-2,1\n" + std::string(time) + ",0\n");
    EXPECT_EQ(read.cause(), CaptureCause::time_out_of_range) << time;
  }
  EXPECT_EQ(read_csv("time,MA\n9223372.036854775807,1\n").end_time.count, INT64_MAX);
}

TEST(EventCsv, NothingButWhiteSpace_ReportsEmpty) {
  for (const char* text : {"", "\n", " \r\n \n", "\xEF\xBB\xBF"}) {
    EXPECT_EQ(read_csv(text).cause(), CaptureCause::empty);
  }
  EXPECT_EQ(read_csv("# only a comment\n").cause(), CaptureCause::truncated);
}

TEST(EventCsv, HeaderWithoutRows_HasNoEdges) {
  const Read read = read_csv("time_ns,MA,SLO\n");
  EXPECT_FALSE(read.error);
  EXPECT_TRUE(read.edges.empty());
}

TEST(EventCsv, RowWithoutEnd_ReportsTokenTooLong) {
  for (const char filler : {'1', ' ', ',', '#'}) {
    const std::string endless(3 * max_token_bytes, filler);
    for (const std::size_t block : {std::size_t{777}, one_block}) {
      for (const char* end : {"", "\n"}) {
        EXPECT_EQ(read_csv(endless + end, block).cause(), CaptureCause::token_too_long);
        const Read read = read_csv("time_ns,MA\n0,1\n" + endless + end, block);
        ASSERT_EQ(read.cause(), CaptureCause::token_too_long);
        EXPECT_EQ(read.error->line, 3U);
        EXPECT_EQ(read.edges.size(), 1U);
      }
    }
  }
}

TEST(EventCsv, LastRowWithoutLineFeed_CountsWhenWhole) {
  EXPECT_EQ(read_csv("time_ns,MA,SLO\n0,1,1\n5,0,0").edges.size(), 4U);
  EXPECT_FALSE(read_csv("time_ns,MA,SLO\n0,1,1\n5,0,0").error);
}

TEST(EventCsv, LastRowCutOff_ReportsTruncated) {
  for (const char* rest : {"1", "42", "42.", "42e", "42,", "42,0", "42,0,", "4", "-", "42,0, "}) {
    const Read read = read_csv("time_ns,MA,SLO\n0,1,1\n" + std::string(rest));
    EXPECT_EQ(read.cause(), CaptureCause::truncated) << rest;
    EXPECT_EQ(read.edges.size(), 2U) << rest;
  }
  for (const char* header : {"time_n", "time_ns", "time_ns,", "time_ns,MA,"}) {
    EXPECT_EQ(read_csv(header).cause(), CaptureCause::truncated) << header;
  }
}

TEST(EventCsv, AnyBlockSize_GivesTheSameEdgesAndErrors) {
  std::string rows = "time_ns,MA,SLO\r\n";
  for (int i = 0; i < 3'000; ++i) {
    rows += std::to_string(i) + ".125," + (i % 2 == 0 ? "0," : "1,") + (i % 7 < 3 ? "1" : "") +
            (i % 3 == 0 ? "\r\n" : "\n");
    if (i % 100 == 0) rows += "\n# note\n";
  }
  for (const char* end : {"", "4000,0,0", "3999,1", "bad,row\n", "1,1,1\n"}) {
    const std::string text = rows + end;
    const Read whole = read_csv(text);
    EXPECT_GE(whole.edges.size(), 3'000U);
    for (const std::size_t block : {1U, 2U, 3U, 7U, 64U, 4'095U}) {
      const Read read = read_csv(text, block);
      ASSERT_EQ(read.edges, whole.edges) << "block " << block;
      ASSERT_EQ(read.cause(), whole.cause()) << "block " << block;
      if (!whole.error) continue;
      EXPECT_EQ(read.error->line, whole.error->line);
      EXPECT_EQ(read.error->column, whole.error->column);
    }
  }
}

}  // namespace event_csv_test
}  // namespace biss::capture
