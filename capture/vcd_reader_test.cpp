#include "capture/vcd.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "capture/test_capture.hpp"

namespace biss::capture {
namespace vcd_reader_test {

using testing::ElementsAre;
using testing::IsEmpty;

Read read_body(std::string_view body, std::string_view timescale = "1ps") {
  return read_vcd(vcd_of_ma_and_slo(body, timescale));
}

TEST(Vcd, SeveralChangesOnOneLine_AreAllRead) {
  const Read read = read_body("#0 1! 1\" #50 0!\t0\" #60 1!\n");
  EXPECT_FALSE(read.error);
  EXPECT_THAT(read.lines, ElementsAre("MA", "SLO"));
  EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '1'), edge(0, 1, '1'), edge(50, 0, '0'),
                                      edge(50, 1, '0'), edge(60, 0, '1')));
}

TEST(Vcd, ValuesThatChangeNothing_GiveNoEdge) {
  EXPECT_THAT(read_body("#0 1! #5 1! #9 0! #9 0! #12 1!\n").edges,
              ElementsAre(edge(0, 0, '1'), edge(9, 0, '0'), edge(12, 0, '1')));
}

TEST(Vcd, XAndZInEitherCase_AreUnknown) {
  EXPECT_THAT(read_body("#0 x! X\" #1 1! 1\" #2 z! Z\" #3 x! 0\"\n").edges,
              ElementsAre(edge(0, 0, 'x'), edge(0, 1, 'x'), edge(1, 0, '1'), edge(1, 1, '1'),
                          edge(2, 0, 'x'), edge(2, 1, 'x'), edge(3, 1, '0')));
}

TEST(Vcd, StrengthsOfVhdl_AreLevels) {
  EXPECT_THAT(read_body("#0 H! L\" #1 u! -\" #2 h! l\" #3 w! W\"\n").edges,
              ElementsAre(edge(0, 0, '1'), edge(0, 1, '0'), edge(1, 0, 'x'), edge(1, 1, 'x'),
                          edge(2, 0, '1'), edge(2, 1, '0'), edge(3, 0, 'x'), edge(3, 1, 'x')));
}

TEST(Vcd, VectorsOfOneBit_AreLevels) {
  EXPECT_THAT(read_body("#0 b1 ! B0 \" #4 b0\n!\n#5 bx !\n").edges,
              ElementsAre(edge(0, 0, '1'), edge(0, 1, '0'), edge(4, 0, '0'), edge(5, 0, 'x')));
}

TEST(Vcd, WideVectorsRealsAndStrings_ArePassedOver) {
  const std::string text =
      "$timescale 1ps $end $var wire 8 # pos $end $var real 64 $ v $end $var wire 1 ! MA $end "
      "$var string 0 % s $end $enddefinitions $end #0 b10101010 # r1.5e3 $ 1! shello % #1 0! bxz # "
      "sworld %\n";
  const Read read = read_vcd(text);
  EXPECT_FALSE(read.error);
  EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '1'), edge(1, 0, '0')));
}

TEST(Vcd, Dumpoff_LosesEveryLevelUntilItIsDumpedAgain) {
  const auto expected = ElementsAre(edge(0, 0, '1'), edge(0, 1, '0'), edge(5, 0, 'x'),
                                    edge(5, 1, 'x'), edge(9, 0, '1'), edge(9, 1, '1'));
  EXPECT_THAT(read_body("#0 1! 0\" #5 $dumpoff x! x\" $end #9 $dumpon 1! 1\" $end\n").edges,
              expected);
  EXPECT_THAT(read_body("#0 1! 0\" #5 $dumpoff $end #9 $dumpon 1! 1\" $end\n").edges, expected);
  EXPECT_THAT(read_body("#0 $dumpoff $end #9 $dumpon 1! $end\n").edges,
              ElementsAre(edge(9, 0, '1')));
}

