// Verdicts of `check` on simulated captures of encoders.
#include "decode/rules.hpp"
#include "tests/cli/run_command.hpp"

namespace biss::verbs::check_test {

constexpr const char* registers =
    "0x40: 00 00 62 1E 00 00 00 01 00 00\n"
    "0x70: -- -- -- -- -- -- -- -- 4D 48 4D 23 44 00 69 43\n";

// Without a data sheet.
bool no_limit(const std::string& rule) {
  return rule == "duty" || rule == "extra_clocks" || rule == "cds_zero" || rule == "cable" ||
         rule == "sign_of_life" || rule == "speed" || rule == "reset" || rule == "word_length" ||
         rule == "counter_values" || rule == "safety";
}

bool needs_format(const std::string& rule) {
  return rule == "frame_crc" || rule == "stop" || rule == "stop_clock" ||
         rule == "line_delay_jitter" || rule.starts_with("sampling") || rule == "nE" ||
         rule == "nW";
}

std::map<std::string, std::string> verdicts_of(const Outcome& outcome) {
  std::map<std::string, std::string> verdicts;
  for (const Row& row : rows_of(outcome.out)) verdicts[row.at("rule")] = row.at("verdict");
  return verdicts;
}

class Conform : public testing::Test {
 protected:
  void simulate(const Words& more) const {
    run_ok(Words("simulate --registers {} -o {}", page, capture) + more);
  }
  // Verdicts by rule, and the exit status.
  std::map<std::string, std::string> judge(const Words& more, int status) const {
    const Outcome outcome = run(Words("check {} --to csv", capture) + more);
    EXPECT_EQ(outcome.status, status) << outcome.out << outcome.err;
    auto verdicts = verdicts_of(outcome);
    EXPECT_EQ(verdicts.size(), 51U);
    return verdicts;
  }
  void expect_only_failing(const Words& more, const std::string& rule) const {
    for (const auto& [name, verdict] : judge(more, 1)) {
      EXPECT_EQ(verdict == "fail", name == rule) << name << ' ' << verdict;
    }
  }

