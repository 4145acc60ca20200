// biss eds, run as by a shell.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "capture/test_folder.hpp"
#include "cli/test_verb_harness.hpp"

namespace biss::verbs {
namespace eds_test {

using testing::HasSubstr;
using testing::Not;

const char* const description =
    "[registers]\nEDS_BANK = 2\nMFR_ID = 0x6943\n"
    "[common]\nTMA = 100ns\nTBUSY_MAX = 10us?\nTO_MAX = 20us?\n"
    "[bp3]\nPON_PDL = 50ms\nMT_LEN = 12\nMT_CNT = 4096\nFI_LEN = 18\nSIP_CNT = 1\n"
    "SIP_RES = 262144\n";

class Eds : public testing::Test {
 protected:
  Eds() { write("encoder.eds", description); }

  std::string path(const std::string& name) const { return folder_.path(name); }
  void write(const std::string& name, const std::string& text) const { folder_.file(name, text); }
  std::string text(const std::string& name) const { return test::content_of(path(name)); }
  static Ran eds(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "eds");
    return run_verb(arguments);
  }
  void build(const std::string& name) const {
    const Ran ran = eds({"build", path("encoder.eds"), "-o", path(name)});
    ASSERT_EQ(ran.status, ExitStatus::done) << ran.err;
  }
  /// The hex text with one byte of a bank changed.
  void damage(const std::string& from, const std::string& to, unsigned offset, char byte) const {
    std::string bytes = text(from);
    bytes.at(offset) = byte;
    write(to, bytes);
  }

