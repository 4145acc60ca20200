// Control communication together with the positions, as simulated by `biss simulate`.
#include <cstddef>

#include "tests/cli/run_command.hpp"

namespace biss::verbs::control_test {

using ConfiguringMaster = InFolder;
using testing::HasSubstr;

// The registers of an iC-MHM in iC-Haus' application note AN22: BP3 with 28 bits of position,
// EDS_BANK names a bank that is not shown.
constexpr const char* mhm_page =
    "0x00: 48 44 00 78 80 00 00 00 CF 80 00 00 23 00 00 00\n"
    "0x10: 00 00 00 8C -- -- -- -- -- -- -- -- -- -- -- --\n"
    "0x20: -- x16\n"
    "0x30: -- x16\n"
    "0x40: 00 02 62 1E FF FF FF FF 00 00 00 00 00 00 8C FF\n"
    "0x50: FF x16\n"
    "0x60: FF x16\n"
    "0x70: 00 01 15 15 -- -- -- -- 4D 48 4D 23 44 00 69 43\n";

// Each cycle is right, at the time of the truth file.
void expect_cycles(const std::vector<Row>& rows, const std::vector<Row>& meant) {
  expect_truth(rows, meant);
  for (std::size_t i = 0; i < rows.size() && i < meant.size(); ++i) {
    EXPECT_EQ(rows[i].at("time_ns"), meant[i].at("time_ns")) << i;
  }
}

class SimulatedRegisters : public testing::Test {
 protected:
  // Simulates with an iC-MHM's registers; the capture is line.vcd.
  Outcome simulate(const Words& more) const {
    return run(Words("simulate --registers {} -o {} --truth {}", page, capture, truth) + more);
  }
  std::vector<Row> outcomes_of(const Words& more) const {
    return rows_of(ok(simulate(more + Words("--outcomes -"))).out);
  }
  // The rows of the capture, after a check that each is right.
  std::vector<Row> expect_right(const std::string& format) const {
    const Outcome read = run_ok("decode {} -f {} --to csv", capture, format);
    const auto rows = rows_of(read.out);
    expect_cycles(rows, rows_of(content_of(truth)));
    return rows;
  }

  Folder folder;
  std::string page = folder.file("mhm.txt", mhm_page);
  std::string capture = folder.path("line.vcd");
  std::string truth = folder.path("truth.csv");
};

TEST_F(SimulatedRegisters, ProfileIdentifier_IsReadOverTheWireAndIsTheFormat) {
  const auto rows = outcomes_of("--access read:0x42,2 --access read:0x78,8");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].at("id"), "0");
  EXPECT_EQ(rows[0].at("access"), "read");
  EXPECT_EQ(rows[0].at("address"), "0x42");
  EXPECT_EQ(rows[0].at("name"), "BP_ID");
  EXPECT_EQ(rows[0].at("data"), "62 1E");
  EXPECT_EQ(rows[0].at("outcome"), "ok");
  EXPECT_EQ(rows[0].at("cycle"), "0");
  EXPECT_EQ(rows[0].at("cycles"), "61");
  EXPECT_EQ(rows[1].at("data"), "4D 48 4D 23 44 00 69 43");
  // 33 + 14 · 2 frames, then 33 + 14 · 8 without the 14 zeros that end the first read, then 14
  // zeros.
  EXPECT_EQ(rows[1].at("cycles"), "131");
  EXPECT_EQ(expect_right("pos28,nE,nW,crc6").size(), 61U + 131U + 14U);
}

TEST_F(SimulatedRegisters, TrafficAtTheHighestRate_DelaysNoRequest) {
  const Words line("--clock 10MHz --cable 30m --motion random --cycles 5000");
  const Words accesses(
      "--access read:0x42,50 --access write:0x48=000102030405060708090A0B0C0D0E0F "
      "--access read:0,20 --access 0/command:user --access read:0x20");
  ASSERT_EQ(simulate(line + accesses).status, 0);
  expect_right("bp3:0x621E");
  const auto busy = rows_of(content_of(truth));
  ASSERT_EQ(simulate(line).status, 0);
  const auto quiet = rows_of(content_of(truth));
  ASSERT_EQ(busy.size(), 5000U);
  ASSERT_EQ(quiet.size(), 5000U);
  for (std::size_t i = 0; i < busy.size(); ++i) {
    ASSERT_EQ(busy[i].at("time_ns"), quiet[i].at("time_ns")) << i;
    ASSERT_EQ(busy[i].at("position"), quiet[i].at("position")) << i;
  }
}

