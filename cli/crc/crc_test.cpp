#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <iterator>
#include <string>
#include <vector>

#include "cli/common/verb_harness.hpp"
#include "cli/common/verbs.hpp"

namespace biss::cli {
namespace crc_test {

using testing::HasSubstr;

Ran crc(std::initializer_list<std::string> arguments) {
  std::vector<std::string> all{"crc"};
  all.insert(all.end(), arguments);
  return run_verb(add_crc, all);
}

// Replaces each run of spaces by one, so that column widths do not matter.
std::string squeezed(const std::string& text) {
  std::string out;
  std::unique_copy(text.begin(), text.end(), std::back_inserter(out),
                   [](char a, char b) { return a == ' ' && b == ' '; });
  return out;
}

TEST(Crc, OneChannelAsObject_HasTheContractsKeysInOrder) {
  const Ran ran = crc({"-f", "resolute-26", "0x1234567", "--to", "jsonl"});
  EXPECT_EQ(ran.status, ExitStatus::done) << ran.err;
  EXPECT_EQ(ran.out,
            "{\"position\":19088743,\"nE\":1,\"nW\":1,\"crc\":43,"
            "\"bits\":\"100100100011010001010110011111101011\"}\n");
}

TEST(Crc, ErrorAndWarning_ClearTheirBits) {
  // Published for 26 bits: 11 gives 2B, 01 gives 2D, 10 gives 28.
  EXPECT_THAT(crc({"-f", "pos26,nE,nW,crc6", "0x1234567", "--error", "--to", "jsonl"}).out,
              HasSubstr("\"nE\":0,\"nW\":1,\"crc\":45"));
  EXPECT_THAT(crc({"-f", "pos26,nE,nW,crc6", "0x1234567", "--warning", "--to", "jsonl"}).out,
              HasSubstr("\"nE\":1,\"nW\":0,\"crc\":40"));
  EXPECT_THAT(crc({"-f", "pos26,E,W,crc6", "0x1234567", "--error", "--to", "jsonl"}).out,
              HasSubstr("\"nE\":0,\"nW\":1,\"crc\":40"));
}

TEST(Crc, TwoChannels_AddTheSecondsKeys) {
  const Ran ran = crc({"-f", "fs-28-24", "0x1234567", "0x123456", "--lc", "1", "--to", "jsonl"});
  EXPECT_THAT(ran.out,
              HasSubstr("\"position2\":1193046,\"nE2\":1,\"nW2\":1,\"lc2\":1,\"crc2\":7359}"));
}

TEST(Crc, CounterOfTheFirstChannel_StandsBehindTheFixedKeys) {
  const Ran ran =
      crc({"-f", "mt12,st20,nE,nW,lc6,crc16", "0xD9CFE0C0", "--lc", "26", "--to", "jsonl"});
  EXPECT_THAT(ran.out, HasSubstr("\"crc\":24361,\"bits\":\"10"));
  EXPECT_THAT(ran.out, testing::EndsWith("\",\"lc\":26}\n"));
}

TEST(Crc, PositionOf64Bits_IsAStringInJson) {
  const Ran ran = crc({"-f", "pos64", "18446744073709551615", "--to", "jsonl"});
  EXPECT_THAT(ran.out, HasSubstr("\"position\":\"18446744073709551615\",\"nE\":null,\"nW\":null,"
                                 "\"crc\":null,\"bits\":\"101111"));
}

TEST(Crc, Table_ShowsEveryFieldInLineOrder) {
  const Ran ran =
      crc({"-f", "pad1,mt12,pad3,st20:gray,E,nW,lc6,crc16", "0xABCDE123", "--lc", "26"});
  EXPECT_EQ(ran.status, ExitStatus::done) << ran.err;
  const std::string out = squeezed(ran.out);
  std::size_t at = 0;
  for (const char* const line :
       {"START 0 1 1 ", "CDS 1 1 0 ", "padding 2 1 ", "multiturn 3 12 2748 = 0xABC 1010 1011 1100 ",
        "padding 15 3 ", "singleturn 18 20 909603 = 0xDE123 1011 0001 0001 1011 0010 ",
        "E 38 1 0 0 no error", "nW 39 1 1 1 no warning", "counter 40 6 26 = 0x1A 01 1010 ",
        "CRC 46 16 45389 = 0xB14D ", "STOP 62 1 0 "}) {
    const std::size_t found = out.find(line, at);
    ASSERT_NE(found, std::string::npos) << line << "\n" << ran.out;
    at = found;
  }
}

TEST(Crc, PositionTooLarge_NamesTheLargest) {
  const Ran ran = crc({"-f", "resolute-26", "67108864"});
  EXPECT_EQ(ran.status, ExitStatus::usage);
  EXPECT_EQ(ran.err,
            "biss: position 67108864: too large; 26 bits hold at most 67108863 (0x3FFFFFF)\n");
  EXPECT_EQ(ran.out, "");
  EXPECT_THAT(crc({"-f", "fs-28-24", "1", "0x1000000"}).err, HasSubstr("of channel 2: too large"));
  EXPECT_THAT(crc({"-f", "pos64", "18446744073709551616"}).err, HasSubstr("too large; 64 bits"));
}

TEST(Crc, WrongUsage_IsOneLineAndStatus2) {
  const std::initializer_list<std::initializer_list<std::string>> wrong = {
      {"-f", "resolute-26"},
      {"7"},
      {"-f", "resolute-26", "1", "2"},
      {"-f", "fs-28-24", "1"},
      {"-f", "pos26,nX", "1"},
      {"-f", "pos3,crc3", "1", "--error"},
      {"-f", "pos3,crc3", "1", "--warning"},
      {"-f", "pos3,crc3", "1", "--lc", "3"},
      {"-f", "pos3,lc6,crc3", "1", "--lc", "64"},
      {"-f", "pos3,crc3", "1x"},
      {"-f", "pos3,crc3", ""},
      {"-f", "pad3,crc3", "5"},
      {"-f", "pos3,crc3", "1", "--to", "csv"},
  };
  for (const auto& arguments : wrong) {
    const Ran ran = crc(arguments);
    EXPECT_EQ(ran.status, ExitStatus::usage) << ran.err;
    EXPECT_EQ(ran.out, "");
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
  }
}

TEST(Crc, ChannelWithoutPosition_TakesZero) {
  EXPECT_THAT(crc({"-f", "pad3,crc3", "0", "--to", "jsonl"}).out, HasSubstr("{\"position\":null"));
}

}  // namespace crc_test
}  // namespace biss::cli
