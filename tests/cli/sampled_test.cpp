// What `biss simulate` samples, `biss decode` reads: the positions of every cycle, at the rate that
// is chosen when none is given and at one that divides no clock.
#include <gtest/gtest.h>

#include <string>

#include "tests/cli/run_command.hpp"

namespace biss::cli {
namespace {

void expect_true_positions(const Folder& folder, const std::string& capture,
                           const std::vector<std::string>& options) {
  SCOPED_TRACE(capture);
  std::vector<std::string> arguments{"simulate", "-f", "resolute-26", "--cycles", "200"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  for (const std::string& more : {std::string("--motion"), std::string("random"), std::string("-o"),
                                  capture, std::string("--truth"), folder.path("truth.csv")}) {
    arguments.push_back(more);
  }
  const Outcome simulated = run(arguments);
  ASSERT_EQ(simulated.status, 0) << simulated.err;
  const Outcome decoded = run({"decode", "-f", "resolute-26", capture, "--to", "csv"});
  ASSERT_EQ(decoded.status, 0) << decoded.err;
  std::vector<Row> rows = rows_of(decoded.out);
  std::vector<Row> truth = rows_of(content_of(folder.path("truth.csv")));
  ASSERT_EQ(rows.size(), 200U);
  ASSERT_EQ(truth.size(), 200U);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i]["status"], "ok") << i;
    EXPECT_EQ(rows[i]["position"], truth[i]["position"]) << i;
  }
}

TEST(Sampled, SessionsAndSaleaesCsv_DecodeToTheTruth) {
  const Folder folder;
  for (const std::string clock : {"250kHz", "1MHz", "3MHz", "10MHz"}) {
    SCOPED_TRACE(clock);
    const std::vector<std::string> options{"--clock", clock, "--cable", "50m"};
    expect_true_positions(folder, folder.path("line.sr"), options);
    expect_true_positions(folder, folder.path("line.saleae.csv"), options);
  }
  expect_true_positions(folder, folder.path("odd.sr"),
                        {"--clock", "7MHz", "--sample-rate", "48MHz", "--cable", "20m"});
}

TEST(Sampled, RawSamples_AreWrittenAndNeedALayoutToBeRead) {
  const Folder folder;
  ASSERT_EQ(run({"simulate", "-f", "resolute-26", "-o", folder.path("line.bin")}).status, 0);
  const std::string samples = content_of(folder.path("line.bin"));
  EXPECT_GT(samples.size(), 10'000U);
  EXPECT_EQ(samples.front(), '\3');
  const Outcome unread = run({"decode", "-f", "resolute-26", folder.path("line.bin")});
  EXPECT_EQ(unread.status, 3);
  EXPECT_NE(unread.err.find("sample rate"), std::string::npos) << unread.err;
}

TEST(Sampled, SampleRateOfAFileOfChanges_IsWrongUsage) {
  const Folder folder;
  const Outcome wrong = run(
      {"simulate", "-f", "resolute-26", "--sample-rate", "100MHz", "-o", folder.path("line.vcd")});
  EXPECT_EQ(wrong.status, 2);
  EXPECT_NE(wrong.err.find("--sample-rate"), std::string::npos) << wrong.err;
  EXPECT_EQ(folder.files(), 0U);
}

TEST(Sampled, SessionOnStandardInput_DecodesTheSame) {
  const Folder folder;
  const std::string capture = folder.path("line.sr");
  ASSERT_EQ(run({"simulate", "-f", "resolute-26", "-o", capture}).status, 0);
  const Outcome file = run({"decode", "-f", "resolute-26", capture, "--to", "csv"});
  const Outcome input = run({"decode", "-f", "resolute-26", "-", "--to", "csv"}, capture);
  EXPECT_EQ(file.status, 0);
  EXPECT_EQ(file.out, input.out);
}

TEST(Sampled, SessionCutOff_IsDamaged) {
  const Folder folder;
  const std::string capture = folder.path("line.sr");
  ASSERT_EQ(run({"simulate", "-f", "resolute-26", "-o", capture}).status, 0);
  const std::string whole = content_of(capture);
  const Outcome cut = run(
      {"decode", "-f", "resolute-26", folder.file("cut.sr", whole.substr(0, whole.size() / 2))});
  EXPECT_EQ(cut.status, 3);
  EXPECT_NE(cut.err.find("cut.sr: is damaged"), std::string::npos) << cut.err;
}

}  // namespace
}  // namespace biss::cli