TEST_F(SimulatedRegisters, Outcomes_SayWhatBecameOfEachAccess) {
  const auto rows = outcomes_of(
      "--access read:0x20 --access 1/read:0 --access write:0x42=00 --access write:0x48=0102 "
      "--access read:0x48,2 --access 0/command:user --access command:bypass --access read:0x72,8");
  const std::vector<std::string> causes{
      "refused", "no_such_slave",   "refused_or_not_addressed", "ok", "ok", "not_accepted",
      "ok",      "next_unavailable"};
  ASSERT_EQ(rows.size(), causes.size());
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(rows[i].at("outcome"), causes[i]) << i;
  EXPECT_EQ(rows[4].at("data"), "01 02");
  EXPECT_EQ(rows[5].at("name"), "user");
  EXPECT_EQ(rows[6].at("id"), "");
  EXPECT_EQ(rows[7].at("data"), "15 15");
}

TEST_F(SimulatedRegisters, Chain_EachEncoderHasItsOwn) {
  const std::string other = folder.file("other.txt", "0x40: 00 00 62 12\n0x48: AB\n");
  const Words line(
      "--registers {} --access 1/read:0x48 --access 0/read:0x42,2 --access 1/read:0x42,2", other);
  const auto rows = outcomes_of(line);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].at("data"), "AB");
  EXPECT_EQ(rows[1].at("data"), "62 1E");
  EXPECT_EQ(rows[2].at("data"), "62 12");
  // The one with the higher ID comes first.
  expect_right("pos16,nE,nW,crc6+pos28,nE,nW,crc6");
  run_ok("simulate --registers {} --registers {} -o {} --truth {}", "1:" + page, "0:" + other,
         capture, truth);
  expect_right("pos28,nE,nW,crc6+pos16,nE,nW,crc6");
}

TEST_F(SimulatedRegisters, AccessesInAFile_AreThoseOfTheCommandLine) {
  const std::string list =
      folder.file("list.txt", "# two\nread:0x42,2  # profile\n\n  write:0x48=07 \r\n");
  const auto rows = outcomes_of(Words("--access {} --access read:0x48", "@" + list));
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].at("data"), "62 1E");
  EXPECT_EQ(rows[2].at("data"), "07");
  const std::string wrong = folder.file("wrong.txt", "read:0x42\nread:0x99\n");
  EXPECT_THAT(simulate({"--access", "@" + wrong}), fails(3, "line 2"));
  EXPECT_EQ(simulate({"--access", "@" + folder.path("none")}).status, 3);
}

TEST_F(SimulatedRegisters, BusyEncoder_TakesThatManyCyclesMoreAByte) {
  const auto at_once = outcomes_of("--access read:0x40,4");
  const auto late = outcomes_of("--access read:0x40,4 --register-busy 7");
  EXPECT_EQ(std::stoi(late[0].at("cycles")), std::stoi(at_once[0].at("cycles")) + 4 * 7);
  EXPECT_EQ(late[0].at("data"), at_once[0].at("data"));
  const auto too_late = outcomes_of("--access read:0x40,4 --register-busy 21ms");
  EXPECT_EQ(too_late[0].at("outcome"), "busy_too_long");
}

TEST_F(SimulatedRegisters, Faults_SpoilAccessesAndRetriesMendThem) {
  const Words faults("--access read:0x40,16 --fault cut@60 --seed 3");
  EXPECT_EQ(outcomes_of(faults)[0].at("outcome"), "frame_lost");
  EXPECT_EQ(outcomes_of(faults + Words("--retries 2"))[0].at("outcome"), "ok");
}

TEST_F(SimulatedRegisters, JsonLines_AreADumpOfTheSameRegisters) {
  const std::string lines = folder.path("outcomes.jsonl");
  ASSERT_EQ(
      simulate(Words("--access read:0x40,52 --access read:0x78,8 --access read:0,20 --outcomes {}",
                     lines))
          .status,
      0);
  const auto again = [&](const std::string& file) {
    return run(
        "simulate --registers {} --access read:0,20 --access read:0x40,52 --access read:0x78,8 -o "
        "{} --outcomes -",
        file, capture);
  };
  const Outcome first = ok(again(page));
  EXPECT_EQ(again(lines).out, first.out);
}

