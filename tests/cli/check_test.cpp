// Conformance verdicts on simulated captures of encoders.
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "tests/cli/run_command.hpp"

namespace biss::cli {
namespace check_test {

using Words = std::vector<std::string>;

constexpr const char* registers =
    "0x40: 00 00 62 1E 00 00 00 01 00 00\n"
    "0x70: -- -- -- -- -- -- -- -- 4D 48 4D 23 44 00 69 43\n";

class Conform : public testing::Test {
 protected:
  void simulate(const Words& more) const {
    Words words{"simulate", "--registers", page, "-o", capture};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run(words);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }
  // Verdicts by rule, and the exit status.
  std::map<std::string, std::string> judge(const Words& more, int status) const {
    Words words{"conform", capture, "--to", "csv"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.status, status) << outcome.out << outcome.err;
    std::map<std::string, std::string> verdicts;
    for (const Row& row : rows_of(outcome.out)) verdicts[row.at("rule")] = row.at("verdict");
    EXPECT_EQ(verdicts.size(), 27U);
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
  Words usual{"--access",      "read:0x42,2", "--access",  "read:0x78,8", "--access",
              "write:0x48=5A", "--access",    "read:0x20", "--access",    "read:0x48",
              "--clock",       "2MHz",        "--cable",   "20m"};
};

TEST_F(Conform, SimulatedEncoder_PassesEveryRuleThatTheCaptureShows) {
  simulate(usual);
  for (const Words& format : {Words{"-f", "pos28,nE,nW,crc6"}, Words{}}) {
    const bool named = !format.empty();
    for (const auto& [rule, verdict] : judge(format, 0)) {
      const bool no_case = rule == "header_damaged" || rule == "data_sheet" ||
                           rule == "clock_change" || rule == "cycle_min" ||
                           (rule == "frame_crc" && !named);
      EXPECT_EQ(verdict, no_case ? "not_judged" : "pass") << rule;
    }
  }
}

TEST_F(Conform, FrameOfAnotherLengthThanTheIdentifier_FailsProfile) {
  Words words = usual;
  words.insert(words.end(), {"-f", "pos30,nE,nW,crc6"});
  simulate(words);
  expect_only_failing({"-f", "pos30,nE,nW,crc6"}, "profile");
  expect_only_failing({}, "profile");
}

TEST_F(Conform, DamagedFrame_FailsCrc) {
  Words words = usual;
  words.insert(words.end(), {"--fault", "flip@3,bit=7"});
  simulate(words);
  expect_only_failing({"-f", "pos28,nE,nW,crc6"}, "frame_crc");
}

TEST_F(Conform, TimeoutLongerThanTold_Fails) {
  simulate(usual);
  expect_only_failing({"-f", "pos28,nE,nW,crc6", "--timeout", "static:20us"}, "timeout_longest");
}

TEST_F(Conform, AckLongerThanTold_Fails) {
  Words words = usual;
  words.insert(words.end(), {"--processing", "9us"});
  simulate(words);
  const auto verdicts = judge({"-f", "pos28,nE,nW,crc6", "--ack-max", "5us"}, 1);
  EXPECT_EQ(verdicts.at("ack_longest"), "fail");
  EXPECT_EQ(judge({"-f", "pos28,nE,nW,crc6"}, 0).at("ack_longest"), "pass");
}

TEST_F(Conform, BusyBeyondTwentyMilliseconds_Fails) {
  simulate({"--access", "read:0x42", "--register-busy", "30ms"});
  EXPECT_EQ(judge({"-f", "pos28,nE,nW,crc6"}, 1).at("busy"), "fail");
}

TEST_F(Conform, JsonLines_HaveTheKeysThatStay) {
  simulate(usual);
  const Outcome outcome = run({"conform", capture, "--to", "jsonl"});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_NE(outcome.out.find(R"({"rule":"line_delay","limit":40000,"worst":)"), std::string::npos)
      << outcome.out;
  EXPECT_NE(outcome.out.find(R"({"rule":"data_sheet","limit":null,"worst":null,"unit":"findings",)"
                             R"("margin":null,"cycle":null,"verdict":"not_judged")"),
            std::string::npos)
      << outcome.out;
}

}  // namespace check_test
}  // namespace biss::cli
