// Captures with known content: simulated ones, or those of hardware and of independent cores.
#include "tests/cli/reference_captures.hpp"
#include "tests/cli/run_command.hpp"

namespace biss::verbs::captures_test {

class Captures : public testing::TestWithParam<std::string> {};

TEST_P(Captures, EveryRow_IsAsTheTruthHasIt) {
  for (const ReferenceCapture& capture : reference_captures()) {
    SCOPED_TRACE(capture.path);
    const auto rows =
        rows_of(run_ok("decode {} -f {} --to csv", capture.path + GetParam(), capture.format).out);
    ASSERT_EQ(rows.size(), capture.frames.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      SCOPED_TRACE(i);
      const Row& row = rows[i];
      const ReferenceFrame& meant = capture.frames[i];
      EXPECT_EQ(row.at("cycle"), std::to_string(i));
      EXPECT_DOUBLE_EQ(std::stod(row.at("time_ns")), meant.time_ns);
      EXPECT_EQ(row.at("status"), meant.good ? "ok" : "crc");
      EXPECT_EQ(row.at("crc_ok"), meant.good ? "1" : "0");
      EXPECT_EQ(row.at("position"), meant.good ? std::to_string(meant.position) : "");
      EXPECT_EQ(row.at("nE"), meant.good ? meant.nE : "");
      EXPECT_EQ(row.at("nW"), meant.good ? meant.nW : "");
      EXPECT_NEAR(std::stod(row.at("line_delay_ns")), capture.line_delay_ns, 1.0);
      const double period_ns = 1e9 / std::stod(row.at("clock_hz"));
      EXPECT_NEAR(std::stod(row.at("ack_ns")), meant.ack_clocks * period_ns, 10.0);
      EXPECT_FALSE(row.at("raw").empty());
    }
  }
}

TEST_P(Captures, TheLinesAtTheSlave_GiveTheSamePositions) {
  if (GetParam() == ".csv") return;  // has only the two lines at the master
  const std::string file = reference_captures().back().path + ".vcd";
  const auto at_master = rows_of(run("decode {} -f pos26,nE,nW,crc6 --to csv", file).out);
  auto at_slave = rows_of(
      run_ok("decode {} -f pos26,nE,nW,crc6 --to csv --ma MA_at_slave --slo SLO_at_slave", file)
          .out);
  ASSERT_EQ(at_slave.size(), at_master.size());
  std::size_t good = 0;
  for (std::size_t i = 0; i < at_slave.size(); ++i) {
    // The bits were flipped between the two recorders.
    if (at_master[i].at("status") != "ok") continue;
    ++good;
    EXPECT_EQ(at_slave[i]["position"], at_master[i].at("position"));
    EXPECT_LT(std::stod(at_slave[i]["line_delay_ns"]), 100.0);
  }
  EXPECT_EQ(good, 30U);
}

INSTANTIATE_TEST_SUITE_P(Of, Captures, testing::Values(".vcd", ".csv"),
                         [](const auto& kind) { return kind.param.substr(1); });

}  // namespace biss::verbs::captures_test
