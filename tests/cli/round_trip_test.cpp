// `biss decode` reads the output of `biss simulate`: every undamaged cycle is right.
#include <cmath>

#include "tests/cli/run_command.hpp"

namespace biss::verbs::round_trip_test {

using DecodeVerb = InFolder;
using testing::HasSubstr;
using testing::Not;

constexpr const char* usual_format = "pos26,nE,nW,crc6";

struct Case {
  std::string format;
  std::string clock;
  std::string cable;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {"resolute-18", "250kHz", "1m"},
      {"resolute-26", "10MHz", "50m"},
      {"resolute-32", "1MHz", "0.5m"},
      {"fortis-36", "5MHz", "100m"},
      {"fs-36-28", "10MHz", "20m"},
      {"ic-mhm", "4MHz", "3m"},
      {"ic-lgc", "2.5MHz", "10m"},
      {"lenz-b3", "5MHz", "30m"},
      {"faulhaber-aemt", "2MHz", "1m"},
      {"kuebler-s36-23", "80kHz", "100m"},
      {"waycon-mxs2-20", "1MHz", "7m"},
      {"mt16,st19:gray,E,W,crc8", "8MHz", "25m"},
      {"pos64,crc16+pos3,crc3+pad5,pos40,nE,nW,crc6", "10MHz", "1m"}};
  return all;
}

// Compares rows with the truth file by time; counts the cycles that are ok.
std::size_t expect_truth(const std::vector<Row>& rows, const std::vector<Row>& truth,
                         double period_ns) {
  EXPECT_EQ(rows.size(), truth.size());
  std::size_t good = 0;
  bool damaged_before = false;
  for (std::size_t i = 0; i < rows.size() && i < truth.size(); ++i) {
    SCOPED_TRACE(i);
    Row row = rows[i];
    Row meant = truth[i];
    EXPECT_LE(std::abs(std::stod(row["time_ns"]) - std::stod(meant["time_ns"])), period_ns / 2);
    const bool damaged = !meant["faults"].empty();
    if (!damaged && !damaged_before) {
      EXPECT_EQ(row["status"], "ok");
    }
    if (row["status"] == "ok") {
      ++good;
      EXPECT_FALSE(damaged);
      for (const auto& [name, value] : meant) {
        if (name.starts_with("position")) {
          EXPECT_EQ(row[name], value) << name;
        }
      }
    }
    damaged_before = damaged;
  }
  return good;
}

class RoundTrip : public testing::TestWithParam<std::string> {};

TEST_P(RoundTrip, EveryCatalogueNameClockAndCable_EveryPositionIsRight) {
  const Folder folder;
  for (const Case& one : cases()) {
    SCOPED_TRACE(one.format + " at " + one.clock + " with " + one.cable);
    const std::string capture = folder.path("line" + GetParam());
    const std::string truth = folder.path("truth.csv");
    run_ok("simulate -f {} --clock {} --cable {} --cycles 60 --motion random -o {} --truth {}",
           one.format, one.clock, one.cable, capture, truth);
    const auto rows = rows_of(run_ok("decode {} -f {} --to csv", capture, one.format).out);
    ASSERT_FALSE(rows.empty());
    const double period_ns = 1e9 / std::stod(rows[0].at("clock_hz"));
    EXPECT_EQ(expect_truth(rows, rows_of(content_of(truth)), period_ns), 60U);
  }
}

TEST_P(RoundTrip, FlippedBits_SpoilTheirCyclesAndNoOther) {
  const Folder folder;
  const std::string capture = folder.path("line" + GetParam());
  const std::string truth = folder.path("truth.csv");
  run_ok(
      "simulate -f resolute-26 --clock 4MHz --cycles 500 --fault flip:0.1 --seed 7 -o {} "
      "--truth {}",
      capture, truth);
  const Outcome read = run_ok("decode {} -f resolute-26 --to csv", capture);
  const std::size_t good = expect_truth(rows_of(read.out), rows_of(content_of(truth)), 250);
  EXPECT_GT(good, 400U);
  EXPECT_LT(good, 500U);
  EXPECT_EQ(run("decode {} -f resolute-26 --fail-on crc", capture).status, 1);
  run_ok("decode {} -f resolute-26 --fail-on no_response", capture);
}

INSTANTIATE_TEST_SUITE_P(As, RoundTrip, testing::Values(".vcd", ".csv"),
                         [](const auto& kind) { return kind.param.substr(1); });

// In cycle 26 of the first line the encoder restarts after its frame and takes another position.
TEST(Truth, EncoderThatTakesTwoPositionsInACycle_IsTheOneThatWasSent) {
  const Folder folder;
  const std::string capture = folder.path("line.vcd");
  const std::string truth = folder.path("truth.csv");
  for (const char* fault : {"brown_out:0.6", "glitch_ma_idle:0.6", "lost_clock:0.6"}) {
    run_ok(
        "simulate -f pos36,crc16 --clock 10MHz --cycles 400 --seed 318441197 --motion "
        "sine --cable 100m --jitter 5ns --no-compensation --fault {} -o {} --truth {}",
        fault, capture, truth);
    const auto meant = rows_of(content_of(truth));
    auto next = meant.begin();
    std::size_t good = 0;
    for (Row& row : rows_of(run("decode {} -f pos36,crc16 --to csv", capture).out)) {
      if (row["status"] != "ok") continue;
      while (next != meant.end() && std::stod(next->at("time_ns")) < std::stod(row["time_ns"]) - 50)
        ++next;
      ASSERT_NE(next, meant.end());
      EXPECT_EQ(next->at("position"), row["position"]) << fault << ", cycle " << next->at("cycle");
      EXPECT_NE(next->at("sampled_ns"), "");
      ++good;
    }
    EXPECT_GT(good, 50U) << fault;
  }
}

