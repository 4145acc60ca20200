// `marginal` in every output that reports it.
#include "tests/cli/run_command.hpp"

namespace biss::verbs::margin_test {

using Margin = InFolder;

constexpr const char* resolute = "pos26,nE,nW,crc6";

// 20 cycles at 5 MHz by a master without compensation; the delay is in nanoseconds of 200.
std::string simulate(const Folder& folder, const std::string& name, const std::string& delay,
                     const Words& more = {}) {
  const std::string capture = folder.path(name);
  run_ok(Words("simulate -f {} --clock 5MHz --slo-delay {} --cycles 20 --motion random -o {} "
               "--no-compensation --truth {}",
               resolute, delay, capture, folder.path("truth.csv")) +
         more);
  return capture;
}

Outcome decode(const std::string& capture, const Words& more) {
  return run(Words("decode {} -f {}", capture, resolute) + more);
}

// Checks that all 20 rows have this value in the column.
void expect_all(const std::string& csv, const std::string& marginal) {
  EXPECT_NE(csv.substr(0, csv.find('\n')).find(",marginal"), std::string::npos) << csv;
  const auto rows = rows_of(csv);
  EXPECT_EQ(rows.size(), 20U);
  for (const Row& row : rows) EXPECT_EQ(row.at("marginal"), marginal);
}

TEST_F(Margin, ChangeNearTheSampleOfAMasterWithoutCompensation_IsToldEverywhere) {
  // The sample is 100 ns after the edge, the margin 10 ns.
  for (const auto& [delay, marginal] : {std::pair{"89.8ns", "0"}, std::pair{"90.2ns", "1"},
                                        std::pair{"109.8ns", "1"}, std::pair{"110.2ns", "0"}}) {
    SCOPED_TRACE(delay);
    const std::string capture = simulate(folder, "line.vcd", delay);
    const std::string truth = content_of(folder.path("truth.csv"));
    expect_all(truth, marginal);
    const Outcome csv = decode(capture, "--to csv --no-compensation");
    expect_all(csv.out, marginal);
    expect_truth(rows_of(csv.out), rows_of(truth));
    const bool is = *marginal == '1';
    EXPECT_THAT(csv.err, testing::HasSubstr(is ? "marginal    20 of 20" : "marginal    0 of 20"));
    const Outcome lines = decode(capture, "--to jsonl --no-compensation");
    const std::string key = std::string("\"marginal\":") + marginal + ",";
    EXPECT_THAT(split(lines.out, '\n'), testing::Contains(testing::HasSubstr(key)).Times(20));
    EXPECT_EQ(decode(capture, "--no-compensation --fail-on marginal").status, is ? 1 : 0);
    EXPECT_EQ(decode(capture, "--no-compensation --fail-on any").status, 0);
  }
}

TEST_F(Margin, DecodersOwnSample_IsFarFromEveryChangeWhateverTheDelay) {
  for (const char* delay : {"0ns", "50ns", "100ns", "199ns", "1234ns"}) {
    expect_all(decode(simulate(folder, "line.vcd", delay), "--to csv").out, "0");
  }
}

TEST_F(Margin, ReadingsOfARecordedEncoder_HaveTheMastersWord) {
  for (const auto& [delay, marginal] : {std::pair{"89.8ns", "0"}, std::pair{"90.2ns", "1"}}) {
    const std::string capture = simulate(folder, "line.vcd", delay);
    const std::string readings = folder.path("readings.csv");
    run_ok("simulate -f {} --slo-from {} --no-compensation -o {} --readings {}", resolute, capture,
           folder.path("read.vcd"), readings);
    expect_all(content_of(readings), marginal);
  }
}

TEST_F(Margin, AnswersToARecordedMaster_AreNotJudged) {
  const std::string capture = simulate(folder, "line.vcd", "100ns");
  const std::string truth = folder.path("answers.csv");
  run_ok("simulate -f {} --ma-from {} -o {} --truth {}", resolute, capture,
         folder.path("answered.vcd"), truth);
  expect_all(content_of(truth), "");
}

// 50 MS/s: edges are accurate to 20 ns, and the margin is 10 ns.
TEST_F(Margin, SamplesTooFarApart_TellNothingAndSaySo) {
  const std::string capture = simulate(folder, "line.sr", "100ns", "--sample-rate 50MHz");
  expect_all(content_of(folder.path("truth.csv")), "1");
  const Outcome coarse = decode(capture, "--to csv --no-compensation");
  expect_all(coarse.out, "");
  EXPECT_THAT(coarse.err, testing::HasSubstr(
                              "not known           edges are accurate to 20 ns, 5 % of a period is "
                              "10 ns"));
  EXPECT_EQ(decode(capture, "--no-compensation --fail-on marginal").status, 0);
}

TEST_F(Margin, SamplesCloseEnough_TellWhatIsCertain) {
  // A sample of 2 ns: a distance below 8 ns in the capture was below 10 ns on the line. MA's edges
  // coincide with samples; 109 ns are recorded as 110 ns.
  for (const auto& [delay, marginal] :
       {std::pair{"100ns", "1"}, std::pair{"94ns", "1"}, std::pair{"109ns", "0"}}) {
    SCOPED_TRACE(delay);
    const std::string capture =
        simulate(folder, "line.sr", delay, "--sample-rate 500MHz --rate 10kHz");
    expect_all(content_of(folder.path("truth.csv")), "1");
    expect_all(decode(capture, "--to csv --no-compensation").out, marginal);
  }
}

TEST_F(Margin, ResolutionOfChanges_IsWhatIsSaid) {
  const std::string capture = simulate(folder, "line.vcd", "95ns");
  const auto with = [&](const char* resolution) {
    return decode(capture, Words("--to csv --no-compensation --resolution {}", resolution));
  };
  expect_all(with("0ns").out, "1");
  expect_all(with("5ns").out, "1");
  expect_all(with("6ns").out, "0");
  expect_all(with("11ns").out, "");
  EXPECT_EQ(with("-1ns").status, 2);
  EXPECT_EQ(with("2ms").status, 2);
}

}  // namespace biss::verbs::margin_test
