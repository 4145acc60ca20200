// `biss compare`: the one thing that differs between two links is named first.
#include <nlohmann/json.hpp>

#include "tests/cli/run_command.hpp"

namespace biss::verbs::compare_test {

using CompareVerb = InFolder;
using nlohmann::json;
using testing::HasSubstr;

constexpr const char* format = "pos26,nE,nW,crc6";

struct Line {
  std::string clock = "1MHz";
  std::string cable = "20m";
  std::string seed = "3";
  std::string format = compare_test::format;
  std::string motion = "sine";
  Words more = {};
};

std::string simulate(const Folder& folder, const std::string& name, const Line& line) {
  const std::string capture = folder.path(name);
  Words words("simulate -f {} --clock {} --cable {} --motion {} --seed {} --cycles 300 -o {}",
              line.format, line.clock, line.cable, line.motion, line.seed, capture);
  run_ok(words + line.more);
  return capture;
}

std::vector<json> compare(const std::string& good, const std::string& bad, const Words& more = {}) {
  const Outcome outcome = run_ok(Words("compare {} {} --to jsonl", good, bad) + more);
  std::vector<json> rows;
  std::istringstream lines(outcome.out);
  for (std::string line; std::getline(lines, line);) rows.push_back(json::parse(line));
  return rows;
}

std::vector<std::string> properties(const std::vector<json>& rows) {
  std::vector<std::string> names;
  for (const json& row : rows) names.push_back(row.at("property"));
  return names;
}

std::string as_text(const std::vector<json>& rows) {
  std::string text;
  for (const json& row : rows) text += row.dump() + '\n';
  return text;
}

struct OneDifference {
  std::string name;
  Line bad;
  std::string first;
};

class CompareLinks : public testing::TestWithParam<OneDifference> {};

TEST_P(CompareLinks, NameWhatDiffersFirst) {
  const Folder folder;
  const std::string good = simulate(folder, "good.csv", {});
  const std::string bad = simulate(folder, "bad.csv", GetParam().bad);
  for (const Words& more : {Words{}, Words{"-f", format}}) {
    const auto rows = compare(good, bad, more);
    ASSERT_FALSE(rows.empty());
    EXPECT_EQ(rows[0].at("property"), GetParam().first) << as_text(rows);
    EXPECT_GT(rows[0].at("effect").get<double>(), 0.1) << as_text(rows);
    // Exchanged: the same, with the values exchanged.
    const auto back = compare(bad, good, more);
    ASSERT_FALSE(back.empty());
    EXPECT_EQ(back[0].at("property"), GetParam().first) << as_text(back);
    EXPECT_EQ(back[0].at("good"), rows[0].at("bad"));
    EXPECT_EQ(back[0].at("bad"), rows[0].at("good"));
  }
}

INSTANTIATE_TEST_SUITE_P(
    OneThing, CompareLinks,
    testing::Values(
        OneDifference{"clock", {.clock = "2MHz"}, "clock"},
        OneDifference{"clock_a_tenth", {.clock = "1.2MHz"}, "clock"},
        OneDifference{"cable", {.cable = "50m"}, "line_delay"},
        OneDifference{"ack", {.more = {"--processing", "9us"}}, "ack_clocks"},
        OneDifference{"rate", {.more = {"--rate", "5kHz"}}, "request_rate"},
        OneDifference{"duty", {.more = {"--duty", "40%"}}, "duty"},
        OneDifference{"jitter", {.more = {"--jitter", "60ns"}}, "jitter_slo"},
        OneDifference{"pulses_on_slo", {.more = {"--fault", "glitch_slo:0.1"}}, "pulses_slo"},
        OneDifference{"pulses_on_ma", {.more = {"--fault", "glitch_ma:0.1"}}, "pulses_ma"},
        OneDifference{"damage", {.more = {"--fault", "flip:0.1"}}, "status_crc"},
        OneDifference{"no_encoder", {.more = {"--fault", "no_answer:1"}}, "status_no_response"},
        OneDifference{
            "missing_answers", {.more = {"--fault", "no_answer:0.3"}}, "status_no_response"},
        OneDifference{"error", {.more = {"--fault", "nE:0.2"}}, "nE"}),
    [](const auto& test) { return test.param.name; });

// The axis of the bad link stands still, or jumps.
TEST_F(CompareVerb, OtherMotionBesideAFault_ComesAfterTheFault) {
  const std::string good = simulate(folder, "good.csv", {});
  for (const char* motion : {"constant", "max"}) {
    const std::string bad =
        simulate(folder, "bad.csv", {.motion = motion, .more = {"--fault", "flip:0.05"}});
    const auto names = properties(compare(good, bad, {"-f", format}));
    EXPECT_EQ(names, (Words{"status_crc", "good", "largest_step", "speed"})) << motion;
  }
}

TEST_F(CompareVerb, OtherMotionAlone_IsASmallDifference) {
  const std::string good = simulate(folder, "good.csv", {});
  const auto rows =
      compare(good, simulate(folder, "bad.csv", {.motion = "constant"}), {"-f", format});
  EXPECT_EQ(properties(rows), (Words{"largest_step", "speed"})) << as_text(rows);
  for (const json& row : rows) EXPECT_EQ(row.at("effect"), 0.01) << row;
}

TEST_F(CompareVerb, SameFileTwice_DiffersInNothing) {
  const std::string capture = simulate(folder, "line.csv", {.more = {"--fault", "flip:0.1"}});
  const Outcome outcome = run_ok("compare {} {} --to jsonl", capture, capture);
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(outcome.err, HasSubstr("nothing"));
}

TEST_F(CompareVerb, OtherSeeds_HaveNoEffect) {
  const Words noisy("--jitter 20ns --fault flip:0.05");
  const std::string first = simulate(folder, "first.csv", {.more = noisy});
  for (const char* seed : {"4", "5", "6", "7"}) {
    const auto rows = compare(first, simulate(folder, "second.csv", {.seed = seed, .more = noisy}));
    for (const json& row : rows) EXPECT_LT(row.at("effect").get<double>(), 0.2) << row;
  }
}

TEST_F(CompareVerb, OtherFormat_IsNamedWithBothFormats) {
  const std::string good = simulate(folder, "good.csv", {});
  const std::string bad = simulate(folder, "bad.csv", {.format = "pos32,nE,nW,crc6"});
  const Outcome outcome = run("compare {} {} --to jsonl", good, bad);
  const auto rows = compare(good, bad);
  ASSERT_FALSE(rows.empty());
  EXPECT_EQ(rows[0].at("property"), "format") << as_text(rows);
  EXPECT_EQ(rows[0].at("good"), "pos26,nE,nW,crc6;cds0");
  EXPECT_EQ(rows[0].at("bad"), "pos32,nE,nW,crc6;cds0");
  EXPECT_EQ(rows[0].at("unit"), nullptr);
  EXPECT_EQ(rows[0].at("effect"), 1.0);
  // The master of the good link reads the other one with the wrong format.
  EXPECT_THAT(outcome.err, HasSubstr("wrong_format"));
}

TEST_F(CompareVerb, InvertedSlo_IsNamedFirst) {
  const std::string good = simulate(folder, "good.csv", {});
  const std::string bad = rewritten(folder, "bad.csv", good,
                                    [](Row& row) { row["SLO"] = row["SLO"] == "0" ? "1" : "0"; });
  const auto rows = compare(good, bad);
  ASSERT_EQ(properties(rows), (Words{"inverted"})) << as_text(rows);
  EXPECT_EQ(rows[0].at("good"), "none");
  EXPECT_EQ(rows[0].at("bad"), "SLO");
}

TEST_F(CompareVerb, ExchangedLines_AreNamedFirst) {
  const std::string good = simulate(folder, "good.csv", {});
  const std::string bad =
      rewritten(folder, "bad.csv", good, [](Row& row) { std::swap(row["MA"], row["SLO"]); });
  const auto rows = compare(good, bad);
  ASSERT_EQ(properties(rows), (Words{"lines"})) << as_text(rows);
  EXPECT_EQ(rows[0].at("bad"), "MA = SLO, SLO = MA");
}

TEST_F(CompareVerb, Rows_HaveTheirKeysAndFallingEffects) {
  const std::string good = simulate(folder, "good.csv", {});
  const std::string bad = simulate(
      folder, "bad.csv", {.clock = "2MHz", .cable = "50m", .more = {"--fault", "flip:0.2"}});
  const Outcome outcome = run("compare {} {} --to jsonl", good, bad);
  EXPECT_THAT(outcome.out, testing::StartsWith(R"({"property":"clock","unit":"Hz","good":)"
                                               R"(1000000,"bad":2000000,"effect":1})"));
  const auto rows = compare(good, bad);
  ASSERT_GT(rows.size(), 3U);
  EXPECT_THAT(properties(rows), testing::Contains("status_crc"));
  EXPECT_THAT(properties(rows), testing::Contains("good"));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].size(), 5U);
    const double effect = rows[i].at("effect");
    EXPECT_GT(effect, 0);
    EXPECT_LE(effect, i == 0 ? 1 : rows[i - 1].at("effect").get<double>());
  }
  EXPECT_THAT(outcome.err, HasSubstr("cause")) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("noise_on_slo")) << outcome.err;
}

