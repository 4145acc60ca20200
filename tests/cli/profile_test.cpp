// Formats from profile identifiers and data sheets, on captures of the simulator.
#include "tests/cli/run_command.hpp"

namespace biss::verbs::profile_test {

using ConfiguringMaster = InFolder;
// The rows with a status or, where `column` is given, a value.
std::size_t count(const std::vector<Row>& rows, const std::string& value,
                  const std::string& column = "status") {
  return static_cast<std::size_t>(std::count_if(
      rows.begin(), rows.end(), [&](const Row& row) { return row.at(column) == value; }));
}

std::vector<Row> decoded(const std::string& capture, const std::string& format) {
  return rows_of(run_ok("decode {} -f {} --to csv", capture, format).out);
}

TEST(ProfileIdentifier, WithC_DamagedFramesHaveTheStatusCrc) {
  const Folder folder;
  const std::string capture = folder.path("line.vcd");
  const Words encoder("simulate -f pos22,nE,nW,crc6 --cycles 200 -o {}", capture);
  run_ok(encoder);
  EXPECT_EQ(count(decoded(capture, "bp3:0x631E"), "ok"), 200U);
  run_ok(encoder + Words("--fault flip:1"));
  const auto rows = decoded(capture, "bp3:0x631E");
  EXPECT_EQ(count(rows, "crc"), 200U);
  EXPECT_EQ(count(rows, "", "position"), 200U);
}

TEST(ProfileIdentifier, OfSafetyWordWithC_ChecksItsCrc16) {
  const Folder folder;
  const std::string capture = folder.path("line.vcd");
  run_ok("simulate -f pos24,nE,nW,lc6,crc16 --cycles 100 --fault flip:1 -o {}", capture);
  EXPECT_EQ(count(decoded(capture, "bp3:0x7330"), "crc"), 100U);
}

// A control word of 12-bit turns in 12 bits and 14 of 16 singleturn bits, beside a safety word.
constexpr const char* safety_sheet =
    "[registers]\nEDS_BANK = 1\n"
    "[common]\nTMA = 100ns\nEDS_LEN = 3\nDC_NUM = 2\nSL_NUM = 2\nSL_OFF = 1\n"
    "BANK_0 = 2\nDLEN_0 = 32\nBANK_1 = 3\n"
    "[bp3 1]\nBP_ID = 0x6324\nPON_PDL = 50ms\nMT_LEN = 12\nMT_CNT = 4096\n"
    "FI_LEN = 16\nFI_FMT = left\nSIP_CNT = 1\nSIP_RES = 16384\n";

// The encoder's faults begin after the configuration, whose rows come first.
TEST_F(ConfiguringMaster, SafetyEncoderWithC_ChecksBothCrcs) {
  const std::string capture = folder.path("line.vcd");
  const std::string safety_word = folder.file("spw.txt", "0x40: 00 00 73 30\n");
  const std::string safety_format = "pos24,nE,nW,lc6,crc16";
  struct Case {
    std::string control_word;
    std::string format;
  };
  const std::vector<Case> cases{
      {folder.file("cpw.txt", "0x40: 00 00 63 24\n"), "pos28,nE,nW,crc6+" + safety_format},
      {folder.file("cpw.eds", safety_sheet), "mt12,st14,pad2,nE,nW,crc6+" + safety_format}};
  for (const Case& each : cases) {
    const Words words("simulate -f {} --slaves 2 --registers {} --registers {} --configure -o {}",
                      "mt12,st14,pad2,nE,nW,crc6+" + safety_format, safety_word, each.control_word,
                      capture);
    EXPECT_THAT(run_ok(words).err, testing::HasSubstr("\nformat          " + each.format + " "));
    const auto expect_last_100 = [&](const std::string& status) {
      const auto rows = decoded(capture, each.format);
      ASSERT_GT(rows.size(), 100U);
      EXPECT_EQ(count({rows.end() - 100, rows.end()}, status), 100U);
    };
    expect_last_100("ok");
    run_ok(words + Words("--fault flip:1"));
    expect_last_100("crc");
  }
}

}  // namespace biss::verbs::profile_test
