#include "dump/read.hpp"

#include <gtest/gtest.h>

#include "dump/test_dumps.hpp"
#include "dump/write.hpp"

namespace biss::dump {
namespace read_test {

// The cause, line and column of an error.
std::string fails(const std::string& text, const DumpOptions& options = {}) {
  const DumpResult result = from_text(text, options);
  if (result.has_value()) return "ok";
  return std::string(name_of(result.error().cause)) + " " + std::to_string(result.error().line) +
         ":" + std::to_string(result.error().column);
}

TEST(HexPage, PageOfRealDevice_GivesItsRegistersAndHoles) {
  const RegisterDump dump = good(mhm_page);
  EXPECT_EQ(dump.direct_number(reg::bp_id, 2), 0x621EU);
  EXPECT_EQ(dump.direct_number(reg::dev_id, 6), 0x4D484D234400U);
  EXPECT_EQ(dump.direct_byte(0x6F), 0xFF);
  EXPECT_EQ(dump.direct_byte(0x74), std::nullopt);
  EXPECT_EQ(dump.direct_number(0x73, 2), std::nullopt);
  EXPECT_EQ(dump.bank(0)[0x13], 0x8C);
  EXPECT_EQ(dump.known_bytes(0), 20U);
  EXPECT_EQ(dump.whole_bank(0), std::nullopt);
}

TEST(HexPage, WindowWithoutHeading_BelongsToBselThenToTheOption) {
  EXPECT_EQ(good("0x00: 01\n0x40: 05\n").bank(5)[0], 0x01);
  EXPECT_EQ(good("0x00: 01\n0x40: 05\n", {.bank = 7}).bank(7)[0], 0x01);
  EXPECT_EQ(good("0x00: 01\n").bank(0)[0], 0x01);
}

TEST(HexPage, Headings_ChangeTheBank) {
  const RegisterDump dump = good("bank 2:\n0x3F: AA bb\nbank 0xFF # last\r\n0x00: 01 x3\n");
  EXPECT_EQ(dump.bank(2)[0x3F], 0xAA);
  EXPECT_EQ(dump.direct_byte(0x40), 0xBB);
  EXPECT_EQ(dump.bank(255)[2], 0x01);
  EXPECT_EQ(dump.bank(255)[3], std::nullopt);
}

TEST(HexPage, LinesThatEndInCr_AreRead) {
  const RegisterDump dump = good("# page\rbank 2:\r0x3F: AA bb\r\n0x00: 01\r");
  EXPECT_EQ(dump.bank(2)[0x3F], 0xAA);
  EXPECT_EQ(dump.direct_byte(0x40), 0xBB);
  EXPECT_EQ(dump.bank(2)[0], 0x01);
  EXPECT_EQ(fails("# page\r0x00: 01\r0x01: 0g\r"), fails("# page\r\n0x00: 01\r\n0x01: 0g\r\n"));
}

TEST(HexPage, Mistakes_AreNamedWithTheirPlace) {
  EXPECT_EQ(fails("0x00: 48 4\n"), "malformed 1:10");
  EXPECT_EQ(fails("# x\n0x00: 48\nnonsense\n"), "malformed 3:1");
  EXPECT_EQ(fails("0x80: 48\n"), "outside 1:1");
  EXPECT_EQ(fails("0x70: 00 x17\n"), "outside 1:10");
  EXPECT_EQ(fails("0x00: x4\n"), "malformed 1:7");
  EXPECT_EQ(fails("0x00: 00 x0\n"), "malformed 1:10");
  EXPECT_EQ(fails("0x00: 01\n0x00: 02\n"), "contradiction 2:7");
  EXPECT_EQ(fails("bank 256\n"), "malformed 1:6");
  EXPECT_EQ(fails("bank\n0x00: 00"), "malformed 1:5");
  EXPECT_EQ(fails("0x0: 1\n"), "malformed 1:6");
  EXPECT_EQ(fails("bank 0\n0x00: 01\nbank 1\n0x00: 02\nbank 0\n0x00: 03\n"), "contradiction 6:7");
}

TEST(HexOffsets, XxdAndHexdump_AreRead) {
  const RegisterDump xxd = good("00000000: 4844 0078  HD.x\n00000040: 01                  .\n");
  EXPECT_EQ(xxd.bank(0)[3], 0x78);
  EXPECT_EQ(xxd.bank(1)[0], 0x01);
  const RegisterDump hexdump = good(
      "00000000  48 44 00 78 80 00 00 00  cf 80 00 00 23 00 00 00  |HD.x|..|#...|\n"
      "00000010  ff ff ff ff ff ff ff ff  ff ff ff ff ff ff ff ff  |................|\n*\n"
      "00000040\n");
  EXPECT_EQ(hexdump.bank(0)[8], 0xCF);
  EXPECT_EQ(hexdump.bank(0)[0x3F], 0xFF);
  EXPECT_EQ(hexdump.known_bytes(1), 0U);
  EXPECT_EQ(good("00000000: 0102  ..\n", {.bank = 9}).bank(9)[1], 0x02);
}

TEST(HexOffsets, CharactersThatLookLikeDigits_AreNotRead) {
  const RegisterDump dump = good("00000000: 6162 6364                                abcd\n");
  EXPECT_EQ(dump.known_bytes(0), 4U);
}

TEST(HexOffsets, Mistakes_AreNamedWithTheirPlace) {
  EXPECT_EQ(fails("0000000 4448 7800\n"), "malformed 1:9");  // hexdump without -C: swapped
  EXPECT_EQ(fails("00000000: 48 4\n"), "malformed 1:14");
  EXPECT_EQ(fails("00000000: 48\n*\n"), "truncated 2:0");
  EXPECT_EQ(fails("00000000: 4844\n*\n00000003: 00\n"), "malformed 3:1");
  EXPECT_EQ(fails("00000000\n*\n"), "malformed 2:1");
  EXPECT_EQ(fails("00004040: 48\n"), "outside 1:1");
  EXPECT_EQ(fails("00004000: 48\n", {.bank = 1}), "outside 1:1");
  EXPECT_EQ(fails("00000000: 48\n*\nFFFFFFFF: 00\n"), "outside 3:1");
}

TEST(IntelHex, Records_AreReadByOffset) {
  // 0x0080: bank 2; 0x4001: register 0x41.
  const RegisterDump dump = good(":0200800001027B\n:0140010002BC\n:00000001FF\n");
  EXPECT_EQ(dump.bank(2)[1], 0x02);
  EXPECT_EQ(dump.direct_byte(0x41), 0x02);
  // Segment 8 is offset 0x80.
  EXPECT_EQ(good(":020000020008F4\n:010000002AD5\n:00000001FF\n").bank(2)[0], 0x2A);
}

TEST(IntelHex, Mistakes_AreNamedWithTheirPlace) {
  EXPECT_EQ(fails(":0200800001027C\n"), "checksum 1:1");
  EXPECT_EQ(fails(":0200800001027B\n"), "truncated 1:0");
  EXPECT_EQ(fails(":00000001FF\n:00000001FF\n"), "malformed 2:1");
  EXPECT_EQ(fails(":0300800001027B\n"), "malformed 1:1");
  EXPECT_EQ(fails(":0200800001G27B\n"), "malformed 1:12");
  EXPECT_EQ(fails(":020080000102 7B\n"), "malformed 1:1");
  EXPECT_EQ(fails(":00000006FA\n"), "malformed 1:1");
  EXPECT_EQ(fails(":020000040001F9\n:0100000001FE\n"), "outside 2:1");
  EXPECT_EQ(fails(":0100000001FE\n:0100000002FD\n"), "contradiction 2:1");
}

TEST(Json, AccessesMakeTheDump_BselSteersTheBank) {
  const RegisterDump dump = good(
      R"({"cycle":0,"time_ns":0,"id":0,"access":"read","address":65,"name":"EDS_BANK","data":"02","outcome":"ok"})"
      "\n"
      R"({"cycle":9,"time_ns":9,"id":0,"access":"write","address":64,"name":"BSEL","data":"02","outcome":"ok"})"
      "\n"
      R"({"cycle":9,"time_ns":9,"id":0,"access":"read","address":0,"name":"BANK","data":"0102 03","outcome":"ok"})"
      "\n"
      R"({"cycle":9,"time_ns":9,"id":0,"access":"read","address":16,"name":"BANK","data":null,"outcome":"refused"})"
      "\n"
      R"({"cycle":9,"time_ns":9,"id":null,"access":"command","address":null,"name":"x","data":null,"outcome":"ok"})"
      "\n");
  EXPECT_EQ(dump.direct_byte(0x41), 0x02);
  EXPECT_EQ(dump.bank(2)[2], 0x03);
  EXPECT_EQ(dump.bank(2)[16], std::nullopt);
}

std::string access(const char* kind, int address, const char* data, const char* outcome = "ok",
                   int id = 0) {
  return "{\"id\":" + std::to_string(id) + ",\"access\":\"" + kind +
         "\",\"address\":" + std::to_string(address) + ",\"data\":" + data + ",\"outcome\":\"" +
         outcome + "\"}\n";
}

TEST(Json, DataInEveryShape_MeansTheSame) {
  for (const char* data : {"\"6210\"", "\"0x6210\"", "\"62 10\"", "[98,16]", "[\"0x62\",16]"}) {
    EXPECT_EQ(good(access("read", 0x42, data)).direct_number(0x42, 2), 0x6210U) << data;
  }
  EXPECT_EQ(good(access("read", 0x42, "98")).direct_byte(0x42), 98);
}

TEST(Json, LaterAccess_Counts) {
  const RegisterDump dump = good(access("read", 0x48, "1") + access("write", 0x48, "2"));
  EXPECT_EQ(dump.direct_byte(0x48), 2);
}

TEST(Json, BankUnknownAfterADamagedWrite_IsNotGuessed) {
  const std::string reads = access("read", 0x48, "1") + access("read", 1, "7");
  const auto starts_with_0 = [](const std::string& text) { return good(text, {.bank = 0}); };
  EXPECT_EQ(starts_with_0(access("write", 0x40, "3", "refused") + reads).bank(0)[1], 7);
  EXPECT_EQ(starts_with_0(access("write", 0x40, "3", "echo") + reads).banks().has_value(), false);
  EXPECT_EQ(good(access("write", 0x40, "3", "echo") + access("read", 0x40, "3") + reads).bank(3)[1],
            7);
}

TEST(Json, BankBeforeTheFirstAccess_IsNotGuessed) {
  const std::string reads = access("read", 1, "[7,8]") + access("read", 1, "9");
  const RegisterDump unknown = good(reads + access("read", 0x42, "98"));
  EXPECT_FALSE(unknown.banks().has_value());
  EXPECT_EQ(unknown.without_bank, 2U);
  EXPECT_EQ(text_without_bank(unknown),
            "left out: 2 registers from 0x00 to 0x3F of which no access shows the bank (BSEL, "
            "0x40)");
  EXPECT_EQ(good(reads, {.bank = 5}).bank(5)[1], 9);
}

TEST(Json, ReadOfBsel_ShowsTheBankOfTheReadsBeforeIt) {
  const std::string reads = access("read", 1, "7");
  const RegisterDump read = good(reads + access("read", 0x40, "3"));
  EXPECT_EQ(read.bank(3)[1], 7);
  EXPECT_EQ(read.without_bank, 0U);
  const RegisterDump written = good(reads + access("write", 0x40, "3") + access("read", 0x40, "3"));
  EXPECT_FALSE(written.banks().has_value());
  EXPECT_EQ(written.without_bank, 1U);
  const RegisterDump doubtful =
      good(reads + access("write", 0x40, "3", "echo") + reads + access("read", 0x40, "3"));
  EXPECT_EQ(doubtful.bank(3)[1], 7);
  EXPECT_EQ(doubtful.without_bank, 1U);
}

TEST(Json, AccessOfUnknownKind_MayHaveWrittenBsel) {
  const std::string reads = access("read", 0x48, "1") + access("read", 1, "7");
  const auto starts_with_0 = [](const std::string& text) { return good(text, {.bank = 0}); };
  EXPECT_EQ(starts_with_0(access("unknown", 0x40, "null", "no_such_slave", 3) + reads).bank(0)[1],
            7);
  EXPECT_FALSE(
      starts_with_0(access("unknown", 0x40, "null", "rw_pattern") + reads).banks().has_value());
  const std::string damaged =
      R"({"id":null,"access":"unknown","address":null,"data":null,"outcome":"header_crc"})";
  EXPECT_EQ(starts_with_0(damaged + "\n" + reads).bank(0)[1], 7);
}

TEST(Json, SeveralSlaves_MustBeToldApart) {
  const std::string both = access("read", 0x42, "98") + access("read", 0x42, "99", "ok", 1);
  EXPECT_EQ(fails(both), "several_slaves 2:1");
  EXPECT_EQ(good(both, {.slave = 0}).direct_byte(0x42), 98);
  EXPECT_EQ(good(both, {.slave = 1}).direct_byte(0x42), 99);
  EXPECT_EQ(fails(both, {.slave = 2}), "nothing_read 0:0");
}

TEST(Json, Mistakes_AreNamedWithTheirPlace) {
  EXPECT_EQ(fails("{\"id\":0,\n"), "malformed 1:1");
  EXPECT_EQ(fails(access("read", 0, "1") + "[1]\n"), "malformed 2:1");
  EXPECT_EQ(fails(access("peek", 0, "1")), "malformed 1:1");
  EXPECT_EQ(fails(access("read", 128, "1")), "malformed 1:1");
  EXPECT_EQ(fails(access("read", -1, "1")), "malformed 1:1");
  EXPECT_EQ(fails(access("read", 0, "256")), "malformed 1:1");
  EXPECT_EQ(fails(access("read", 0, "\"123\"")), "malformed 1:1");
  EXPECT_EQ(fails(access("read", 0, "null")), "malformed 1:1");
  EXPECT_EQ(fails(access("read", 127, "[1,2]")), "outside 1:1");
  EXPECT_EQ(fails("{}"), "malformed 1:1");
}

TEST(Binary, SizesAndBanks) {
  const std::string bank(64, '\x05');
  EXPECT_EQ(good(bank).bank(0)[63], 5);
  EXPECT_EQ(good(bank + bank, {.bank = 254}).bank(255)[63], 5);
  EXPECT_EQ(fails(bank + bank, {.bank = 255}), "outside 0:0");
  EXPECT_EQ(fails(bank + "\x01"), "not_whole_banks 0:0");
  std::string all(257 * 64, '\x05');
  EXPECT_EQ(good(all).direct_byte(0x7F), 5);
  EXPECT_EQ(fails(all + bank), "outside 0:0");
}

TEST(Read, WhatIsNoDump_IsNamed) {
  EXPECT_EQ(fails(""), "empty 0:0");
  EXPECT_EQ(fails(" \n# nothing\n"), "empty 0:0");
  EXPECT_EQ(fails("time_ns,MA,SLO\n0,1,1\n"), "unknown_format 0:0");
  EXPECT_EQ(fails("$timescale 1ps $end\n"), "unknown_format 0:0");
  EXPECT_EQ(fails("0x00: 00\n#" + std::string(20'000, 'x') + "\n"), "line_too_long 2:0");
}

TEST(Read, LinesAcrossTheBlocksOfAStream_StayWhole) {
  std::string text;
  unsigned line = 0;
  for (; text.size() < 300'000; ++line) {
    text += access("read", 0x48, ("[" + std::to_string(line % 251) + "]").c_str());
  }
  EXPECT_EQ(good(text).direct_byte(0x48), (line - 1) % 251);
  EXPECT_EQ(fails(text + "x\n"), "malformed " + std::to_string(line + 1) + ":1");
  // A line that is one byte longer than a block's rest at a time.
  for (std::size_t size = 4'000; size < 4'200; ++size) {
    EXPECT_EQ(fails("0x00: 01\n#" + std::string(size, 'x') + "\nx\n"), "malformed 3:1") << size;
  }
}

TEST(Read, TextOfError_SaysWhereAndWhatInstead) {
  const DumpResult result = from_text("0x00: 48 zz\n");
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(dump_error_text(result.error()),
            "read as hex text: line 1, column 10: malformed; expected two hexadecimal digits, -- "
            "or x and a count");
  EXPECT_EQ(dump_error_text(from_text("\x01\x02").error()),
            "read as binary banks of 64 bytes: the size is not a multiple of 64 bytes");
}

// 4096 bytes were taken for banks, because their number is a multiple of 64.
TEST(Read, LongText_IsNotABinaryOfBanks) {
  const std::string line = "An open toolkit for the BiSS C encoder interface, in plain English.\n";
  std::string text;
  while (text.size() < 3 * head_bytes) text += line;
  EXPECT_EQ(fails(text), "unknown_format 0:0");
  EXPECT_EQ(good(std::string(2 * 64, 'x')).bank(1)[63], 'x');
}

}  // namespace read_test
}  // namespace biss::dump
