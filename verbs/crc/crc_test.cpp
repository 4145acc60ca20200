#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <iterator>
#include <string>
#include <vector>

#include "cli/test_verb_harness.hpp"

namespace biss::verbs {
namespace crc_test {

using testing::HasSubstr;

Ran crc(std::initializer_list<std::string> arguments) {
  std::vector<std::string> all{"crc"};
  all.insert(all.end(), arguments);
  return run_verb(all);
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
  for (const auto& arguments : wrong) expect_wrong_usage(crc(arguments));
}

TEST(Crc, ChannelWithoutPosition_TakesZero) {
  EXPECT_THAT(crc({"-f", "pad3,crc3", "0", "--to", "jsonl"}).out, HasSubstr("{\"position\":null"));
}

// The example of docs/spi.md.
constexpr const char* buffer = "F0 00 00 00 01 24 68 B9 A0";

TEST(CrcRead, Buffer_ShowsItsFrame) {
  const Ran ran = crc({"-f", "resolute-18", "--read", buffer, "--clock", "10MHz"});
  EXPECT_EQ(ran.status, ExitStatus::done) << ran.err;
  const std::string out = squeezed(ran.out);
  for (const char* const line :
       {"START 0 1 1 ", "CDS 1 1 0 0 always 0", "position 2 18 74565 = 0x12345 ",
        "nE 20 1 1 1 no error", "CRC 22 6 13 = 0x0D 00 1101 0x43, inverted",
        "STOP 28 1 0 0 until the timeout has passed"}) {
    EXPECT_THAT(out, HasSubstr(line));
  }
  EXPECT_EQ(
      squeezed(ran.err),
      "\nstatus ok\nleading ones 4 line delay 200 ns to 300 ns in SPI mode 3\nACK 35 clocks\n");
  const Ran object = crc({"-f", "resolute-18", "--read", buffer, "--to", "jsonl"});
  EXPECT_EQ(object.out,
            "{\"position\":74565,\"nE\":1,\"nW\":1,\"crc\":13,"
            "\"bits\":\"1001001000110100010111001101\",\"crc_computed\":13,\"lead_clocks\":4,"
            "\"ack_clocks\":35,\"status\":\"ok\"}\n");
}

TEST(CrcRead, BytesOfADebugger_AreTheSame) {
  const std::string expected = crc({"-f", "resolute-18", "--read", buffer, "--to", "jsonl"}).out;
  for (const char* const text : {"F0000000012468B9A0", "0xF0000000 0x012468B9A0",
                                 "{0xf0, 0x0, 0x0, 0x0, 0x1, 0x24, 0x68, 0xb9, 0xa0}",
                                 "f0 00 00 00\n01 24 68 b9\na0\n", "F0,00,00,00,01,24,68,B9,A0"}) {
    EXPECT_EQ(crc({"-f", "resolute-18", "--read", text, "--to", "jsonl"}).out, expected) << text;
  }
}

TEST(CrcRead, WrongChecksum_IsShownWithTheOneOfTheData) {
  const std::initializer_list<std::string> wrong{"-f", "pos18,nE,nW,crc6", "--read",
                                                 "F0 00 00 00 01 24 68 B9 80"};
  const Ran ran = crc(wrong);
  EXPECT_EQ(ran.status, ExitStatus::data_failed);
  EXPECT_THAT(squeezed(ran.out),
              HasSubstr("CRC 22 6 12 = 0x0C 00 1100 wrong: 13 = 0x0D computed; 0x43"));
  EXPECT_THAT(squeezed(ran.err),
              testing::StartsWith("\nstatus crc the frame was disturbed on the line"));
  const Ran object =
      crc({"-f", "pos18,nE,nW,crc6", "--read", "F0 00 00 00 01 24 68 B9 80", "--to", "jsonl"});
  EXPECT_EQ(object.status, ExitStatus::data_failed);
  EXPECT_THAT(object.out, HasSubstr("\"crc\":12,"));
  EXPECT_THAT(object.out, HasSubstr("\"crc_computed\":13,\"lead_clocks\":4,\"ack_clocks\":35,"
                                    "\"status\":\"crc\"}"));
}

TEST(CrcRead, BufferWithoutAGoodFrame_NamesTheCause) {
  const auto status = [](const std::string& format, const std::string& bytes,
                         const std::string& clock = {}) {
    std::vector<std::string> all{"crc", "-f", format, "--read", bytes, "--to", "jsonl"};
    if (!clock.empty()) all.insert(all.end(), {"--clock", clock});
    const Ran ran = run_verb(all);
    EXPECT_EQ(ran.status, ExitStatus::data_failed) << ran.err;
    const std::size_t at = ran.out.find("\"status\":\"") + 10;
    return ran.out.substr(at, ran.out.find('"', at) - at);
  };
  EXPECT_EQ(status("resolute-18", "FF FF FF"), "no_response");
  EXPECT_EQ(status("resolute-18", "00 00 80"), "not_ready");
  EXPECT_EQ(status("resolute-18", "F0 00 00"), "no_start");
  EXPECT_EQ(status("resolute-18", "F0 00 00 00 01 24"), "truncated");
  EXPECT_EQ(status("resolute-18", "F0 00 00 00 01 A4 68 B9 A0"), "cds");
  // A 1 at STOP; with the clock, also after it.
  EXPECT_EQ(status("resolute-18", "F0 00 00 00 01 24 68 B9 B0"), "stop_bit");
  EXPECT_EQ(status("resolute-18", "F0 00 00 00 01 24 68 B9 A1", "10MHz"), "stop_bit");
  // START may come 3.225 us after the request at the earliest.
  EXPECT_EQ(status("resolute-18", "E4 91 A2 E6 80", "10MHz"), "ack_range");
}

TEST(CrcRead, TwoChannels_EachHaveTheirChecksum) {
  const Ran ran = crc({"-f", "pos3,crc3+pos3,crc3", "--read", "C9 80 00", "--to", "jsonl"});
  EXPECT_THAT(ran.out, HasSubstr("\"crc_computed2\":"));
}

TEST(CrcRead, WrongUsage_IsOneLineAndStatus2) {
  const std::initializer_list<std::initializer_list<std::string>> wrong = {
      {"-f", "resolute-18", "--read", buffer, "1"},
      {"-f", "resolute-18", "--read", buffer, "--error"},
      {"-f", "resolute-18", "--read", buffer, "--lc", "1"},
      {"-f", "resolute-18", "--read", "F0 0"},
      {"-f", "resolute-18", "--read", "F0 0x"},
      {"-f", "resolute-18", "--read", "G0"},
      {"-f", "resolute-18", "--read", " "},
      {"-f", "resolute-18", "--read", buffer, "--clock", "20MHz"},
      {"-f", "resolute-18", "1", "--clock", "10MHz"},
  };
  for (const auto& arguments : wrong) expect_wrong_usage(crc(arguments));
}

}  // namespace crc_test
}  // namespace biss::verbs