TEST(Vcd, ABareTimeAtTheEnd_ExtendsTheCapture) {
  for (const char* end : {"#1234", "#1234\n"}) {
    const Read read = read_body(std::string("#0 1! #7 0!\n") + end);
    EXPECT_FALSE(read.error) << end;
    EXPECT_EQ(read.end_time, picoseconds(1'234)) << end;
  }
}

TEST(Vcd, DumpSections_AreReadLikeValues) {
  EXPECT_THAT(read_body("#0 $dumpvars 1! 1\" $end #5 $dumpoff x! x\" $end #9 $dumpon 0! 1\" $end "
                        "#11 $dumpall 0! 1\" $end\n")
                  .edges,
              ElementsAre(edge(0, 0, '1'), edge(0, 1, '1'), edge(5, 0, 'x'), edge(5, 1, 'x'),
                          edge(9, 0, '0'), edge(9, 1, '1')));
}

TEST(Vcd, ValuesBeforeTheFirstTime_StandAtZero) {
  EXPECT_THAT(read_body("1! $dumpvars 0\" $end #7 0!\n").edges,
              ElementsAre(edge(0, 0, '1'), edge(0, 1, '0'), edge(7, 0, '0')));
}

TEST(Vcd, CommentsAnywhere_ArePassedOver) {
  EXPECT_THAT(
      read_body("$comment 0! #99 $dumpvars\n$end 1! #1 $comment $end 0! $comment x$end $end\n")
          .edges,
      ElementsAre(edge(0, 0, '1'), edge(1, 0, '0')));
}

TEST(Vcd, CommentOfAnyLength_IsPassedOver) {
  const std::string long_word(5 * max_token_bytes, 'c');
  const std::string text = "$comment " + long_word + " $end " +
                           vcd_of_ma_and_slo("#0 1! $comment a " + long_word + " b $end #1 0!\n");
  for (const std::size_t block : {std::size_t{1'000}, std::size_t{70'000}, one_block}) {
    const Read read = read_vcd(text, block);
    EXPECT_FALSE(read.error) << block;
    EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '1'), edge(1, 0, '0'))) << block;
  }
}

TEST(Vcd, OneIdentifierOfTwoNames_DrivesBothLines) {
  const Read read = read_vcd(
      "$timescale 1ps $end $var wire 1 ! MA $end $var wire 1 \" SLO $end $var wire 1 ! clk $end "
      "$enddefinitions $end #0 1! 0\" #3 0!\n");
  EXPECT_THAT(read.lines, ElementsAre("MA", "SLO", "clk"));
  EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '1'), edge(0, 2, '1'), edge(0, 1, '0'),
                                      edge(3, 0, '0'), edge(3, 2, '0')));
}

TEST(Vcd, LongIdentifiers_AreToldApart) {
  const Read read = read_vcd(
      "$timescale 1ps $end $var wire 1 abc MA $end $var wire 1 ab SLO $end "
      "$var wire 1 abcdefghijk X $end $enddefinitions $end 1abc 0ab 1abcdefghijk #2 0abc\n");
  EXPECT_THAT(read.edges,
              ElementsAre(edge(0, 0, '1'), edge(0, 1, '0'), edge(0, 2, '1'), edge(2, 0, '0')));
}

TEST(Vcd, LastTimeWithoutChange_IsTheEndTime) {
  const Read read = read_body("#0 1! #500\n", "1ns");
  EXPECT_EQ(read.edges.size(), 1U);
  EXPECT_EQ(read.end_time, nanoseconds(500));
}

TEST(Vcd, TimesToTheEndOfTheRange_AreRead) {
  const Read read = read_body("#0 1! #9223372036854775807 0!\n");
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.end_time.count, INT64_MAX);
  EXPECT_EQ(read_body("#00000000000000000000000000000012 1!\n").end_time.count, 12);
  EXPECT_EQ(read_body("#18446744073709551615 1!\n", "1fs").end_time.count, 18'446'744'073'709'552);
}

TEST(Vcd, TimesBeyondTheRange_ReportTimeOutOfRange) {
  for (const char* time : {"9223372036854775808", "18446744073709551616", "99999999999999999999"}) {
    const Read read = read_body("#0 1!\n#" + std::string(time) + " 0!\n");
    ASSERT_EQ(read.cause(), CaptureCause::time_out_of_range) << time;
    EXPECT_EQ(read.error->line, 8U);
    EXPECT_EQ(read.error->column, 1U);
    EXPECT_EQ(read.edges.size(), 1U);
  }
  EXPECT_EQ(read_body("#92234 1!\n", "100s").cause(), CaptureCause::time_out_of_range);
}