// A damaged link may show too little of its format.
TEST_F(CompareVerb, BadLinkThatDoesNotShowItsFormat_IsJudgedByThatOfTheGoodOne) {
  const std::string good = simulate(folder, "good.csv", {});
  const std::string bad =
      simulate(folder, "bad.csv", {.motion = "constant", .more = {"--fault", "flip:0.5"}});
  const auto rows = compare(good, bad);
  EXPECT_THAT(properties(rows), testing::Contains("status_crc")) << as_text(rows);
}

TEST_F(CompareVerb, FilesWithOneLineEach_AreJoinedInPairs) {
  Words files;
  for (const char* clock : {"1MHz", "2MHz"}) {
    const std::string capture = simulate(folder, "line.csv", {.clock = clock});
    for (const char* line : {"MA", "SLO"}) {
      files.push_back(one_line(folder, fmt::format("{}_{}.csv", clock, line), line, capture, line));
    }
  }
  const Outcome outcome = run_ok(Words("compare --to jsonl") + files);
  EXPECT_THAT(outcome.out, testing::StartsWith(R"({"property":"clock")"));
}

TEST_F(CompareVerb, GoodFromAPipe_IsReadToo) {
  const std::string good = simulate(folder, "good.csv", {});
  const std::string bad = simulate(folder, "bad.csv", {.cable = "50m"});
  const Outcome outcome = run_ok({"compare", "-", bad, "--to", "jsonl"}, good);
  EXPECT_THAT(outcome.out, testing::StartsWith(R"({"property":"line_delay")"));
}

