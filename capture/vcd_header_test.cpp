#include "capture/vcd.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "capture/test_capture.hpp"

namespace biss::capture {
namespace vcd_header_test {

using testing::ElementsAre;

std::vector<std::string> names_of(const std::string& declarations) {
  const Read read = read_vcd("$timescale 1ns $end " + declarations + " $enddefinitions $end\n");
  EXPECT_FALSE(read.error) << declarations;
  return read.lines;
}

TEST(VcdTimescale, EveryUnitAndCount_IsPicoseconds) {
  EXPECT_EQ(parse_vcd_timescale("1s").time_of(3), picoseconds(3'000'000'000'000));
  EXPECT_EQ(parse_vcd_timescale("100s").factor, 100'000'000'000'000U);
  EXPECT_EQ(parse_vcd_timescale("10ms").time_of(7), milliseconds(70));
  EXPECT_EQ(parse_vcd_timescale("100us").time_of(2), microseconds(200));
  EXPECT_EQ(parse_vcd_timescale("1ns").time_of(5), nanoseconds(5));
  EXPECT_EQ(parse_vcd_timescale("10ps").time_of(5), picoseconds(50));
}

TEST(VcdTimescale, Femtoseconds_RoundToThePicosecond) {
  EXPECT_EQ(parse_vcd_timescale("1fs").time_of(499), picoseconds(0));
  EXPECT_EQ(parse_vcd_timescale("1fs").time_of(500), picoseconds(1));
  EXPECT_EQ(parse_vcd_timescale("10fs").time_of(1'249), picoseconds(12));
  EXPECT_EQ(parse_vcd_timescale("10fs").time_of(1'250), picoseconds(13));
  EXPECT_EQ(parse_vcd_timescale("100fs").time_of(UINT64_MAX),
            picoseconds(1'844'674'407'370'955'162));
}

TEST(VcdTimescale, AnythingElse_IsNotKnown) {
  for (const char* text :
       {"", "1", "ns", "2ns", "1000ns", "1 ns", "01ns", "1min", "1nss", "-1ns"}) {
    EXPECT_FALSE(parse_vcd_timescale(text).known()) << text;
  }
}

TEST(VcdHeader, TimescaleWithAndWithoutSpace_IsTheSame) {
  for (const char* timescale : {"10us", "10 us", "\n 10\n us\n"}) {
    const Read read = read_vcd(vcd_of_ma_and_slo("#7 0!\n", timescale));
    ASSERT_EQ(read.edges.size(), 1U) << timescale;
    EXPECT_EQ(read.edges[0].time, microseconds(70)) << timescale;
  }
}

TEST(VcdHeader, ASecondTimescale_IsRefusedUnlessItIsTheSame) {
  const std::string signals = "$var wire 1 ! MA $end $enddefinitions $end #7 0!\n";
  const Read differs = read_vcd("$timescale 1ns $end\n$timescale 1ps $end\n" + signals);
  ASSERT_EQ(differs.cause(), CaptureCause::malformed);
  EXPECT_EQ(differs.error->line, 2U);
  EXPECT_STREQ(differs.error->expected, "one $timescale; this second one differs from the first");
  const Read same = read_vcd("$timescale 1ns $end $timescale 1 ns $end " + signals);
  ASSERT_EQ(same.edges.size(), 1U);
  EXPECT_EQ(same.edges[0].time, nanoseconds(7));
}

TEST(VcdHeader, OneBitSignals_AreLinesAndOthersAreNot) {
  EXPECT_THAT(names_of("$var wire 1 ! MA $end $var reg 8 \" pos [7:0] $end $var real 64 # v $end "
                       "$var real 1 $ r $end $var reg 1 % SLO $end $var event 1 & e $end "
                       "$var string 1 ' s $end $var parameter 32 ( P $end"),
              ElementsAre("MA", "SLO"));
}

TEST(VcdHeader, WidthWithLeadingZeros_IsANumber) {
  EXPECT_THAT(names_of("$var wire 01 ! MA $end $var wire 0001 \" SLO $end $var wire 08 # pos $end"),
              ElementsAre("MA", "SLO"));
}

TEST(VcdHeader, BitOfAVector_KeepsItsIndex) {
  EXPECT_THAT(names_of("$var wire 1 ! MA [3] $end $var wire 1 \" MA[4] $end"),
              ElementsAre("MA[3]", "MA[4]"));
}

TEST(VcdHeader, RangeOfOneBit_IsLeftOut) {
  EXPECT_THAT(names_of("$var wire 1 ! MA [0:0] $end"), ElementsAre("MA"));
}

TEST(VcdHeader, NameWithBlanks_IsKept) {
  EXPECT_THAT(names_of("$var wire 1 ! Channel 0 $end"), ElementsAre("Channel 0"));
}

TEST(VcdHeader, NamesThatDiffer_StandWithoutTheirScope) {
  EXPECT_THAT(names_of("$scope module top $end $scope module cap $end $var wire 1 ! MA $end "
                       "$upscope $end $var wire 1 \" SLO $end $upscope $end"),
              ElementsAre("MA", "SLO"));
}

TEST(VcdHeader, EqualNamesOfDifferentSignals_GetTheirScopePath) {
  EXPECT_THAT(names_of("$scope module top $end $var wire 1 ! MA $end $scope module cap $end "
                       "$var wire 1 \" MA $end $var wire 1 # SLO $end $upscope $end $upscope $end"),
              ElementsAre("top.MA", "top.cap.MA", "SLO"));
}

TEST(VcdHeader, EqualNamesOfOneSignal_AreOneLine) {
  EXPECT_THAT(names_of("$scope module top $end $var wire 1 ! MA $end $scope module cap $end "
                       "$var wire 1 ! MA $end $upscope $end $upscope $end"),
              ElementsAre("MA"));
}

TEST(VcdHeader, EqualPaths_AreNumbered) {
  EXPECT_THAT(names_of("$var wire 1 ! MA $end $var wire 1 \" MA $end $var wire 1 # MA $end"),
              ElementsAre("MA", "MA#2", "MA#3"));
}

TEST(VcdHeader, TextOfOtherKeywords_IsPassedOver) {
  EXPECT_THAT(names_of("$date today 12:00 $end $version x $var y $end $comment # 1! $end "
                       "$attrbegin misc 02 a 1 $end $timezero 0 $end $var wire 1 ! MA $end"),
              ElementsAre("MA"));
}

TEST(VcdHeader, Faults_AreMalformedWhereTheyAre) {
  const std::string start = "$timescale 1ns $end ";
  for (const char* rest : {
           "$var wire 1 ! $end",
           "$var wire one ! MA $end",
           "$var wire 1 \x80 MA $end",
           "$upscope $end",
           "$scope module $end",
           "$end",
           "#0 1!",
           "1!",
           "$timescale 3ns $end",
           "$timescale $end",
           "$ end",
           "$",
       }) {
    const Read read = read_vcd(start + rest + " x ");
    EXPECT_EQ(read.cause(), CaptureCause::malformed) << rest;
    EXPECT_EQ(read.error->line, 1U);
    EXPECT_GT(read.error->column, start.size()) << rest;
    EXPECT_NE(read.error->expected, nullptr);
  }
}

TEST(VcdHeader, NoTimescale_ReportsMalformed) {
  const Read read = read_vcd("$var wire 1 ! MA $end\n$enddefinitions $end\n#0 1!\n");
  ASSERT_EQ(read.cause(), CaptureCause::malformed);
  EXPECT_EQ(read.error->line, 2U);
  EXPECT_EQ(read.error->column, 17U);
}

TEST(VcdHeader, EndOfTextInside_ReportsTruncated) {
  const std::string whole = vcd_of_ma_and_slo("");
  for (std::size_t size = 1; size + 1 < whole.size(); ++size) {
    const Read read = read_vcd(whole.substr(0, size));
    ASSERT_TRUE(read.error) << size;
    const bool first_word = size < std::string("$t").size();
    EXPECT_EQ(read.cause(), first_word ? CaptureCause::malformed : CaptureCause::truncated) << size;
  }
  EXPECT_FALSE(read_vcd(whole.substr(0, whole.size() - 1)).error);
}

TEST(VcdHeader, MoreSignalsThanAllowed_ReportsTooManyLines) {
  std::ostringstream text;
  text << "$timescale 1ns $end\n";
  for (std::size_t i = 0; i < max_lines; ++i)
    text << "$var wire 1 i" << i << " n" << i << " $end\n";
  const std::string most = text.str();
  EXPECT_EQ(read_vcd(most + "$enddefinitions $end\n").lines.size(), max_lines);
  const Read read = read_vcd(most + "$var wire 1 ! MA $end\n$enddefinitions $end\n");
  EXPECT_EQ(read.cause(), CaptureCause::too_many_lines);
}

TEST(VcdHeader, ScopesWithoutEnd_StayBounded) {
  std::string text = "$timescale 1ns $end\n";
  for (int i = 0; i < 100'000; ++i) text += "$scope module a $end\n";
  EXPECT_EQ(read_vcd(text).cause(), CaptureCause::malformed);
}

TEST(VcdHeader, NamesThatFillMemory_ReportTooManyLines) {
  std::string text = "$timescale 1ns $end\n";
  for (int i = 0; i < 200; ++i) text += "$scope module " + std::string(60'000, 'a') + " $end\n";
  for (int i = 0; i < 2'000; ++i) text += "$var wire 1 i" + std::to_string(i) + " MA $end\n";
  EXPECT_EQ(read_vcd(text + "$enddefinitions $end\n").cause(), CaptureCause::too_many_lines);
}

TEST(VcdHeader, IdentifiersOfEveryLength_AreFoundAgain) {
  std::vector<std::string> ids;
  for (int i = 0; i < 3'000; ++i) {
    for (const char* shape : {"", "a", "bcd", "efghijk", "lmnopqrstuvw"}) {
      ids.push_back(std::string(shape) + std::to_string(i));
    }
  }
  std::string signals = "$timescale 1ps $end\n";
  std::string values = "$enddefinitions $end\n#0\n";
  for (const std::string& id : ids) {
    signals += "$var wire 1 " + id + " n" + id + " $end\n";
    values += "1" + id + "\n";
  }
  const Read read = read_vcd(signals + values);
  ASSERT_FALSE(read.error);
  ASSERT_EQ(read.edges.size(), ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    ASSERT_EQ(read.lines[i], "n" + ids[i]);
    ASSERT_EQ(read.edges[i], edge(0, static_cast<wire::LineIndex>(i), '1'));
  }
  for (const std::string& id :
       {std::string("\0bcd1", 5), std::string("zz"), std::string("zzzzzzzzzzzz")}) {
    EXPECT_EQ(read_vcd(signals + "$enddefinitions $end\n#0\n1" + id + "\n").cause(),
              CaptureCause::malformed)
        << id;
  }
}

}  // namespace vcd_header_test
}  // namespace biss::capture