TEST(Vcd, TimeThatFalls_ReportsTimeBackwardsAfterTheEdgesBefore) {
  const Read read = read_body("#10 1!\n#20 0!\n #19 1!\n");
  ASSERT_EQ(read.cause(), CaptureCause::time_backwards);
  EXPECT_EQ(read.error->line, 9U);
  EXPECT_EQ(read.error->column, 2U);
  EXPECT_THAT(read.edges, ElementsAre(edge(10, 0, '1'), edge(20, 0, '0')));
}

TEST(Vcd, WordsThatAreNoVcd_ReportMalformedWhereTheyAre) {
  for (const char* word : {"hello", "1", "0", "#", "#-5", "#1.5", "#12a", "b", "b2", "b!", "$foo",
                           "1#", "0MA", "b0 #", "r1 MA", "\x01", "\xC3\xA9", "b01 !", "2!"}) {
    const Read read = read_body("#0 1! " + std::string(word) + " #5 0! \n");
    ASSERT_EQ(read.cause(), CaptureCause::malformed) << word;
    EXPECT_EQ(read.error->line, 7U) << word;
    EXPECT_GE(read.error->column, 7U) << word;
    EXPECT_NE(read.error->expected, nullptr) << word;
    EXPECT_EQ(read.edges.size(), 1U) << word;
  }
}

TEST(Vcd, TextThatIsNoVcd_ReportsMalformed) {
  for (const char* text : {"hello\n", "hello", "time,MA\n", "# 1!",
                           "\x7F"
                           "ELF\x02",
                           "\n\n  x"}) {
    EXPECT_EQ(read_vcd(text).cause(), CaptureCause::malformed) << text;
  }
  const Read read = read_vcd("\n\n  hello world\n");
  EXPECT_EQ(read.error->line, 3U);
  EXPECT_EQ(read.error->column, 3U);
}

TEST(Vcd, NothingButWhiteSpace_ReportsEmpty) {
  for (const char* text : {"", " ", "\n\r\n\t ", "\xEF\xBB\xBF"}) {
    EXPECT_EQ(read_vcd(text).cause(), CaptureCause::empty);
    EXPECT_EQ(read_vcd(text, 1).cause(), CaptureCause::empty);
  }
}

TEST(Vcd, TokenWithoutEnd_ReportsTokenTooLong) {
  const std::string endless(3 * max_token_bytes, '1');
  for (const std::size_t block : {std::size_t{777}, one_block}) {
    for (const std::string start : {"#", "1", "b", "r", "$", "x!"}) {
      for (const char* end : {"", " !\n"}) {
        const Read read = read_vcd(vcd_of_ma_and_slo("#0 1!\n" + start + endless + end), block);
        ASSERT_EQ(read.cause(), CaptureCause::token_too_long) << start << " block " << block;
        EXPECT_EQ(read.error->line, 8U);
        EXPECT_EQ(read.error->column, 1U);
        EXPECT_EQ(read.edges.size(), 1U);
      }
    }
    EXPECT_EQ(read_vcd("$timescale " + endless + " $end", block).cause(),
              CaptureCause::token_too_long);
    EXPECT_EQ(read_vcd(vcd_of_ma_and_slo("b0 " + endless + " "), block).cause(),
              CaptureCause::token_too_long);
  }
}

TEST(Vcd, TokenOfExactlyTheLimit_IsRead) {
  const std::string zeros(max_token_bytes - 2, '0');
  const std::string text = vcd_of_ma_and_slo("#" + zeros + "7 1! ");
  EXPECT_EQ(read_vcd(text).end_time.count, 7);
  EXPECT_EQ(read_vcd(text, 1'000).end_time.count, 7);
  EXPECT_EQ(read_vcd(vcd_of_ma_and_slo("#0" + zeros + "7 1! ")).cause(),
            CaptureCause::token_too_long);
}

TEST(Vcd, MissingLastLineFeed_IsNoFault) {
  for (const char* body : {"#0 1! #5 0!", "#0 1! #5 0! #9", "#0 1! #5 b0 !", "#0 1! #5 0! $end"}) {
    const Read read = read_body(body);
    EXPECT_FALSE(read.error) << body;
    EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '1'), edge(5, 0, '0'))) << body;
  }
}