  Folder folder;
  std::string page = folder.file("page.txt", registers);
  std::string capture = folder.path("line.vcd");
  Words usual = Words(
      "--access read:0x42,2 --access read:0x78,8 --access write:0x48=5A --access read:0x20 "
      "--access read:0x48 --clock 2MHz --cable 20m");
};

TEST_F(Conform, SimulatedEncoder_PassesEveryRuleThatTheCaptureShows) {
  simulate(usual);
  for (const Words& format : {Words{"-f", "pos28,nE,nW,crc6"}, Words{}, Words{"-f", "none"}}) {
    const bool named = format != Words{"-f", "none"};
    for (const auto& [rule, verdict] : judge(format, 0)) {
      const bool no_case = rule == "header_damaged" || rule == "data_sheet" ||
                           rule == "clock_change" || rule == "cycle_min" || no_limit(rule) ||
                           (needs_format(rule) && !named);
      const bool warning = rule == "sampling_uncompensated";
      EXPECT_EQ(verdict, no_case ? "not_judged" : warning ? "marginal" : "pass") << rule;
    }
  }
}

TEST_F(Conform, FrameOfAnotherLengthThanTheIdentifier_FailsProfile) {
  simulate(usual + Words("-f pos30,nE,nW,crc6"));
  expect_only_failing("-f pos30,nE,nW,crc6", "profile");
  expect_only_failing({}, "profile");
}

TEST_F(Conform, DamagedFrame_FailsCrc) {
  simulate(usual + Words("--fault flip@3,bit=7"));
  expect_only_failing("-f pos28,nE,nW,crc6", "frame_crc");
}

TEST_F(Conform, TimeoutLongerThanTold_Fails) {
  simulate(usual);
  expect_only_failing("-f pos28,nE,nW,crc6 --timeout static:20us", "timeout_longest");
}

TEST_F(Conform, AckLongerThanTold_Fails) {
  simulate(usual + Words("--processing 9us"));
  EXPECT_EQ(judge("-f pos28,nE,nW,crc6 --ack-max 5us", 1).at("ack_longest"), "fail");
  EXPECT_EQ(judge("-f pos28,nE,nW,crc6", 0).at("ack_longest"), "pass");
}

TEST_F(Conform, BusyBeyondTwentyMilliseconds_Fails) {
  simulate("--access read:0x42 --register-busy 30ms");
  EXPECT_EQ(judge("-f pos28,nE,nW,crc6", 1).at("busy"), "fail");
}

TEST_F(Conform, JsonLines_HaveTheKeysThatStay) {
  simulate(usual);
  const Outcome outcome = run_ok("check {} --to jsonl", capture);
  EXPECT_THAT(outcome.out, testing::HasSubstr(R"({"rule":"line_delay","limit":40000,"worst":)"));
  EXPECT_THAT(
      outcome.out,
      testing::HasSubstr(R"({"rule":"data_sheet","limit":null,"worst":null,"unit":"findings",)"
                         R"("margin":null,"cycle":null,"verdict":"not_judged")"));
}

class Check : public testing::Test {
 protected:
  void simulate(const Words& more) const { run_ok(Words("simulate -o {}", capture) + more); }
  // The rules that fail, by name, and those that are judged.
  std::string failing(const Words& more) {
    const Outcome outcome = run(Words("check {} --to csv", capture) + more);
    std::string names;
    judged.clear();
    for (const Row& row : rows_of(outcome.out)) {
      if (row.at("verdict") != "not_judged") judged += ' ' + row.at("rule") + ' ';
      if (row.at("verdict") != "fail") continue;
      names += (names.empty() ? "" : " ") + row.at("rule");
    }
    EXPECT_EQ(outcome.status, names.empty() ? 0 : 1) << outcome.err;
    return names;
  }

