// `biss decode` reads what `biss simulate` writes after it became the voltages of an oscilloscope:
// the true positions in the file of every maker, and what is said about wrong options.
#include "capture/test_scope.hpp"
#include "tests/cli/run_command.hpp"

namespace biss::verbs::analog_test {

constexpr Picoseconds step = nanoseconds(50);

// Ten cycles of a resolute-26 at 2 MHz as voltages.
class Analog : public testing::Test {
 protected:
  void SetUp() override {
    const std::string line = folder_.path("line.csv");
    run_ok("simulate -f resolute-26 --clock 2MHz --cycles 10 --motion random -o {} --truth {}",
           line, folder_.path("truth.csv"));
    truth_ = rows_of(content_of(folder_.path("truth.csv")));
    const std::vector<wire::Edge> edges = edges_of(line);
    const auto count = static_cast<std::size_t>(edges.back().time.count / step.count + 100);
    samples_ = capture::scope_samples(edges, step, count, 11);
  }

  void expect_decoded(const Words& more) const {
    expect_truth(rows_of(run_ok(Words("decode -f resolute-26 --to csv") + more).out), truth_);
  }

  void expect_refusal(const Words& more, int status, const std::string& message) const {
    EXPECT_THAT(run(Words("decode -f resolute-26") + more), fails(status, message));
  }

  std::string differential() const {
    std::string text = "Time [s],MA+,MA-,SLO+,SLO-\n";
    for (const capture::ScopeSample& s : samples_) {
      std::array<char, 128> row{};
      std::snprintf(row.data(), row.size(), "%.12f,%.3f,%.3f,%.3f,%.3f\n",
                    static_cast<double>(s.time.count) * 1e-12, s.ma, 3.5 - s.ma, s.slo,
                    3.5 - s.slo);
      text += row.data();
    }
    return folder_.file("pairs.csv", text);
  }

  Folder folder_;
  std::vector<Row> truth_;
  std::vector<capture::ScopeSample> samples_;
};

TEST_F(Analog, CsvOfEveryMaker_DecodesToTheTruth) {
  for (const capture::ScopeText& maker : capture::scope_texts) {
    SCOPED_TRACE(maker.name);
    const std::string path =
        folder_.file(std::string(maker.name) + ".csv", scope_text(maker, samples_, step));
    if (!maker.one_channel) {
      expect_decoded({path});
      expect_decoded({path, "--threshold", "1.6V:300mV"});
      continue;
    }
    std::vector<capture::ScopeSample> slo = samples_;
    for (capture::ScopeSample& sample : slo) sample.ma = sample.slo;
    expect_decoded({path, folder_.file("slo.csv", scope_text(maker, slo, step))});
  }
}

TEST_F(Analog, BinaryExportOfSaleae_DecodesToTheTruth) {
  for (const std::uint32_t version : {0U, 1U}) {
    expect_decoded({folder_.file("ma.bin", saleae_analog_text(samples_, step, false, version)),
                    folder_.file("slo.bin", saleae_analog_text(samples_, step, true, version))});
  }
}

TEST_F(Analog, DifferentialPairs_DecodeToTheTruth) {
  const std::string path = differential();
  expect_decoded({path, "--differential", "MA+-MA-=MA", "--differential", "SLO+-SLO-=SLO"});
  expect_decoded({path, "--differential", "MA+-MA-", "--ma", "MA+-MA-", "--slo", "SLO+"});
  expect_decoded({path, "--differential", "MA+-MA-=MA", "--differential", "SLO+-SLO-=SLO",
                  "--threshold=-100mV:1V"});
}

TEST_F(Analog, Converted_DecodesToTheTruth) {
  const std::string pairs = differential();
  const std::string line = folder_.path("converted.vcd");
  run_ok("convert {} {} --differential MA+-MA-=MA --differential SLO+-SLO-=SLO --threshold=0V:1V",
         pairs, line);
  expect_decoded({line});
  // A scope with a known increment gives the rate of the samples.
  const std::string scope =
      folder_.file("scope.csv", scope_text(capture::scope_texts[0], samples_, step));
  const std::string session = folder_.path("converted.sr");
  run_ok("convert {} {} --line CH1=MA --line CH2=SLO", scope, session);
  expect_decoded({session});
}

TEST_F(Analog, WrongOptions_AreNamed) {
  const std::string pairs = differential();
  const std::string line = folder_.path("line.csv");
  expect_refusal({pairs, "--differential", "MA+-MB-=MA"}, 2, "it has MA+, MA-, SLO+, SLO-");
  expect_refusal({pairs, "--differential", "MA"}, 2, "'MA' is not A-B or A-B=NAME");
  expect_refusal({pairs, "--differential", "MA+-MA-="}, 2, "is not A-B or A-B=NAME");
  expect_refusal({pairs, "--threshold", "1"}, 2, "no unit; use nV, uV, mV, V or kV");
  expect_refusal({pairs, "--threshold", "1V:-1V"}, 2, "the hysteresis must not be negative");
  expect_refusal({line, "--threshold", "1V"}, 2, "has levels, not voltages");
  expect_refusal({line, "--differential", "MA-SLO"}, 2, "has levels, not voltages");
  EXPECT_THAT(run("simulate -f resolute-26 --threshold 1V -o {}", folder_.path("x.vcd")),
              fails(2, "--ma-from"));
}

TEST_F(Analog, SignalsWithoutTwoLevels_NameTheOption) {
  std::vector<capture::ScopeSample> idle = samples_;
  for (capture::ScopeSample& sample : idle) sample.ma = sample.slo = 3.4;
  expect_refusal({folder_.file("idle.csv", scope_text(capture::scope_texts[0], idle, step))}, 3,
                 "no signal with two levels; give the threshold, as in --threshold 1.5V");
}

}  // namespace biss::verbs::analog_test