 private:
  const test::Folder folder_;
};

TEST_F(Eds, Build_WritesEveryFormat_AndAllReadBackToTheSame) {
  for (const char* name : {"e.hex", "e.bin", "e.ihex"}) {
    build(name);
    const Ran shown = eds({"show", path(name), "--to", "description", "-o", path("back.eds")});
    ASSERT_EQ(shown.status, ExitStatus::done) << shown.err;
    const std::string again =
        std::string("again") + std::filesystem::path(name).extension().string();
    const Ran built = eds({"build", path("back.eds"), "-o", path(again)});
    ASSERT_EQ(built.status, ExitStatus::done) << built.err;
    EXPECT_EQ(text(again), text(name));
  }
  EXPECT_EQ(text("e.bin").size(), 4U * 64U);
  EXPECT_EQ(eds({"build", path("encoder.eds"), "-o", path("f.bin"), "--bank", "2"}).status,
            ExitStatus::done);
  EXPECT_EQ(text("f.bin"), text("e.bin").substr(128));
  const Ran c = eds({"build", path("encoder.eds"), "--to", "c", "--name", "my_eds"});
  EXPECT_THAT(c.out, HasSubstr("const unsigned char my_eds[256] = {"));
}

TEST_F(Eds, FileOfAnotherKind_IsNamedWithTheKnownKinds) {
  std::string page = "# biss\n\nAn open toolkit for the BiSS C encoder interface.\n";
  while (page.size() < 3 * 4096) page += "One more line of text that is not a dump.\n";
  write("README.md", page);
  const Ran text = eds({"show", path("README.md")});
  EXPECT_EQ(text.status, ExitStatus::io);
  EXPECT_THAT(text.err, HasSubstr("is text, but not a dump of registers; the known kinds are hex "
                                  "text (0x40: 00 1A), xxd or hexdump -C, Intel HEX"));
  EXPECT_THAT(text.err, HasSubstr("and descriptions ([common], TMA = 100ns)"));
  write("photo.png", "\x89PNG\r\n\x1A\n");
  EXPECT_THAT(eds({"show", path("photo.png")}).err,
              HasSubstr("read as binary banks of 64 bytes: the size is not a multiple of 64 bytes; "
                        "the known kinds are"));
  write("wrong.hex", "0x40: 00 zz\n");
  EXPECT_THAT(eds({"show", path("wrong.hex")}).err,
              HasSubstr("read as hex text: line 1, column 10: malformed"));
  write("wrong.eds", "[common]\nTMX = 1\n");
  EXPECT_THAT(eds({"show", path("wrong.eds")}).err, HasSubstr("read as a description: line 2:"));
}

TEST_F(Eds, AdviseWithoutLengths_SaysWhatToGive) {
  const Ran alone = eds({"advise"});
  EXPECT_EQ(alone.status, ExitStatus::usage);
  EXPECT_THAT(
      alone.err,
      HasSubstr("give the lengths that the encoder sends, --resolution and --turns in bits, "
                "or a FILE with its BP3 part"));
  EXPECT_THAT(alone.err, HasSubstr("biss eds advise --resolution 18 --turns 12"));
  EXPECT_EQ(eds({"advise", "--resolution", "18", "--turns", "12"}).status, ExitStatus::done);
  write("common.eds", "[common]\nTMA = 100ns\n");
  const Ran common = eds({"advise", path("common.eds")});
  EXPECT_EQ(common.status, ExitStatus::usage);
  EXPECT_THAT(common.err, HasSubstr("has no BP3 part of data channel 0 with lengths"));
}

TEST_F(Eds, BuildWithAContradiction_WritesNothingUnlessForced) {
  write("wrong.eds", std::string(description) + "BP_ID = 0x6210\n");
  const Ran ran = eds({"build", path("wrong.eds"), "-o", path("w.hex")});
  EXPECT_EQ(ran.status, ExitStatus::data_failed);
  EXPECT_THAT(ran.err,
              HasSubstr("bp3 of channel 0: BP_ID: not the same as the registers 0x42 and 0x43 "
                        "(25104, expected 25120)"));
  EXPECT_FALSE(std::filesystem::exists(path("w.hex")));
  EXPECT_EQ(eds({"build", path("wrong.eds"), "-o", path("w.hex"), "--force"}).status,
            ExitStatus::done);
  EXPECT_EQ(eds({"check", path("w.hex")}).status, ExitStatus::data_failed);
}

TEST_F(Eds, BuildOfPartsToWhichNoRegisterLeads_ChecksThem) {
  const std::string part = "[bp3]\nPON_PDL = 1\nFI_LEN = 18\n";
  const auto built = [this](const std::string& text) {
    write("part.eds", text);
    return eds({"build", path("part.eds")});
  };
  const std::string bank = "[bank 5]\n0x00 = 01\n";
  EXPECT_EQ(built(part + bank).status, ExitStatus::done);
  const Ran lone = built(part + "BP_ID = 0x6210\n" + bank);
  EXPECT_EQ(lone.status, ExitStatus::data_failed);
  EXPECT_THAT(lone.err, HasSubstr("bp3 of channel 0: "));
  const Ran last = built("[registers]\nEDS_BANK = 0xFF\n[common]\nTMA = 100ns\nCHKSUM = 1\n");
  EXPECT_EQ(last.status, ExitStatus::data_failed);
  EXPECT_THAT(last.err, HasSubstr("common: CHKSUM: "));
  const Ran none = built("[registers]\nEDS_BANK = 0\n[common]\nTMA = 100ns\n" + part);
  EXPECT_EQ(none.status, ExitStatus::io);
  EXPECT_THAT(none.err, HasSubstr("EDS_BANK = 0 means that there is no data sheet"));
}

TEST_F(Eds, ShowAsJsonLines_HasAnObjectAPart) {
  build("e.hex");
  const Ran ran = eds({"show", path("e.hex"), "--to", "jsonl"});
  ASSERT_EQ(ran.status, ExitStatus::done) << ran.err;
  std::istringstream lines(ran.out);
  std::string line;
  ASSERT_TRUE(std::getline(lines, line));
  const auto common = nlohmann::json::parse(line);
  EXPECT_EQ(common["part"], "common");
  EXPECT_EQ(common["TMA"], 100);
  EXPECT_EQ(common["BANK_0"], 3);
  EXPECT_EQ(common["bank"], 2);
  EXPECT_FALSE(common.contains("RES_35"));
  ASSERT_TRUE(std::getline(lines, line));
  const auto bp3 = nlohmann::json::parse(line);
  EXPECT_EQ(bp3["part"], "bp3");
  EXPECT_EQ(bp3["BP_ID"], 0x6220);
  EXPECT_EQ(bp3["SIP_RES"], 262144);
  EXPECT_EQ(bp3["channel"], 0);
  EXPECT_FALSE(std::getline(lines, line));
}

TEST_F(Eds, ShowForEyes_MarksHypothesesAndNamesTheFrame) {
  const Ran ran = eds({"show", path("encoder.eds")});
  EXPECT_EQ(ran.status, ExitStatus::done);
  EXPECT_THAT(ran.out, HasSubstr("20 us ?"));
  EXPECT_THAT(ran.out, HasSubstr("100 ns"));
  EXPECT_THAT(ran.out, Not(HasSubstr("RES_35")));
  EXPECT_THAT(ran.err, HasSubstr("mt12,st18,nE,nW,crc6"));
  EXPECT_THAT(ran.err, HasSubstr("no source confirms the unit"));
  EXPECT_THAT(eds({"show", path("encoder.eds"), "--all"}).out, HasSubstr("RES_35"));
}

TEST_F(Eds, CheckOfADamagedBank_HasTheContractsRow) {
  build("e.bin");
  EXPECT_EQ(eds({"check", path("e.bin")}).status, ExitStatus::done);
  EXPECT_EQ(eds({"check", path("e.bin"), "--to", "jsonl"}).out, "");
  damage("e.bin", "d.bin", 3 * 64 + 0x3F, '\x01');
  const Ran ran = eds({"check", path("d.bin"), "--to", "jsonl"});
  EXPECT_EQ(ran.status, ExitStatus::data_failed);
  EXPECT_THAT(ran.out, testing::StartsWith("{\"part\":\"bp3\",\"symbol\":\"CHKSUM\",\"problem\":"
                                           "\"checksum\",\"value\":1,\"channel\":0,"));
}

TEST_F(Eds, CheckAgainstRegisters_TakesThoseOfTheDumpOrTheOption) {
  build("e.hex");
  EXPECT_EQ(eds({"check", path("e.hex")}).status, ExitStatus::done);
  const Ran ran = eds({"check", path("e.hex"), "--id", "0x6221", "--to", "jsonl"});
  EXPECT_EQ(ran.status, ExitStatus::data_failed);
  EXPECT_THAT(ran.out,
              HasSubstr("\"symbol\":\"BP_ID\",\"problem\":\"identifier\",\"value\":25120"));
}

TEST_F(Eds, Check_NamesAWrongBitC) {
  write("standard.eds", std::string(description) + "BP_ID = 0x6326\n");
  const Ran standard = eds({"check", path("standard.eds"), "--to", "jsonl"});
  EXPECT_EQ(standard.status, ExitStatus::data_failed);
  EXPECT_THAT(standard.out, HasSubstr("\"symbol\":\"BP_ID\",\"problem\":\"crc_bit\""));
  EXPECT_THAT(standard.out, HasSubstr("1 in a safety encoder, and 0 in a standard encoder"));
  std::string other = "[bank 4]\n0x00 = 01 01 73 30\n";
  for (unsigned i = 4; i < 63; ++i)
    other += "0x" + std::string(1, "0123"[i / 16]) + "0123456789ABCDEF"[i % 16] + " = 00\n";
  other += "0x3F = A5\n";
  write("safety.eds", std::string(description) + other +
                          "[common]\nDC_NUM = 2\nSL_NUM = 2\nEDS_LEN = 3\nBANK_1 = 4\n"
                          "DLEN_1 = 32\n");
  const Ran safety = eds({"check", path("safety.eds"), "--to", "jsonl"});
  EXPECT_EQ(safety.status, ExitStatus::data_failed) << safety.err;
  EXPECT_THAT(safety.out, HasSubstr("\"problem\":\"crc_bit\",\"value\":25120"));
}

TEST_F(Eds, LengthsThatFitTheOtherReadingOfDl_AreNamedAndFollowed) {
  write("part.eds",
        "[bp3]\nBP_ID = 0x6320\nPON_PDL = 1\nMT_LEN = 12\nMT_CNT = 4096\nFI_LEN = 18\n");
  const Ran checked = eds({"check", path("part.eds"), "--to", "jsonl"});
  EXPECT_EQ(checked.status, ExitStatus::data_failed);
  EXPECT_THAT(checked.out, HasSubstr("\"problem\":\"length_reading\",\"value\":25376"));
  EXPECT_THAT(checked.out, HasSubstr("\"expected\":25382"));
  EXPECT_THAT(checked.out, HasSubstr("table 5 adds the CRC bits"));
  EXPECT_THAT(checked.out, HasSubstr("table 6 says"));
  const Ran shown = eds({"show", path("part.eds")});
  EXPECT_THAT(shown.err, HasSubstr("mt12,st18,nE,nW,crc6"));
  EXPECT_THAT(shown.err, HasSubstr("BP_ID of channel 0: whether DL counts the CRC"));
}

TEST_F(Eds, Alignment_PlacesThePaddingAndIsCheckedAgainstBp3) {
  const std::string part =
      "[bp3]\nPON_PDL = 1\nMT_LEN = 12\nMT_CNT = 256\nFI_LEN = 18\n"
      "SIP_CNT = 1\nSIP_RES = 65536\n";
  write("good.eds", part + "FI_FMT = left\n");
  EXPECT_EQ(eds({"check", path("good.eds")}).status, ExitStatus::done);
  EXPECT_THAT(eds({"show", path("good.eds")}).err, HasSubstr("pad4,mt8,st16,pad2,nE,nW,crc6"));
  write("wrong.eds", part + "MT_FMT = left\n");
  EXPECT_THAT(eds({"show", path("wrong.eds")}).err, HasSubstr("mt8,pad6,st16,nE,nW,crc6"));
  const Ran wrong = eds({"check", path("wrong.eds"), "--to", "jsonl"});
  EXPECT_EQ(wrong.status, ExitStatus::data_failed);
  EXPECT_THAT(wrong.out, HasSubstr("\"symbol\":\"MT_FMT\",\"problem\":\"alignment\""));
  EXPECT_THAT(wrong.out, HasSubstr("\"symbol\":\"FI_FMT\",\"problem\":\"alignment\""));
}

TEST_F(Eds, PowerOnDelayOutsideItsRange_IsARemark) {
  for (const std::string value : {"0", "255"}) {
    write("part.eds", "[bp3]\nFI_LEN = 18\nPON_PDL = " + value + "\n");
    const Ran checked = eds({"check", path("part.eds")});
    EXPECT_EQ(checked.status, ExitStatus::done);
    EXPECT_THAT(checked.err,
                HasSubstr("PON_PDL of channel 0 is " + value + ", outside 1 to 254 ms"));
    const Ran strict = eds({"check", path("part.eds"), "--strict"});
    EXPECT_EQ(strict.status, ExitStatus::data_failed);
    EXPECT_THAT(strict.out, HasSubstr("PON_PDL"));
    EXPECT_THAT(strict.err, Not(HasSubstr("PON_PDL")));
  }
  EXPECT_THAT(eds({"check", path("encoder.eds")}).err, Not(HasSubstr("PON_PDL")));
}

TEST_F(Eds, CheckOfABankWithHoles_SaysIncomplete) {
  write("holes.hex", "bank 0\n0x00: 01 01 62 20\n");
  const Ran ran = eds({"check", path("holes.hex"), "--to", "jsonl"});
  EXPECT_EQ(ran.status, ExitStatus::data_failed);
  EXPECT_THAT(ran.out, HasSubstr("\"symbol\":\"FB1\",\"problem\":\"incomplete\",\"value\":null"));
}

TEST_F(Eds, CheckWithoutTheBankOfAChannel_SaysIncomplete) {
  build("e.hex");
  const std::string whole = text("e.hex");
  const std::size_t from = whole.find("bank 3\n");
  write("half.hex", whole.substr(0, from) + whole.substr(whole.find("0x40:")));
  const Ran ran = eds({"check", path("half.hex"), "--to", "jsonl"});
  EXPECT_EQ(ran.status, ExitStatus::data_failed);
  EXPECT_THAT(ran.out, testing::StartsWith("{\"part\":\"common\",\"symbol\":\"BANK_0\","
                                           "\"problem\":\"incomplete\",\"value\":3,"));
  EXPECT_THAT(ran.out, HasSubstr("the bank of channel 0 is not in the dump"));
}

TEST_F(Eds, SingleProfileBank_IsJudgedAlone) {
  build("e.bin");
  write("bp3.bin", text("e.bin").substr(3 * 64, 64));
  const Ran ran = eds({"check", path("bp3.bin")});
  EXPECT_EQ(ran.status, ExitStatus::done) << ran.out;
  EXPECT_THAT(ran.err, HasSubstr("the common part is not in the dump"));
  EXPECT_THAT(eds({"show", path("bp3.bin")}).out, HasSubstr("MT_LEN"));
}

TEST_F(Eds, Override_ReplacesAndReportsWhatDisagrees) {
  build("e.hex");
  const Ran shown =
      eds({"show", path("e.hex"), "--override", "MT_LEN=10", "--override", "TMA=200ns"});
  EXPECT_EQ(shown.status, ExitStatus::done) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("200 ns"));
  EXPECT_THAT(shown.err, HasSubstr("MT_LEN of channel 0: overridden by hand (12 stored, 10 used)"));
  EXPECT_THAT(shown.err, HasSubstr("at most 5 MHz"));
  const Ran checked = eds({"check", path("e.hex"), "--override", "bp3.MT_LEN=10"});
  EXPECT_EQ(checked.status, ExitStatus::data_failed);
  EXPECT_THAT(checked.out, HasSubstr("lengths"));
  EXPECT_THAT(checked.out, Not(HasSubstr("checksum")));
}