  Folder folder;
  std::string capture = folder.path("line.vcd");
  std::string judged;
};

// The type brings its format and its limits.
TEST_F(Check, TypeOfTheEncoder_Passes) {
  simulate("-f fs-36-28 --clock 5MHz --cable 0.5m");
  EXPECT_EQ(failing({"--against", "fs-36-28"}), "");
  for (const char* rule : {"frame_crc", "duty", "clock_change", "cycle_min", "cable", "cds_zero",
                           "sign_of_life", "extra_clocks", "ready", "nE", "sampling_margin"}) {
    EXPECT_THAT(judged, testing::HasSubstr(std::string(" ") + rule + ' '));
  }
}

TEST_F(Check, Renishaw_IsTheLimitsOfItsDataSheetsWithAnyFormat) {
  simulate("-f pos26,nE,nW,crc6 --clock 2MHz --cable 10m");
  EXPECT_EQ(failing({"--against", "biss-c", "-f", "pos26,nE,nW,crc6"}), "");
  EXPECT_EQ(failing({"--against", "renishaw", "-f", "pos26,nE,nW,crc6"}).substr(0, 12),
            "ack_shortest");
  EXPECT_EQ(failing({"--against", "renishaw"}).substr(0, 12), "ack_shortest");
}

TEST_F(Check, OptionsOfTiming_ReplaceSingleLimits) {
  simulate("-f resolute-26 --clock 5MHz");
  EXPECT_EQ(failing({"--against", "renishaw", "--clock-max", "4MHz"}), "clock_max");
  EXPECT_EQ(failing({"--against", "resolute-26", "--clock-max", "4MHz"}), "clock_max");
}

TEST_F(Check, SpeedMax_IsInCountsOrTurns) {
  simulate("-f resolute-26 --clock 5MHz --rate 10kHz");
  // The ramp takes 1000 requests for a turn: 10 turns a second.
  EXPECT_EQ(failing({"--against", "resolute-26", "--speed-max", "620rpm"}), "");
  EXPECT_EQ(failing({"--against", "resolute-26", "--speed-max", "580rpm"}), "speed");
  EXPECT_EQ(failing({"--against", "resolute-26", "--speed-max", "700000000"}), "");
  EXPECT_EQ(failing({"--against", "resolute-26", "--speed-max", "600000000"}), "speed");
}

TEST_F(Check, MasterWithoutCompensation_FailsOnALongCable) {
  simulate("-f resolute-26 --clock 2MHz --cable 10m");
  EXPECT_EQ(failing({"--against", "resolute-26"}), "");
  EXPECT_EQ(failing({"--against", "resolute-26", "--no-compensation"}), "sampling_uncompensated");
  simulate("-f resolute-26 --clock 2MHz --cable 8m");
  EXPECT_EQ(failing({"--against", "resolute-26", "--no-compensation"}), "");
}

TEST_F(Check, FaultsOfTheLine_FailTheirRules) {
  for (const auto& [fault, failed] : std::vector<std::pair<std::string, std::string>>{
           {"flip@5", "frame_crc"},
           {"nE@5", "nE"},
           {"nW@5", ""},
           {"delay@9", "missing_request"},
           // The encoder counts it as well, and answers the next request too early.
           {"glitch_ma_idle@5", "line_delay glitch_ma"},
           {"glitch_slo_idle@5", "glitch_slo"}}) {
    simulate(Words("-f fs-28-24 --clock 1MHz --cycles 40 --fault {}", fault));
    EXPECT_EQ(failing({"--against", "fs-28-24"}), failed) << fault;
  }
}

TEST_F(Check, PulsesThatAreTheFirstClock_LeaveTheLineDelaySteady) {
  simulate(
      "-f resolute-26 --clock 2.5MHz --cable 60m --cycles 400 --fault glitch_ma_idle:0.2 --seed 3");
  EXPECT_THAT(failing({"--against", "resolute-26"}),
              testing::Not(testing::HasSubstr("line_delay")));
  EXPECT_THAT(judged, testing::HasSubstr(" line_delay_jitter  "));
}

TEST_F(Check, NoRequestAnswered_FailsStart) {
  for (const char* fault : {"no_answer:1", "exchange:1"}) {
    SCOPED_TRACE(fault);
    simulate(Words("-f resolute-26 --cycles 300 --fault {}", fault));
    EXPECT_EQ(failing({"--against", "resolute-26"}), "frame_structure start");
  }
}

// Some requests have START, but none the end of the frame.
TEST_F(Check, StartAlwaysTooLate_IsNoPass) {
  simulate("-f resolute-26 --cycles 300 --fault late_start:1");
  EXPECT_THAT(run("check {} --against resolute-26", capture), fails(1, "no frame could be judged"));
}

TEST_F(Check, FormatLongerThanTheRequests_IsNoPass) {
  simulate("-f resolute-26 --cycles 100");
  const Outcome outcome = run("check {} -f pos32,nE,nW,crc6 --to csv", capture);
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, testing::HasSubstr("no frame could be judged: every request ends before "
                                              "the last bit of the frame"));
  for (const Row& row : rows_of(outcome.out)) {
    EXPECT_EQ(row.at("verdict") == "not_judged" && row.at("note").empty(), false) << row.at("rule");
  }
}

TEST_F(Check, HighestSpeedWithoutAFormat_IsNotJudgedForLackOfTheFormat) {
  simulate("-f resolute-26");
  for (const char* speed : {"6000rpm", "1000000"}) {
    const Outcome outcome = run("check {} -f none --speed-max {} --to csv", capture, speed);
    EXPECT_THAT(outcome.out, testing::HasSubstr("\nspeed,,,counts/s,,,not_judged,0,--speed-max,"
                                                "needs the frame format\n"));
  }
}