TEST(Truth, CycleInWhichNoPositionWasTaken_HasNone) {
  const Folder folder;
  const std::string truth = folder.path("truth.csv");
  for (const char* fault : {"no_answer@3", "exchange@3"}) {
    run_ok("simulate -f fs-36-28 --cycles 8 --fault {} -o {} --truth {}", fault,
           folder.path("line.vcd"), truth);
    const auto rows = rows_of(content_of(truth));
    ASSERT_EQ(rows.size(), 8U);
    for (const char* name : {"position", "nE", "nW", "position2", "nE2", "nW2", "sampled_ns"}) {
      EXPECT_EQ(rows[3].at(name), "") << fault << ' ' << name;
      EXPECT_NE(rows[2].at(name), "") << fault << ' ' << name;
    }
    EXPECT_NE(rows[3].at("faults"), "") << fault;
  }
}

// One capture of a few cycles, as text.
std::string csv_capture(const Folder& folder) {
  const std::string path = folder.path("line.csv");
  run_ok("simulate -f {} --cycles 20 -o {}", usual_format, path);
  return path;
}

TEST_F(DecodeVerb, EachLineInAFileOfItsOwn_GivesTheSameRows) {
  const std::string whole = csv_capture(folder);
  const std::string ma_file = one_line(folder, "ma.csv", "MA", whole, "D0");
  const std::string slo_file = one_line(folder, "slo.csv", "SLO", whole, "D0");
  const auto told = run_ok("decode {} {} --ma {} --slo {} -f {} --to csv", ma_file, slo_file,
                           ma_file + ":D0", slo_file + ":D0", usual_format);
  EXPECT_EQ(told.out, run("decode {} -f {} --to csv", whole, usual_format).out);
  const auto found = run("decode {} {} -f {} --to csv", slo_file, ma_file, usual_format);
  EXPECT_EQ(found.out, told.out) << found.err;
}

TEST_F(DecodeVerb, StandardInput_IsReadLikeAFile) {
  const std::string capture = csv_capture(folder);
  const auto piped = run_ok({"decode", "-", "-f", usual_format, "--to", "csv"}, capture);
  EXPECT_EQ(piped.out, run("decode {} -f {} --to csv", capture, usual_format).out);
}

TEST_F(DecodeVerb, WithoutFormatOfAnAxisAtRest_NothingIsCalledOk) {
  const std::string capture = folder.path("line.csv");
  run_ok({"simulate", "-f", usual_format, "--cycles", "20", "--motion", "constant", "-o", capture});
  const auto outcome = run_ok("decode {} --to csv", capture);
  EXPECT_EQ(outcome.out.substr(0, outcome.out.find('\n')),
            "cycle,time_ns,status,position,nE,nW,crc_ok,line_delay_ns,ack_ns,clock_hz,raw,marginal,"
            "safety,limits");
  const auto rows = rows_of(outcome.out);
  ASSERT_EQ(rows.size(), 20U);
  for (const Row& row : rows) {
    EXPECT_EQ(row.at("status"), "unchecked");
    EXPECT_EQ(row.at("position") + row.at("nE") + row.at("nW") + row.at("crc_ok"), "");
    EXPECT_EQ(row.at("raw").substr(0, 2), "0x");
  }
  EXPECT_THAT(outcome.err, HasSubstr("20 unchecked"));
  EXPECT_THAT(outcome.err, HasSubstr("give -f FORMAT"));
  EXPECT_THAT(outcome.err, Not(HasSubstr("nE = 0")));
  EXPECT_EQ(run("decode {} --fail-on any", capture).status, 1);
  run_ok("decode {} --fail-on truncated", capture);
  for (const char* unknown : {"crc", "nE", "nW"}) {
    EXPECT_THAT(run("decode {} --fail-on {}", capture, unknown), fails(2, "give -f")) << unknown;
  }
  EXPECT_EQ(run("decode {} -f none --to csv", capture).out, outcome.out);
  EXPECT_EQ(run("crc -f none 5").status, 2);
}

std::string header_for(const Folder& folder, const std::string& format) {
  const std::string path = folder.path("line.vcd");
  run_ok("simulate -f {} --cycles 1 -o {}", format, path);
  const std::string out = run("decode {} -f {} --to csv", path, format).out;
  return out.substr(0, out.find('\n'));
}

TEST_F(DecodeVerb, ColumnsOfAFormat_StandBehindTheElevenInOrder) {
  const std::string eleven =
      "cycle,time_ns,status,position,nE,nW,crc_ok,line_delay_ns,ack_ns,clock_hz,raw";
  EXPECT_EQ(header_for(folder, usual_format), eleven + ",marginal,safety,limits");
  EXPECT_EQ(header_for(folder, "fs-36-28"),
            eleven + ",position2,nE2,nW2,crc2_ok,lc2,marginal,safety,limits");
  EXPECT_EQ(header_for(folder, "mt12,st20,nE,nW,lc6,crc16"),
            eleven + ",lc,mt,st,marginal,safety,limits");
}

TEST_F(DecodeVerb, SinceAndUntil_KeepTheNumbersOfTheCapture) {
  const std::string capture = csv_capture(folder);
  const auto all = rows_of(run("decode {} --to csv", capture).out);
  ASSERT_EQ(all.size(), 20U);
  const auto some = rows_of(run("decode {} --to csv --since {} --until {}", capture,
                                all[5].at("time_ns") + "ns", all[9].at("time_ns") + "ns")
                                .out);
  ASSERT_EQ(some.size(), 5U);
  EXPECT_EQ(some.front().at("cycle"), "5");
  EXPECT_EQ(some.back().at("cycle"), "9");
}

}  // namespace biss::verbs::round_trip_test
