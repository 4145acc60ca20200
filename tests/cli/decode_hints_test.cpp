// The options proposed in the summary of `decode` work, and its statements about the lines are
// true.
#include "tests/cli/run_command.hpp"

namespace biss::verbs::decode_hints_test {

using DecodeHints = InFolder;
using testing::HasSubstr;
using testing::Not;

constexpr const char* format = "pos26,nE,nW,crc6";

// A master that reads a register.
Words with_access(const Folder& folder) {
  const std::string page = "bank 0\n0x40: 00 00 62 1E FF FF FF FF 00 00 00 00 00 00 8C FF\n";
  return {"--registers", folder.file("registers.txt", page), "--access", "read:0x42"};
}

std::string simulate(const Folder& folder, const Words& more = {}) {
  const std::string capture = folder.path("line.csv");
  Words words = Words("simulate -f {} --clock 1MHz --seed 3 -o {}", format, capture) + more;
  if (std::find(more.begin(), more.end(), "--access") == more.end()) {
    words.insert(words.end(), {"--cycles", "40"});
  }
  run_ok(words);
  return capture;
}

Outcome decode(const Words& words, const Words& more = {}) {
  return run(Words("decode --to csv") + words + more);
}

// The option and its value in the line `try` of the summary.
Words proposed(const std::string& summary) {
  const std::size_t line = summary.find("\ntry ");
  const std::size_t at = summary.find(" --", line);
  if (line == std::string::npos || at == std::string::npos) return {};
  const std::size_t space = summary.find(' ', at + 1);
  const std::size_t end = summary.find_first_of(" \n;", space + 1);
  return {summary.substr(at + 1, space - at - 1), summary.substr(space + 1, end - space - 1)};
}

void expect_all_ok(const Outcome& outcome, std::size_t cycles = 40) {
  const auto rows = rows_of(outcome.out);
  EXPECT_EQ(rows.size(), cycles) << outcome.err;
  for (const Row& row : rows) EXPECT_EQ(row.at("status"), "ok") << outcome.err;
}

// The capture with its lines in two files; MA is delayed by this time.
Words with_late_ma(const Folder& folder, const std::string& capture, double later_ns) {
  const std::string late = rewritten(folder, "late.csv", capture, [&](Row& row) {
    row["time_ns"] = std::to_string(std::stod(row["time_ns"]) + later_ns);
  });
  return {one_line(folder, "ma.csv", "MA", late, "MA"),
          one_line(folder, "slo.csv", "SLO", capture, "SLO"), "-f", format};
}

std::string inverted(const Folder& folder, const std::string& capture, bool ma, bool slo) {
  const auto invert = [](std::string& level) { level = level == "0" ? "1" : "0"; };
  return rewritten(folder, "inverted.csv", capture, [&](Row& row) {
    if (ma) invert(row["MA"]);
    if (slo) invert(row["SLO"]);
  });
}

TEST_F(DecodeHints, AckOfAlwaysTheSameClocks_GetsItsNumber) {
  const std::string capture = simulate(folder, "--ack-clocks 9");
  for (const Words& timing : {Words{"--ack-max", "2us"}, Words{"--ack-clocks", "20"}}) {
    const Outcome refused = decode({capture, "-f", format}, timing);
    EXPECT_THAT(refused.err, HasSubstr("40 ack_range"));
    const Words hint = proposed(refused.err);
    EXPECT_EQ(hint, (Words{"--ack-clocks", "9"})) << refused.err;
    expect_all_ok(decode({capture, "-f", format}, hint));
  }
}

TEST_F(DecodeHints, AckThatVaries_GetsALongerBoundOrNone) {
  // 40 cycles with 3 clocks of ACK, and 40 with 9 clocks.
  const std::string first = folder.path("first.csv");
  std::filesystem::rename(simulate(folder, "--ack-clocks 3"), first);
  const std::string capture = joined(folder, first, simulate(folder, "--ack-clocks 9"));
  const Outcome refused = decode({capture, "-f", format}, "--ack-max 3us");
  EXPECT_THAT(refused.err, HasSubstr("40 ack_range"));
  const Words hint = proposed(refused.err);
  EXPECT_EQ(hint, (Words{"--ack-max", "9000ns"})) << refused.err;
  expect_all_ok(decode({capture, "-f", format}, hint), 80);
  const Outcome fixed = decode({capture, "-f", format}, "--ack-clocks 2");
  EXPECT_THAT(fixed.err, HasSubstr("leave out --ack-clocks"));
  expect_all_ok(decode({capture, "-f", format}), 80);
}

TEST_F(DecodeHints, SloASampleBeforeMa_GetsAResolution) {
  const Words early = with_late_ma(folder, simulate(folder), 8);
  const Outcome refused = decode(early);
  EXPECT_THAT(refused.err, HasSubstr("40 response_range"));
  const Words hint = proposed(refused.err);
  EXPECT_EQ(hint, (Words{"--resolution", "8ns"})) << refused.err;
  expect_all_ok(decode(early, hint));
}

TEST_F(DecodeHints, SloFarBeforeMa_IsNoQuestionOfResolution) {
  const Outcome refused = decode(with_late_ma(folder, simulate(folder), 300));
  EXPECT_THAT(refused.err, HasSubstr("40 response_range"));
  EXPECT_THAT(refused.err, HasSubstr("which interface the device has"));
  EXPECT_THAT(refused.err, Not(HasSubstr("--resolution")));
}

TEST_F(DecodeHints, LinesExchanged_AreReadTheOtherWayRound) {
  const std::string capture = simulate(folder);
  const Outcome swapped = decode({capture, "-f", format, "--ma", "SLO", "--slo", "MA"});
  EXPECT_THAT(swapped.err, HasSubstr("exchange --ma and --slo"));
  expect_all_ok(decode({capture, "-f", format, "--ma", "MA", "--slo", "SLO"}));
}

TEST_F(DecodeHints, CdsOfAMasterThatUsesRegisters_IsLeftOut) {
  const std::string capture = simulate(folder, with_access(folder));
  const Outcome refused = decode({capture, "-f", std::string(format) + ";cds0"});
  EXPECT_THAT(refused.err, HasSubstr("leave ;cds0 out"));
  for (const Row& row : rows_of(decode({capture, "-f", format}).out)) {
    EXPECT_EQ(row.at("status"), "ok");
  }
}

TEST(DecodeLines, InvertedLines_GiveTheSameRows) {
  const Folder folder;
  const std::string capture = simulate(folder, "--slo-delay 61ns");
  const Outcome upright = decode({capture, "-f", format});
  EXPECT_THAT(upright.err, Not(HasSubstr("inverted")));
  EXPECT_EQ(rows_of(upright.out).at(0).at("line_delay_ns"), "61");
  for (const auto& [ma, slo] : {std::pair{true, false}, {false, true}, {true, true}}) {
    const std::string other = inverted(folder, capture, ma, slo);
    const Outcome measured = decode({other, "-f", format});
    EXPECT_EQ(measured.out, upright.out);
    EXPECT_EQ(measured.err.find("MA = MA (inverted)") != std::string::npos, ma) << measured.err;
    EXPECT_EQ(measured.err.find("SLO = SLO (inverted)") != std::string::npos, slo) << measured.err;
    Words given;
    if (ma) given.emplace_back("--invert-ma");
    if (slo) given.emplace_back("--invert-slo");
    EXPECT_EQ(decode({other, "-f", format}, given).out, upright.out);
  }
}

TEST(DecodeLines, InvertedLines_AreReadByEveryVerb) {
  const Folder folder;
  const std::string capture = simulate(folder, with_access(folder));
  const std::string other = inverted(folder, capture, true, true);
  for (const char* const verb : {"registers", "check"}) {
    const Outcome upright = run("{} {} -f {} --to csv", verb, capture, format);
    EXPECT_EQ(run("{} {} -f {} --to csv", verb, other, format).out, upright.out);
    EXPECT_EQ(run("{} {} -f {} --to csv --invert-ma --invert-slo", verb, other, format).out,
              upright.out);
  }
}

}  // namespace biss::verbs::decode_hints_test
