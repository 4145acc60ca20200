// `biss read --configure` and `--access`: the registers of an emulated encoder, through spidev.
#include "tests/cli/emulator.hpp"

namespace biss::verbs::read_control_test {

using testing::ContainsRegex;
using testing::HasSubstr;

class ReadControl : public Emulate {
 protected:
  void SetUp() override {
    Emulate::SetUp();
    if (IsSkipped()) return;
    const std::string description = folder.file(
        "encoder.eds",
        "[registers]\nEDS_BANK = 2\nDEV_SN = 4711\nDEV_ID = 0x44454D4F3100\nMFR_ID = 0x5858\n"
        "[common]\nTMA = 100ns\nTBUSY_MAX = 10us?\nTO_MAX = 20us?\nTCYC = 31.25us?\n"
        "[bp3]\nMT_LEN = 12\nMT_CNT = 4096\nFI_LEN = 18\nSIP_CNT = 1\nSIP_RES = 262144\n");
    run_ok("eds build --force {} -o {}", description, sheet);
  }

  Words encoder() const { return Words("--registers {} --ma mosi --clock 10MHz", sheet); }
  static Words read(const Words& more, const std::string& device = "/dev/spidev0.0") {
    return Words{BISS_COMMAND, "read", "--port", "spi:" + device, "--ma-pin", "mosi"} + more;
  }
  Outcome run_with(const Words& options, const Words& command) const {
    return run(Words{"emulate"} + encoder() + options + Words{"--"} + command);
  }
  // All registers and banks are the same.
  void expect_sheet() const {
    const Outcome same = run("eds diff {} {}", sheet, registers);
    EXPECT_EQ(same.status, 0) << same.out << same.err;
    EXPECT_EQ(same.out, "");
  }

  const std::string sheet = folder.path("encoder.hex");
  const std::string registers = folder.path("registers.hex");
  const std::string rows = folder.path("rows.csv");
  const std::string truth = folder.path("truth.csv");
};

TEST_F(ReadControl, DataSheetIsTheOneOfTheEncoder_AndItsPositionsAreRead) {
  const Outcome outcome = run_with(
      Words("--motion sine --truth {}", truth),
      read(Words("--configure --registers {} --clock 4MHz --cycles 500 -o {}", registers, rows)));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, ContainsRegex("ID 0 +device 44454D4F3100 .DEMO1. +maker 0x5858"));
  EXPECT_THAT(outcome.err, ContainsRegex("format +mt12,st18,nE,nW,crc6 +eds"));
  EXPECT_THAT(outcome.err, HasSubstr("serial number 4711, data sheet read"));
  expect_sheet();
  EXPECT_EQ(run_ok("eds show {} --to jsonl", registers).out,
            run_ok("eds show {} --to jsonl", sheet).out);
  const Rows got = rows_of(content_of(rows));
  ASSERT_EQ(got.size(), 500U);
  Rows sent = rows_of(content_of(truth));
  sent.erase(sent.begin(), sent.end() - 500);
  EXPECT_EQ(expect_rows(got, sent), 0U);
}

TEST_F(ReadControl, NoisyLine_GivesTheSameDataSheetOrSaysThatItIsUnread) {
  for (const char* faults : {"--fault no_answer:0.01 --fault cut:0.005", "--fault glitch_slo:0.1",
                             "--fault slo_high:0.003", "--fault slo_low:0.003"}) {
    const Outcome outcome =
        run_with(Words(faults) + Words("--seed 3"),
                 read(Words("--configure --registers {} --cycles 0", registers)));
    EXPECT_EQ(outcome.status, 0) << faults << outcome.err;
    // A flipped W of a read looks like a refusal, which is not repeated.
    const bool unread = outcome.err.find("in bank 2, not readable or wrong") != std::string::npos;
    if (!unread) expect_sheet();
    EXPECT_TRUE(!unread || std::string(faults).find("no_answer") == std::string::npos);
    std::filesystem::remove(registers);
  }
}

TEST_F(ReadControl, LineWithoutAnswer_IsNamedAndEnds) {
  const Words configure = read(Words("--configure --registers {}", registers));
  EXPECT_THAT(run_with(Words("--fault no_answer:1"), configure),
              fails(1,
                    "no_encoder at identity of ID 0: frame_lost; no request had an answer; "
                    "check the supply, and that MOSI is MA and MISO is SLO"));
  for (const char* faults : {"--fault slo_low:1", "--fault slo_high:1"}) {
    EXPECT_THAT(run_with(Words(faults), configure), fails(1, "answers are missing or damaged"));
  }
  EXPECT_FALSE(std::filesystem::exists(registers));
}