TEST_F(Check, UnknownLimits_AreWrongUsage) {
  simulate("-f resolute-26");
  EXPECT_THAT(run("check {} --against resolut-26", capture), fails(2, "did you mean resolute-26?"));
  EXPECT_EQ(run("check {} --against pos26,nE,nW,crc6", capture).status, 2);
  for (const char* speed : {"fast", "0", "rpm", "-3rpm", "1e6"}) {
    EXPECT_EQ(run("check {} --speed-max {}", capture, speed).status, 2) << speed;
  }
}

TEST(CheckDocument, EveryRule_IsExplained) {
  const std::string document = content_of(BISS_SOURCE_FOLDER "/docs/check.md");
  const std::string rules = document.substr(document.find("\n## Rules"));
  for (std::size_t i = 0; i < decode::rule_count; ++i) {
    const std::string name(text_of(static_cast<decode::Rule>(i)).name);
    EXPECT_THAT(rules, testing::HasSubstr('`' + name + '`')) << name;
  }
}

// A line of BiSS Safety with a wrong bit in this one of 100 cycles.
std::string with_flip(const Folder& folder, int cycle) {
  const std::string capture = folder.path("line.vcd");
  run_ok("simulate -f fs-36-28 --clock 5MHz --cycles 100 --fault {} -o {}",
         fmt::format("flip@{},bit=12", cycle), capture);
  return capture;
}

TEST(CheckRange, FaultOutsideOfSinceAndUntil_IsNotJudged) {
  const Folder folder;
  const std::string capture = with_flip(folder, 3);
  EXPECT_EQ(run("check {} -f fs-36-28", capture).status, 1);
  const Words later("check {} -f fs-36-28 --since 1ms", capture);
  EXPECT_EQ(run(later).status, 0) << run(later).err;
  EXPECT_EQ(run("check {} -f fs-36-28 --since 2ms --until 1ms", capture).status, 2);
}

TEST(CheckWords, WordLengthThatNoDataSheetNames_Fails) {
  const Folder folder;
  const std::string capture = folder.path("line.vcd");
  const auto verdict = [&](const std::string& format, const std::string& against) {
    run_ok("simulate -f {} --clock 5MHz --cycles 50 -o {}", format, capture);
    return verdicts_of(run("check {} -f {} --against {} --to csv", capture, format, against))
        .at("word_length");
  };
  EXPECT_EQ(verdict("pos30,nE,nW,crc6", "renishaw"), "fail");
  EXPECT_EQ(verdict("pos26,nE,nW,crc6", "renishaw"), "pass");
  EXPECT_EQ(verdict("pos18,nE,nW,crc6", "renishaw"), "pass");
  EXPECT_EQ(verdict("pos18,nE,nW,crc6", "fortis-26"), "fail");
  EXPECT_EQ(verdict("pos30,nE,nW,crc6", "biss-c"), "not_judged");
  EXPECT_EQ(verdict("fs-36-28", "renishaw"), "pass");
  EXPECT_EQ(verdict("pos36,nE,nW,crc6+pos30,nE,nW,lc6,crc16;cds0", "biss-c"), "fail");
}

TEST(CheckSafety, FaultOfTheMonitor_FailsSafetyAndStaysWithLatch) {
  const Folder folder;
  const std::string capture = with_flip(folder, 50);
  const auto faults = [&](const Words& more) {
    Words words = Words("check {} -f fs-36-28 --to csv", capture) + more;
    for (const Row& row : rows_of(run(words).out)) {
      if (row.at("rule") == "safety") return row.at("verdict") + ' ' + row.at("worst");
    }
    return std::string();
  };
  EXPECT_EQ(faults({"--counter", "count_1_63"}), "fail 1");
  EXPECT_EQ(faults({"--latch"}), "fail 50");
  EXPECT_EQ(faults({"--safety", "off"}), "not_judged ");
  EXPECT_EQ(faults({}), "not_judged ");
}

}  // namespace biss::verbs::check_test