TEST_F(Eds, OverrideWithMorePeriodsThanFit_IsNoByteOrder) {
  build("e.hex");
  const Ran ran = eds({"check", path("e.hex"), "--override", "bp3.0.SIP_CNT=2", "--to", "csv"});
  EXPECT_EQ(ran.status, ExitStatus::data_failed);
  EXPECT_THAT(ran.out, HasSubstr("bp3,SIP_CNT,count_above_length,2,0,SIP_RES,262144,"));
  EXPECT_THAT(ran.out, Not(HasSubstr("little_endian")));
}

TEST_F(Eds, OverrideThatCannotBe_IsWrongUsage) {
  for (const char* text : {"MT_LEN", "MT_LEX=1", "MT_LEN=abc", "MT_LEN=256", "bp3.1.MT_LEN=2",
                           "TO_MAX=20us", "common.MT_LEN=1"}) {
    SCOPED_TRACE(text);
    expect_wrong_usage(eds({"show", path("encoder.eds"), "--override", text}));
  }
}

TEST_F(Eds, Diff_NamesSymbolsAndExitsWithOne) {
  build("e.hex");
  build("e.bin");
  EXPECT_EQ(eds({"diff", path("e.hex"), path("encoder.eds")}).status, ExitStatus::done);
  const Ran same = eds({"diff", path("e.hex"), path("e.bin")});
  EXPECT_EQ(same.status, ExitStatus::done) << same.out;
  write("other.eds", std::string(description) + "CUR_MAX = 100 mA\n");
  const Ran ran = eds({"diff", path("e.hex"), path("other.eds"), "--to", "csv"});
  EXPECT_EQ(ran.status, ExitStatus::data_failed);
  EXPECT_THAT(ran.out, testing::StartsWith("part,symbol,a,b,means_a,means_b\n"
                                           "bp3,CUR_MAX,0,100,not given ?,100 mA\n"
                                           "bp3,CHKSUM,"));
}