TEST_F(ReadControl, EncoderWithoutRegisters_IsIdentified) {
  const Outcome outcome =
      run(emulate(Words("--ma mosi"),
                  read(Words("--configure --registers {} --cycles 600 -o {}", registers, rows))));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("no configuration: no_control at identity of ID 0: no_answer; "
                                     "the format is identified, and no registers are written"));
  EXPECT_THAT(outcome.err, HasSubstr("pos26,nE,nW,crc6"));
  EXPECT_EQ(rows_of(content_of(rows)).size(), 600U);
  EXPECT_FALSE(std::filesystem::exists(registers));
}

TEST_F(ReadControl, Accesses_AreMadeAndNamed) {
  const Outcome outcome = run_with(
      {}, read(Words("--access read:0x78,8 --access write:0x40=02 --access read:0x40 --cycles 0")));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, ContainsRegex("0/read:0x78 +44 45 4D 4F 31 00 58 58\n"));
  EXPECT_THAT(outcome.err, ContainsRegex("0/write:0x40 +ok\n"));
  EXPECT_THAT(outcome.err, ContainsRegex("0/read:0x40 +02\n"));
  const Outcome refused =
      run_with({}, read(Words("--access write:0x78=00 --access 1/read:0x78 --access read:0x70")));
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err,
              ContainsRegex("0/write:0x78 +refused_or_not_addressed: the encoder does"));
  EXPECT_THAT(refused.err, ContainsRegex("1/read:0x78 +no_such_slave: no encoder with registers"));
  EXPECT_THAT(refused.err, ContainsRegex("0/read:0x70 +refused: the encoder does not have this"));
}

TEST_F(ReadControl, PortThatVanishes_IsNamedAndEnds) {
  auto emulator = std::make_unique<Emulator>(folder, Words("--rate 1kHz"), encoder());
  const std::string err = folder.path("read.err");
  const pid_t reader =
      start(read(Words("--configure"), emulator->at), "/dev/null", "/dev/null", err);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  emulator->end(SIGKILL);
  int status = 0;
  ::waitpid(reader, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 3);
  EXPECT_THAT(content_of(err), HasSubstr("transfers fail: gone; connect the port"));
}

TEST_F(ReadControl, UnpluggedInTheMiddle_IsNamedAndEnds) {
  const Emulator emulator(folder, {}, encoder());
  const std::string err = folder.path("read.err");
  const pid_t reader =
      start(read(Words("--configure"), emulator.at), "/dev/null", "/dev/null", err);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_EQ(emulator.ask("unplug"), "ok unplug\n");
  int status = 0;
  ::waitpid(reader, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 1) << content_of(err);
  EXPECT_THAT(content_of(err), HasSubstr("frame_lost; answers are missing or damaged"));
}

TEST_F(ReadControl, Interrupted_Ends) {
  const Emulator emulator(folder, {}, encoder());
  const std::string err = folder.path("read.err");
  const pid_t reader =
      start(read(Words("--configure"), emulator.at), "/dev/null", "/dev/null", err);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  ::kill(reader, SIGINT);
  int status = 0;
  ::waitpid(reader, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 3);
  EXPECT_THAT(content_of(err), HasSubstr("interrupted; a register, BSEL (0x40) too, may have"));
}

TEST(ReadControlUsage, MistakesAreNamed) {
  const auto with = [](const char* more) {
    return run(Words("read --port spi:/no/device") + Words(more));
  };
  EXPECT_THAT(with("--configure"), refuses(2, "need --ma-pin mosi: the clock pin is high after"));
  EXPECT_THAT(with("--access read:0x78"), refuses(2, "need --ma-pin mosi"));
  EXPECT_THAT(with("--ma-pin mosi --configure -f resolute-26"), refuses(2, "remove -f"));
  EXPECT_THAT(with("--ma-pin mosi --registers r.hex"), refuses(2, "--configure"));
  EXPECT_THAT(with("--ma-pin mosi --access command:channels"), refuses(2, "a port has only read"));
  EXPECT_THAT(with("--ma-pin mosi --access read:0x80"), refuses(2, "the address must be"));
  EXPECT_THAT(with("--ma-pin mosi --configure"), refuses(3, "not found; is SPI switched on"));
}

}  // namespace biss::verbs::read_control_test
