// Captures made by hardware and by independent cores, against what they are known to hold.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "tests/cli/run_command.hpp"

namespace biss::cli {
namespace {

struct Reference {
  std::string name;
  std::string format;
  double line_delay_ns;
};

const std::vector<Reference>& references() {
  static const std::vector<Reference> all{
      {"hardware_32bit_1MHz", "pos32,nE,nW,crc6", 112},
      {"cores_26bit_1MHz", "pos26,nE,nW,crc6", 8.5},
      {"cores_26bit_10MHz_delay200ns", "pos26,nE,nW,crc6", 213.75}};
  return all;
}

class Captures : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    folder_ = shared_captures();
    if (!folder_) GTEST_SKIP() << "no reference captures: set BISS_SHARED to their folder";
  }
  std::string path(const std::string& name) const { return (*folder_ / name).string(); }

 private:
  std::optional<std::filesystem::path> folder_;
};

std::string decimal(const std::string& hex) {
  return std::to_string(std::strtoull(hex.c_str(), nullptr, 16));
}

TEST_P(Captures, EveryRow_IsAsTheTruthHasIt) {
  for (const Reference& reference : references()) {
    SCOPED_TRACE(reference.name);
    const Outcome outcome =
        run({"decode", path(reference.name + GetParam()), "-f", reference.format, "--to", "csv"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto rows = rows_of(outcome.out);
    const auto truth = rows_of(content_of(path(reference.name + ".truth.csv")));
    ASSERT_EQ(rows.size(), truth.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      SCOPED_TRACE(i);
      Row row = rows[i];
      Row meant = truth[i];
      EXPECT_EQ(row["cycle"], std::to_string(i));
      EXPECT_DOUBLE_EQ(std::stod(row["time_ns"]), std::stod(meant["t_first_ma_fall_ns"]));
      const bool good = meant["crc_ok_on_wire"] == "1";
      EXPECT_EQ(row["status"], good ? "ok" : "crc");
      EXPECT_EQ(row["crc_ok"], meant["crc_ok_on_wire"]);
      EXPECT_EQ(row["position"], good ? decimal(meant["position_hex"]) : "");
      EXPECT_EQ(row["nE"], good ? meant["nE"] : "");
      EXPECT_EQ(row["nW"], good ? meant["nW"] : "");
      EXPECT_NEAR(std::stod(row["line_delay_ns"]), reference.line_delay_ns, 1.0);
      const double period_ns = 1e9 / std::stod(row["clock_hz"]);
      EXPECT_NEAR(std::stod(row["ack_ns"]), std::stod(meant["ack_clocks"]) * period_ns, 10.0);
      EXPECT_FALSE(row["raw"].empty());
    }
  }
}

TEST_P(Captures, TheLinesAtTheSlave_GiveTheSamePositions) {
  if (GetParam() == ".csv") return;  // has the two lines at the master only
  const std::string file = path("cores_26bit_10MHz_delay200ns.vcd");
  const auto at_master =
      rows_of(run({"decode", file, "-f", "pos26,nE,nW,crc6", "--to", "csv"}).out);
  const Outcome outcome = run({"decode", file, "-f", "pos26,nE,nW,crc6", "--to", "csv", "--ma",
                               "MA_at_slave", "--slo", "SLO_at_slave"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  auto at_slave = rows_of(outcome.out);
  ASSERT_EQ(at_slave.size(), at_master.size());
  std::size_t good = 0;
  for (std::size_t i = 0; i < at_slave.size(); ++i) {
    // The bits were flipped between the two.
    if (at_master[i].at("status") != "ok") continue;
    ++good;
    EXPECT_EQ(at_slave[i]["position"], at_master[i].at("position"));
    EXPECT_LT(std::stod(at_slave[i]["line_delay_ns"]), 100.0);
  }
  EXPECT_EQ(good, 30U);
}

INSTANTIATE_TEST_SUITE_P(Of, Captures, testing::Values(".vcd", ".csv"),
                         [](const auto& kind) { return kind.param.substr(1); });

}  // namespace
}  // namespace biss::cli