TEST(Vcd, EndInsideAToken_ReportsTruncatedAfterTheEdgesBefore) {
  for (const char* rest : {"0", "#", "b", "b0", "b0 ", "$dumpva", "$comment abc", "$comment", "#1",
                           "x!!", "r1.5", "0!zzz"}) {
    const Read read = read_body("#0 1! #50 0! " + std::string(rest));
    EXPECT_EQ(read.cause(), CaptureCause::truncated) << rest;
    EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '1'), edge(50, 0, '0'))) << rest;
  }
}

TEST(Vcd, EveryPrefix_GivesAPrefixOfTheEdges) {
  const std::string whole = vcd_of_ma_and_slo(
      "$dumpvars 1! 1\" $end\n#100\n0!\n#150 b1 !\n$comment x $end #200 0\"\n#1000\n1\"\n");
  const Read all = read_vcd(whole);
  ASSERT_FALSE(all.error);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Read part = read_vcd(whole.substr(0, size));
    ASSERT_LE(part.edges.size(), all.edges.size());
    for (std::size_t i = 0; i < part.edges.size(); ++i) {
      ASSERT_EQ(part.edges[i], all.edges[i]) << "size " << size;
    }
    if (!part.error || part.lines.empty()) continue;
    EXPECT_EQ(part.cause(), CaptureCause::truncated) << "size " << size;
  }
}

TEST(Vcd, AnyBlockSize_GivesTheSameEdgesAndErrors) {
  std::string body = "$dumpvars 1! 1\" $end\n";
  for (int i = 0; i < 2'000; ++i) {
    body += '#' + std::to_string(1'000 * (i + 1)) + (i % 3 == 0 ? "\n" : " ");
    body += (i % 2 == 0 ? "0! " : "b1 !\r\n");
    if (i % 5 == 0) body += (i % 10 == 0 ? "0\" $comment x #1 $end\n" : "1\"\n");
  }
  for (const char* end : {"", "#99999999", "#1 1!", "oops\n"}) {
    const std::string text = vcd_of_ma_and_slo(body + end);
    const Read whole = read_vcd(text);
    EXPECT_EQ(whole.edges.size(), 2U + 2'000U + 400U);
    for (const std::size_t block : {1U, 2U, 3U, 7U, 64U, 4'095U}) {
      const Read read = read_vcd(text, block);
      ASSERT_EQ(read.edges, whole.edges) << "block " << block;
      ASSERT_EQ(read.cause(), whole.cause()) << "block " << block;
      if (!whole.error) continue;
      EXPECT_EQ(read.error->line, whole.error->line);
      EXPECT_EQ(read.error->column, whole.error->column);
    }
  }
}

TEST(Vcd, AfterErrorAndEnd_NextBlockSaysTheSameAgain) {
  const std::string good = vcd_of_ma_and_slo("#0 1!\n");
  const Opened ended = open_vcd(memory_bytes(good));
  EXPECT_EQ((*ended)->next_block()->size(), 1U);
  EXPECT_TRUE((*ended)->next_block()->empty());
  EXPECT_TRUE((*ended)->next_block()->empty());
  const std::string bad = vcd_of_ma_and_slo("#0 1! oops\n");
  const Opened failed = open_vcd(memory_bytes(bad));
  EXPECT_EQ((*failed)->next_block()->size(), 1U);
  for (int i = 0; i < 2; ++i) {
    const auto block = (*failed)->next_block();
    ASSERT_FALSE(block.ok());
    EXPECT_EQ(block.error().cause, CaptureCause::malformed);
  }
}

TEST(Vcd, IdentifierThatDrivesManyLines_KeepsBlocksBounded) {
  std::string text = "$timescale 1ps $end\n";
  constexpr std::size_t names = 3'000;
  for (std::size_t i = 0; i < names; ++i) {
    text += "$var wire 1 ! n" + std::to_string(i) + " $end\n";
  }
  text += "$enddefinitions $end\n";
  constexpr std::size_t changes = 200;
  for (std::size_t i = 0; i < changes; ++i) text += i % 2 == 0 ? "1!\n" : "0!\n";
  const Opened opened = open_vcd(memory_bytes(text));
  ASSERT_TRUE(opened);
  std::size_t edges = 0;
  for (;;) {
    const auto block = (*opened)->next_block();
    ASSERT_TRUE(block.ok());
    if (block->empty()) break;
    EXPECT_LE(block->size(), 8'192U + names);
    edges += block->size();
  }
  EXPECT_EQ(edges, names * changes);
}

}  // namespace vcd_reader_test
}  // namespace biss::capture
