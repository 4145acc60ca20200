// The limits of a device, in every output of `decode` and `check` that reports them.
#include "decode/limits.hpp"
#include "tests/cli/run_command.hpp"

namespace biss::verbs::limits_test {

using testing::HasSubstr;
using testing::Not;

class Limits : public testing::Test {
 protected:
  std::string simulate(const std::string& name, const Words& more) const {
    run_ok(Words("simulate -o {} --cycles 20", folder.path(name)) + more);
    return folder.path(name);
  }
  Outcome decode(const std::string& capture, const Words& more) const {
    return run(Words{"decode", capture} + more);
  }
  std::string verdict(const std::string& capture, const std::string& format,
                      const std::string& rule) const {
    for (const Row& row : rows_of(run("check {} -f {} --to csv", capture, format).out)) {
      if (row.at("rule") == rule) return row.at("verdict");
    }
    return "no such rule";
  }
  // Every row from the second one on has this cell, and everything that looks at it agrees.
  void expect_limits(const std::string& capture, const std::string& format, const std::string& cell,
                     const std::string& rule) const {
    SCOPED_TRACE(cell);
    const Words with_format{"-f", format};
    const auto status = [&](const std::string& cause) {
      return decode(capture, Words("-f {} --fail-on {}", format, cause)).status;
    };
    const Outcome csv = decode(capture, Words("-f {} --to csv", format));
    const std::string header = csv.out.substr(0, csv.out.find('\n'));
    EXPECT_TRUE(header.ends_with(",safety,limits")) << header;
    const auto rows = rows_of(csv.out);
    ASSERT_EQ(rows.size(), 20U);
    for (std::size_t i = 1; i < rows.size(); ++i) {
      EXPECT_EQ(rows[i].at("status"), "ok") << i;
      EXPECT_EQ(rows[i].at("limits"), cell) << i;
    }
    const Outcome lines = decode(capture, Words("-f {} --to jsonl", format));
    EXPECT_THAT(lines.out, HasSubstr("\"limits\":\"" + cell + "\"}"));
    EXPECT_THAT(decode(capture, with_format).out, HasSubstr(cell));
    EXPECT_EQ(status("any"), 1);
    EXPECT_EQ(status("limits"), 1);
    EXPECT_EQ(status("nE,crc,marginal"), 0);
    for (std::size_t i = 0; i < decode::limit_count; ++i) {
      const std::string name(name_of(static_cast<decode::Limit>(i)));
      const bool exceeded = cell.find(name) != std::string::npos;
      EXPECT_EQ(status(name) == 1, exceeded) << name;
      EXPECT_EQ(csv.err.find(" " + name) != std::string::npos, exceeded) << csv.err;
    }
    EXPECT_EQ(verdict(capture, format, rule), "fail") << rule;
  }