TEST_F(Eds, DiffOfAFieldThatIsPartlyKnown_ComparesItsBytes) {
  write("p1.hex", "0x40: -- -- 62\n");
  write("p2.hex", "0x40: -- -- 72\n");
  write("p3.hex", "0x40: -- -- 62 1E\n");
  const auto diff = [this](const std::string& a, const std::string& b) {
    return eds({"diff", path(a), path(b), "--to", "csv"});
  };
  const std::string head = "part,symbol,a,b,means_a,means_b\n";
  EXPECT_EQ(diff("p1.hex", "p2.hex").status, ExitStatus::data_failed);
  EXPECT_EQ(diff("p1.hex", "p2.hex").out, head + "registers,0x42,98,114,,\n");
  EXPECT_EQ(diff("p1.hex", "p3.hex").out, head + "registers,0x43,,30,,\n");
  EXPECT_EQ(diff("p1.hex", "p1.hex").status, ExitStatus::done);
  write("q1.hex", "bank 1\n0x0E: 00\n0x40: -- 01\n");
  write("q2.hex", "bank 1\n0x0E: 01\n0x40: -- 01\n");
  EXPECT_EQ(diff("q1.hex", "q2.hex").status, ExitStatus::data_failed);
  EXPECT_EQ(diff("q1.hex", "q2.hex").out, head + "common,0x0E,0,1,,\n");
}

