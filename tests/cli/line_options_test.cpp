// The line options of `biss simulate` are visible in the capture, and every position stays right.
#include <set>

#include "tests/cli/run_command.hpp"

namespace biss::verbs::line_options_test {

// The rows of `decode` for a line with these options, compared with the truth file.
std::vector<Row> rows_with(const Words& options) {
  const Folder folder;
  const std::string capture = folder.path("line.vcd");
  run_ok(Words("simulate -f resolute-26 --clock 5MHz --cycles 50 --motion random -o {} --truth {}",
               capture, folder.path("truth.csv")) +
         options);
  std::vector<Row> rows = rows_of(run_ok("decode -f resolute-26 {} --to csv", capture).out);
  EXPECT_EQ(rows.size(), 50U);
  expect_truth(rows, rows_of(content_of(folder.path("truth.csv"))));
  rows.resize(std::max<std::size_t>(rows.size(), 1));
  return rows;
}

TEST(SimulateOutput, ExtensionOfAFormatThatIsOnlyRead_IsRefusedAndNothingWritten) {
  const Folder folder;
  for (const char* name : {"line.fst", "line.sal", "line.vcd.gz", "line.csv.zst"}) {
    const std::string out = folder.path(name);
    EXPECT_THAT(run("simulate -f resolute-26 --cycles 3 -o {}", out),
                fails(2, "names a format that is not written"))
        << name;
    EXPECT_FALSE(std::filesystem::exists(out)) << name;
  }
  // Any other name is that of a VCD.
  const std::string other = folder.path("line.txt");
  run_ok("simulate -f resolute-26 --cycles 3 -o {}", other);
  EXPECT_EQ(content_of(other).rfind("$timescale", 0), 0U);
}

TEST(SimulateOutput, SampleRateBelowTwiceTheClock_IsWarnedOf) {
  const Folder folder;
  const std::string source = folder.path("source.vcd");
  run_ok("simulate -f resolute-26 --clock 5MHz --cycles 3 -o {}", source);
  const auto error_with = [&](const char* rate, const Words& line) {
    const Outcome made = run_ok(
        Words("simulate -f resolute-26 -o {} --sample-rate {}", folder.path("x.sr"), rate) + line);
    return made.err;
  };
  const Words line("--clock 5MHz --cycles 3");
  EXPECT_THAT(error_with("9MHz", line),
              testing::HasSubstr("9 MHz misses clocks of MA at 5 MHz; give 50 MHz or more"));
  EXPECT_EQ(error_with("10MHz", line), "");
  EXPECT_THAT(error_with("9MHz", {"--ma-from", source}),
              testing::HasSubstr("9 MHz misses clocks of MA at 5 MHz"));
}

TEST(LineOptions, ClockError_ShowsInTheClock) {
  EXPECT_EQ(rows_with({"--clock-error", "1000ppm"})[3]["clock_hz"], "5005005");
  EXPECT_EQ(rows_with({"--clock-error", "-2%"})[3]["clock_hz"], "4899991");
  EXPECT_EQ(rows_with({"--clock-error=0"})[3]["clock_hz"], "5000000");
}

TEST(LineOptions, DelaysOfEachLine_AddUpToTheLineDelay) {
  const Words delays("--ma-delay 120ns --slo-delay 35ns --internal-delay 2.5ns");
  EXPECT_EQ(rows_with(delays)[3]["line_delay_ns"], "157.5");
  // Half of the cable stays.
  EXPECT_EQ(rows_with({"--cable", "10m", "--slo-delay", "35ns"})[3]["line_delay_ns"], "127.5");
  EXPECT_EQ(rows_with({})[3]["line_delay_ns"], "42.5");
}

TEST(LineOptions, JitterOfEachLine_MovesThatLineOnly) {
  const auto delays_seen = [](const Words& options) {
    std::set<std::string> seen;
    for (Row& row : rows_with(options)) seen.insert(row["line_delay_ns"]);
    return seen.size();
  };
  EXPECT_EQ(delays_seen({"--cable", "10m"}), 1U);
  EXPECT_GT(delays_seen({"--cable", "10m", "--ma-jitter", "9ns"}), 20U);
  EXPECT_GT(delays_seen({"--cable", "10m", "--slo-jitter", "9ns"}), 20U);
  EXPECT_EQ(
      delays_seen({"--cable", "10m", "--jitter", "9ns", "--ma-jitter", "0", "--slo-jitter", "0"}),
      1U);
}

TEST(LineOptions, Duty_ShowsInTheEdgesOfMa) {
  const Folder folder;
  const std::string capture = folder.path("line.csv");
  run_ok("simulate -f resolute-26 --clock 1MHz --duty 37.5% --cycles 1 -o {}", capture);
  std::vector<double> times;
  std::string level = "1";
  for (Row& row : rows_of(content_of(capture))) {
    if (row["MA"].empty() || row["MA"] == level) continue;
    level = row["MA"];
    times.push_back(std::stod(row["time_ns"]));
  }
  ASSERT_GT(times.size(), 3U);
  EXPECT_DOUBLE_EQ(times[1] - times[0], 625);
  EXPECT_DOUBLE_EQ(times[2] - times[1], 375);
}

TEST(LineOptions, WhatNoLineHas_IsWrongUsage) {
  const Folder folder;
  const std::string out = folder.path("line.vcd");
  for (const Words& options :
       {Words("--clock-error 11%"), Words("--clock-error 100"), Words("--duty 100%"),
        Words("--duty 0.5"), Words("--ma-delay -5ns"), Words("--ma-delay 41us"),
        Words("--ma-jitter 1ns"), Words("--slo-jitter 43ns"), Words("--jitter 1ns")}) {
    EXPECT_THAT(run(Words("simulate -f resolute-26 -o {}", out) + options), fails(2, "--"))
        << options[0] << ' ' << options[1];
    EXPECT_EQ(folder.files(), 0U);
  }
}

}  // namespace biss::verbs::line_options_test