  Folder folder;
};

TEST_F(Limits, ClockAboveTheMaximum_IsNamed) {
  expect_limits(simulate("line.vcd", "-f resolute-26 --clock 10MHz --clock-error 5%"),
                "resolute-26", "clock_max", "clock_max");
  expect_limits(simulate("line.vcd",
                         "-f pos24,nE,nW,crc6 --clock 6MHz --ack-clocks 4 --timeout static:13.2us"),
                "lenz-b3", "clock_max", "clock_max");
}

TEST_F(Limits, ClockBelowTheMinimum_IsNamed) {
  expect_limits(simulate("line.vcd", "-f resolute-26 --clock 250kHz --clock-error -2%"),
                "resolute-26", "clock_min", "clock_min");
}

TEST_F(Limits, RequestsAboveTheRate_AreNamed) {
  const std::string capture =
      simulate("line.vcd", "-f siko-msa213c --clock 10MHz --cycle-min 20us");
  expect_limits(capture, "siko-msa213c", "cycle_min", "cycle_min");
  EXPECT_THAT(decode(capture, "-f siko-msa213c").err, HasSubstr("19 cycle_min"));
  EXPECT_EQ(decode(capture, "-f siko-msa213c --cycle-min 10us --fail-on any").status, 0);
}

TEST_F(Limits, SloReleasedTooEarly_IsNamed) {
  expect_limits(
      simulate("line.vcd", "-f resolute-26 --clock 10MHz --timeout cycle:10us --rate 32kHz"),
      "resolute-26", "release", "timeout_shortest");
  expect_limits(
      simulate("line.vcd", "-f resolute-26 --clock 10MHz --timeout cycle:20us --cycle-min 20us"),
      "resolute-26", "cycle_min;release", "timeout_shortest");
}

// MA as a master makes it that changes its clock in the middle of each request.
struct TwoClocks {
  int first_ns;
  int second_ns;
  int pause_ns;
  int turn;
  int clocks;
};
std::string master_of(const Folder& folder, const TwoClocks& two) {
  std::string vcd = "$timescale 1ns $end $var wire 1 ! MA $end $enddefinitions $end\n#0 1!\n";
  for (int request = 0; request < 20; ++request) {
    int time = 20'000 + request * 100'000;
    for (int clock = 0; clock < two.clocks; ++clock) {
      const int half = (clock < two.turn ? two.first_ns : two.second_ns) / 2;
      if (clock == two.turn) time += two.pause_ns;
      vcd += fmt::format("#{} 0!\n#{} 1!\n", time, time + half);
      time += 2 * half;
    }
  }
  return folder.file("master.vcd", vcd);
}

TEST_F(Limits, ClockThatFallsToTwoThirds_IsNamed) {
  // So late that the mean clock still fits the time of ACK.
  for (const TwoClocks& two : {TwoClocks{150, 100, 0, 62, 68}, TwoClocks{300, 200, 0, 50, 55},
                               TwoClocks{200, 200, 80, 40, 70}}) {
    const std::string master = master_of(folder, two);
    const std::string capture = folder.path("answered.vcd");
    run_ok("simulate -f resolute-32 --ma-from {} -o {}", master, capture);
    expect_limits(capture, "resolute-32", "clock_change", "clock_change");
    // Without this demand it is none.
    const Words other("-f pos32,nE,nW,crc6 --fail-on any");
    EXPECT_EQ(decode(capture, other).status, 0);
    EXPECT_EQ(verdict(capture, "pos32,nE,nW,crc6", "clock_change"), "not_judged");
  }
}

TEST_F(Limits, CapturesAtTheLimits_HaveEmptyCells) {
  struct Case {
    const char* format;
    Words more;
  };
  const Case cases[] = {
      {"resolute-26", {"--clock", "10MHz", "--rate", "32kHz"}},
      {"resolute-26", {"--clock", "10MHz", "--cable", "50m", "--jitter", "3ns"}},
      {"resolute-32", {"--clock", "5MHz", "--rate", "32kHz", "--cable", "20m"}},
      {"resolute-18", {"--clock", "4MHz", "--processing", "16us"}},
      {"fortis-36", {"--clock", "3MHz", "--duty", "40%"}},
      {"fs-36-28", {"--clock", "10MHz", "--rate", "32kHz", "--processing", "9us"}},
      {"fs-28-24", {"--clock", "1MHz"}},
      {"resolute-26", {"--clock", "250kHz", "--cable", "100m"}},
      {"lenz-b3", {"--clock", "5MHz"}},
      {"siko-msa213c", {"--clock", "10MHz"}},
      {"siko-msa213c", {"--clock", "2MHz", "--duty", "70%"}},
      {"ic-mhm", {"--clock", "10MHz", "--jitter", "2ns", "--cable", "10m"}},
      {"faulhaber-aemt", {"--clock", "2MHz"}},
      {"kuebler-s36-16", {"--clock", "80kHz"}},
      {"pos26,nE,nW,crc6", {"--clock", "10MHz"}},
      {"pos26,nE,nW,crc6", {"--clock", "80kHz"}},
  };
  for (const Case& each : cases) {
    const std::string clock = each.more[1];
    const bool slow = clock.find("kHz") != std::string::npos;
    std::vector<std::pair<std::string, Words>> files{{"line.vcd", {}}, {"line.csv", {}}};
    if (!slow) {
      files.push_back({"coarse.bin", {"--sample-rate", "100MHz"}});
      files.push_back({"fine.bin", {"--sample-rate", "1GHz"}});
    }
    for (const auto& [name, rate] : files) {
      SCOPED_TRACE(std::string(each.format) + " " + clock + " " + name);
      const Words format{"-f", each.format};
      const std::string capture = simulate(name, format + each.more + rate);
      Words reading = format;
      if (!rate.empty()) reading = reading + Words("--raw-rate {} --ma D0 --slo D1", rate[1]);
      const Outcome outcome = ok(decode(capture, reading + Words("--fail-on any --to csv")));
      for (const Row& row : rows_of(outcome.out)) EXPECT_EQ(row.at("limits"), "");
      EXPECT_THAT(outcome.err, Not(HasSubstr("limits")));
      for (const Row& row : rows_of(run(Words("check {} --to csv", capture) + reading).out)) {
        if (row.at("rule").starts_with("c") && row.at("unit") == "ns") {
          EXPECT_NE(row.at("verdict"), "fail") << row.at("rule");
        }
      }
    }
  }
}

TEST_F(Limits, Summary_CountsThemAndSaysWhatToDo) {
  const std::string capture =
      simulate("line.vcd", "-f resolute-26 --clock 10MHz --timeout cycle:20us --cycle-min 20us");
  const std::string summary = decode(capture, "-f resolute-26").err;
  EXPECT_THAT(summary, HasSubstr("19 cycle_min, 20 release"));
  EXPECT_THAT(summary, HasSubstr("release: SLO contradicts the timeout cycle:31.25us"));
}

TEST_F(Limits, LimitThatTheDeviceHasNot_IsRefused) {
  const std::string capture = simulate("line.vcd", "-f pos26,nE,nW,crc6");
  for (const char* limit : {"clock_change", "cycle_min", "release"}) {
    EXPECT_THAT(decode(capture, Words("-f pos26,nE,nW,crc6 --fail-on {}", limit)),
                fails(2, testing::AllOf(HasSubstr(limit), HasSubstr("give -f NAME"))));
  }
  for (const char* known : {"clock_max", "clock_min", "limits"}) {
    EXPECT_EQ(decode(capture, {"--fail-on", known}).status, 0) << known;
  }
  EXPECT_EQ(decode(capture, "--fail-on cycle_min --cycle-min 10us").status, 0);
  EXPECT_EQ(decode(capture, "--fail-on clocks").status, 2);
}

TEST(LimitsDocument, EveryLimit_HasItsRowInOrder) {
  std::ifstream document(BISS_SOURCE_FOLDER "/docs/decode.md");
  ASSERT_TRUE(document);
  Words named;
  bool inside = false;
  for (std::string line; std::getline(document, line);) {
    if (line.starts_with("## ")) inside = line == "## Limits";
    if (inside && line.starts_with("| `")) named.push_back(line.substr(3, line.find('`', 3) - 3));
  }
  std::vector<std::string> limits;
  for (std::size_t i = 0; i < decode::limit_count; ++i) {
    limits.emplace_back(name_of(static_cast<decode::Limit>(i)));
  }
  EXPECT_EQ(named, limits);
}

}  // namespace biss::verbs::limits_test