TEST_F(Eds, NameThatCOrCppRefuses_IsWrongUsage) {
  for (const std::string word : {"int", "class", "xor_eq"}) {
    const Ran ran = eds({"build", path("encoder.eds"), "--to", "c", "--name", word});
    EXPECT_EQ(ran.status, ExitStatus::usage);
    EXPECT_THAT(ran.err, HasSubstr("--name '" + word + "': a reserved word of C or C++"));
  }
  EXPECT_EQ(eds({"build", path("encoder.eds"), "--to", "c", "--name", "int_"}).status,
            ExitStatus::done);
}

TEST_F(Eds, Advise_TellsTheFrameAndWhetherTheRateIsFeasible) {
  const Ran ran = eds({"advise", "--resolution", "18", "--turns", "12", "--rate", "16kHz",
                       "--ack-max", "10us", "--timeout", "adaptive", "--clock", "10MHz"});
  EXPECT_EQ(ran.status, ExitStatus::done) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("mt12,st18,nE,nW,crc6"));
  EXPECT_THAT(ran.out, HasSubstr("BP_ID 0x6220"));
  EXPECT_THAT(ran.out, HasSubstr("is feasible"));
  EXPECT_EQ(eds({"advise", "--resolution", "18", "--rate", "100kHz"}).status,
            ExitStatus::data_failed);
  EXPECT_EQ(eds({"advise"}).status, ExitStatus::usage);
  EXPECT_EQ(eds({"advise", "--resolution", "64"}).status, ExitStatus::usage);
}