TEST_F(SimulatedRegisters, WrongUsage_IsOneLine) {
  const auto expect_usage = [&](const Words& more, const char* part) {
    EXPECT_THAT(simulate(more), fails(2, part)) << part;
  };
  expect_usage("--cycles 46 --access read:0", "the accesses take at least 47");
  EXPECT_EQ(simulate("--cycles 47 --access read:0").status, 0);
  expect_usage("--access read:0x80", "the address must be 0 to 0x7F");
  expect_usage("--outcomes -", "--outcomes: needs --access");
  expect_usage(Words("--access read:0 --outcomes {}", truth), "are the same file");
  expect_usage("-f resolute-26", "the option cds0");
  expect_usage(Words("-f pos26,nE,nW,crc6 --registers {}", page), "with ID 1");
  expect_usage({"--registers", "0:" + page}, "given twice");
  expect_usage("--register-busy long", "frames");
  EXPECT_EQ(simulate({"--registers", folder.path("none")}).status, 3);
  EXPECT_THAT(run("simulate -o {}", capture), fails(2, "give --format, or --registers"));
}

TEST_F(SimulatedRegisters, RecordedMaster_GetsItsAnswersFromTheRegisters) {
  ASSERT_EQ(simulate("--access read:0x42,2 --motion constant").status, 0);
  const std::string answered = folder.path("answered.vcd");
  const auto answer = [&](const Words& more) {
    run_ok(Words("simulate -f pos28,nE,nW,crc6 --motion constant --ma-from {} -o {}", capture,
                 answered) +
           more);
    return run("decode {} -f pos28,nE,nW,crc6 --to csv", answered).out;
  };
  const std::string original = run("decode {} -f pos28,nE,nW,crc6 --to csv", capture).out;
  EXPECT_EQ(answer({"--registers", page}), original);
  EXPECT_NE(answer({}), original);  // CDS stays 0
}

// The value of a key in the summary.
std::string found(const Outcome& outcome, const std::string& key) {
  const std::size_t line = outcome.err.find("\n" + key + " ");
  if (line == std::string::npos) return {};
  const std::size_t from = outcome.err.find_first_not_of(' ', line + 1 + key.size());
  return outcome.err.substr(from, outcome.err.find_first_of(" \n", from) - from);
}

// The rows of the capture for the cycles of the truth file, after a check that each exists and is
// right.
void expect_positions(const std::string& capture, const std::string& truth,
                      const std::string& format, std::size_t cycles) {
  const auto meant = rows_of(content_of(truth));
  ASSERT_EQ(meant.size(), cycles);
  const auto rows = rows_of(run_ok("decode {} -f {} --to csv", capture, format).out);
  ASSERT_GT(rows.size(), cycles);  // those of the configuration come first
  expect_cycles({rows.end() - static_cast<std::ptrdiff_t>(cycles), rows.end()}, meant);
}

TEST_F(SimulatedRegisters, ConfiguringMaster_FindsTheFormatThatTheCaptureDecodesWith) {
  const Outcome outcome = ok(simulate("--configure --motion random --cable 50m"));
  EXPECT_EQ(found(outcome, "format"), "pos28,nE,nW,crc6");
  EXPECT_THAT(outcome.err, testing::ContainsRegex("\nshortest cycle +not given "));
  EXPECT_THAT(outcome.err, HasSubstr("4D484D234400 (MHM#D)"));
  EXPECT_THAT(outcome.err, HasSubstr("0x6943 (iC-Haus)"));
  EXPECT_THAT(outcome.err, HasSubstr("profile 0x621E"));
  expect_positions(capture, truth, found(outcome, "format"), 100);
}

constexpr const char* described_encoder =
    "[registers]\nEDS_BANK = 2\nDEV_SN = 4711\nDEV_ID = 0x44454D4F3100\nMFR_ID = 0x5858\n"
    "[common]\nTMA = 100ns\nTBUSY_MAX = 10us?\nTO_MAX = 20us?\nTCYC = 31.25us?\n"
    "[bp3]\nMT_LEN = 12 bit\nMT_CNT = 4096\nFI_LEN = 18 bit\nSIP_CNT = 1\nSIP_RES = 262144\n";

TEST_F(ConfiguringMaster, DataSheet_IsReadOverTheWireAndTellsTurnsAndTiming) {
  const std::string sheet = folder.file("encoder.eds", described_encoder);
  const std::string capture = folder.path("line.vcd");
  const std::string truth = folder.path("truth.csv");
  const Outcome outcome = run_ok(
      "simulate --registers {} --configure --clock 10MHz -o {} --truth {}", sheet, capture, truth);
  EXPECT_EQ(found(outcome, "format"), "mt12,st18,nE,nW,crc6");
  EXPECT_EQ(found(outcome, "timeout"), "static:20us");
  EXPECT_THAT(outcome.err, HasSubstr("250 kHz to 10 MHz"));
  EXPECT_THAT(outcome.err, HasSubstr("serial number 4711"));
  expect_positions(capture, truth, found(outcome, "format"), 100);
}