TEST_F(CompareVerb, CaptureWithoutARequest_Fails) {
  const std::string good = simulate(folder, "good.csv", {});
  const std::string idle = folder.file("idle.csv", "time_ns,MA,SLO\n0,1,1\n1000,1,0\n2000,1,1\n");
  for (const Words& files : {Words{good, idle}, Words{idle, good}}) {
    const Outcome outcome = run("compare {} {} --to jsonl", files[0], files[1]);
    EXPECT_EQ(outcome.status, 1) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.err, HasSubstr("idle.csv: no request cycle"));
  }
}

TEST_F(CompareVerb, FileThatCannotBeRead_EndsWithStatus3) {
  const std::string good = simulate(folder, "good.csv", {});
  EXPECT_EQ(run("compare {} {}", good, folder.path("missing.csv")).status, 3);
  EXPECT_EQ(run("compare {} {}", folder.file("bad.vcd", "$timescale 1 nonsense $end"), good).status,
            3);
}

TEST_F(CompareVerb, OneCaptureOrThree_AreWrongUsage) {
  const std::string good = simulate(folder, "good.csv", {});
  for (const Words& files : {Words{good}, Words{good, good, good}, Words{good, good, good, good}}) {
    Words words = Words("compare") + files;
    EXPECT_THAT(run(words), fails(2, "GOOD"));
  }
}

}  // namespace biss::verbs::compare_test