TEST_F(Eds, AdviceAsDescription_CanBeBuilt) {
  const Ran ran = eds({"advise", "--resolution", "16", "--turns", "12", "--resolution-field", "18",
                       "--to", "description", "-o", path("part.eds")});
  ASSERT_EQ(ran.status, ExitStatus::done) << ran.err;
  write("whole.eds", text("part.eds") + "[common]\nTMA = 100ns\n");
  const Ran built = eds({"build", path("whole.eds"), "-o", path("whole.hex")});
  EXPECT_EQ(built.status, ExitStatus::done) << built.err;
  EXPECT_THAT(eds({"show", path("whole.hex")}).err, HasSubstr("mt12,st16,pad2,nE,nW,crc6"));
}

TEST_F(Eds, AdviceOfADataSheet_TakesItsLengthsAndTimes) {
  const Ran ran = eds({"advise", path("encoder.eds"), "--rate", "10kHz", "--to", "jsonl"});
  EXPECT_EQ(ran.status, ExitStatus::done) << ran.err;
  const auto object = nlohmann::json::parse(ran.out);
  EXPECT_EQ(object["format"], "mt12,st18,nE,nW,crc6");
  EXPECT_EQ(object["bp_id"], 0x6220);
  EXPECT_EQ(object["min_distance"], 3);
  EXPECT_EQ(object["feasible"], 1);
}