// 12 bits of turns and 19 of a turn, described as one value of 31 bits with counts of its own.
TEST_F(ConfiguringMaster, DataSheetThatContradictsItself_IsRefusedByNameEverywhere) {
  const std::string description = folder.file(
      "encoder.eds",
      "[registers]\nEDS_BANK = 2\n[common]\nTMA = 100ns\n"
      "[bp3]\nMT_LEN = 0\nMT_CNT = 4096\nCO_LEN = 31\nCO_FMT = left\nFI_LEN = 0\nSIP_CNT = 1\n"
      "SIP_RES = 524288\n");
  const std::string sheet = folder.path("encoder.hex");
  run_ok("eds build --force {} -o {}", description, sheet);
  const std::string capture = folder.path("line.vcd");
  constexpr const char* cause = "MT_CNT: more counts than its length can distinguish";
  const Outcome configured =
      run("simulate --registers {} -f mt12,st19,nE,nW,crc6 --configure -o {}", sheet, capture);
  EXPECT_EQ(configured.status, 1);
  EXPECT_THAT(configured.err, testing::ContainsRegex("\ndata sheet +ID 0: MT_CNT: more counts"));
  EXPECT_THAT(
      configured.err,
      HasSubstr(std::string("no configuration: eds_contradiction at read_channels of ID 0: ") +
                cause));
  EXPECT_THAT(run("simulate --registers {} -o {}", sheet, capture),
              fails(1, testing::AllOf(HasSubstr("the data sheet contradicts itself; give --format"),
                                      HasSubstr(cause))));
  run_ok("simulate --registers {} -f pos31,nE,nW,crc6 -o {}", sheet, capture);
  EXPECT_THAT(run("eds advise {}", sheet).err, HasSubstr(cause));
  EXPECT_THAT(run("eds show {}", sheet).err, HasSubstr(cause));
}

TEST_F(ConfiguringMaster, DataSheetForMoreThanTheLineHas_IsRefusedByField) {
  const std::string capture = folder.path("line.vcd");
  for (const std::string_view field : {"DC_NUM", "SL_NUM"}) {
    const std::string description =
        folder.file("encoder.eds", fmt::format("[registers]\nEDS_BANK = 2\n[common]\nTMA = 100ns\n"
                                               "{} = 2\n[bp3]\nFI_LEN = 18\n",
                                               field));
    const std::string sheet = folder.path("encoder.hex");
    run_ok("eds build --force {} -o {}", description, sheet);
    const Outcome described = run("simulate --registers {} -o {}", sheet, capture);
    const Outcome configured = run(
        {"simulate", "--registers", sheet, "-f", "pos18,nE,nW,crc6", "--configure", "-o", capture});
    EXPECT_EQ(configured.status, 1);
    if (field == "DC_NUM") {
      EXPECT_THAT(described, fails(1, "the data sheet contradicts itself; give --format"));
    } else {
      EXPECT_THAT(configured.err, HasSubstr("no configuration: eds_contradiction at read_common of "
                                            "ID 0: SL_NUM: does not fit the slaves on the line"));
    }
  }
}

TEST_F(ConfiguringMaster, ChainOfTwo_IsFoundAndBelievedAboutItsClock) {
  const std::string sheet = folder.file("encoder.eds", described_encoder);
  const std::string other = folder.file("other.txt", "0x40: 00 00 62 12\n");
  const std::string capture = folder.path("line.vcd");
  const std::string truth = folder.path("truth.csv");
  const Outcome outcome = run_ok(
      "simulate --registers {} --registers {} --configure --clock 2MHz --access 0/read:0x42,2 "
      "--outcomes - -o {} --truth {}",
      other, sheet, capture, truth);
  EXPECT_EQ(found(outcome, "format"), "mt12,st18,nE,nW,crc6+pos16,nE,nW,crc6");
  EXPECT_EQ(found(outcome, "shortest cycle"), "31.25");
  EXPECT_THAT(outcome.err,
              HasSubstr("--clock: 2 MHz is outside the range that was found, 250 kHz to 1 MHz"));
  EXPECT_EQ(rows_of(outcome.out).at(0).at("data"), "62 12");
  expect_positions(capture, truth, found(outcome, "format"), 100);
}

TEST_F(ConfiguringMaster, WithoutControl_SaysWhyAndLeavesTheCapture) {
  const std::string capture = folder.path("line.vcd");
  EXPECT_THAT(run("simulate -f resolute-26 --configure -o {}", capture),
              fails(1, "no configuration: no_control"));
  EXPECT_GT(rows_of(run("decode {} --to csv", capture).out).size(), 100U);
}

}  // namespace biss::verbs::control_test