TEST_F(Eds, AdviceOfADataSheetWithC_KeepsIt) {
  for (const std::string registers : {"", "[registers]\nBP_ID = 0x6326\n"}) {
    const std::string bp_id = registers.empty() ? "BP_ID = 0x6326\n" : "BP_ID = 0x6220\n";
    write("c.eds", registers + "[bp3]\n" + bp_id + "MT_LEN = 12\nMT_CNT = 4096\nFI_LEN = 18\n");
    const Ran ran = eds({"advise", path("c.eds"), "--to", "jsonl"});
    EXPECT_EQ(ran.status, ExitStatus::done) << ran.err;
    EXPECT_EQ(nlohmann::json::parse(ran.out)["bp_id"], 0x6326);
  }
}

TEST_F(Eds, DeviceWhoseDataSheetWasNotRead_IsNamed) {
  write("page.hex", "0x00: 48 44\n0x40: 00 02 62 1E\n");
  const Ran ran = eds({"show", path("page.hex")});
  EXPECT_EQ(ran.status, ExitStatus::data_failed);
  EXPECT_THAT(ran.err, HasSubstr("places the data sheet in bank 2"));
  EXPECT_THAT(eds({"show", path("page.hex"), "--to", "description"}).out,
              HasSubstr("BP_ID = 0x621E"));
  write("none.hex", "0x40: 00 00 62 1E\n");
  EXPECT_THAT(eds({"check", path("none.hex")}).err, HasSubstr("the device has no data sheet"));
}

TEST_F(Eds, AccessesBeforeTheBankIsKnown_AreLeftOutWithAMessage) {
  const std::string read = R"({"id":0,"access":"read","address":1,"data":"07","outcome":"ok"})";
  write("rows.jsonl", read + "\n");
  const Ran unknown = eds({"show", path("rows.jsonl"), "--to", "description"});
  EXPECT_THAT(unknown.err, HasSubstr("left out: 1 register from 0x00 to 0x3F of which no access "
                                     "shows the bank (BSEL, 0x40)\n"));
  EXPECT_THAT(unknown.out, Not(HasSubstr("[bank")));
  const Ran given = eds({"show", path("rows.jsonl"), "--to", "description", "--bank", "3"});
  EXPECT_THAT(given.out, HasSubstr("[bank 3]"));
  EXPECT_THAT(given.err, Not(HasSubstr("left out")));
}

TEST_F(Eds, EdsBankThatIsNotInTheDump_IsNamed) {
  build("e.hex");
  const Ran ran = eds({"show", path("e.hex"), "--eds-bank", "7"});
  EXPECT_EQ(ran.status, ExitStatus::data_failed);
  EXPECT_THAT(ran.err, HasSubstr("--eds-bank 7: this bank is not in the dump"));
}

TEST_F(Eds, UnreadableInput_IsOneLineAndStatus3) {
  write("bad.hex", "0x00: 4\n");
  write("bad.eds", "[bp3]\nMT = 1\n");
  for (const char* name : {"bad.hex", "bad.eds", "missing.hex", ""}) {
    const Ran ran = eds({"show", path(name)});
    EXPECT_EQ(ran.status, ExitStatus::io) << name;
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
  }
  EXPECT_THAT(eds({"show", path("bad.eds")}).err, HasSubstr("line 2: this part has no 'MT'"));
}

TEST_F(Eds, WrongUsage_NamesTheVerbBelow) {
  EXPECT_THAT(eds({}).err, HasSubstr("no verb given (see 'biss eds --help')"));
  EXPECT_THAT(eds({"shw"}).err, HasSubstr("unknown verb 'shw'; did you mean 'show'?"));
  EXPECT_THAT(eds({"show", "--overide", "x"}).err,
              HasSubstr("did you mean '--override'? (see 'biss eds show --help')"));
  EXPECT_THAT(eds({"build", "--help"}).out, HasSubstr("biss eds build encoder.eds -o encoder.bin"));
  for (const auto& ran : {eds({}), eds({"shw"}), eds({"show"})}) {
    EXPECT_EQ(ran.status, ExitStatus::usage);
  }
}

}  // namespace eds_test
}  // namespace biss::verbs
