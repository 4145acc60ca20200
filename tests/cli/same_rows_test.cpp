// One capture in every format gives the same rows: simulated lines with every kind of fault, written
// as changes and as samples.
#include <array>
#include <cmath>
#include <cstdio>

#include "capture/event_csv.hpp"
#include "capture/saleae_binary.hpp"
#include "capture/samples.hpp"
#include "capture/sr.hpp"
#include "capture/test_fst.hpp"
#include "capture/test_scope.hpp"
#include "capture/vcd.hpp"
#include "decode/cycle_rules.hpp"
#include "sim/fault.hpp"
#include "tests/cli/run_command.hpp"

namespace biss::verbs::same_rows_test {

// 10, or as many as BISS_CAPTURES says: the long tests take 200.
std::size_t captures() {
  const char* const wanted = std::getenv("BISS_CAPTURES");
  return wanted == nullptr ? 10 : std::stoul(wanted);
}

using Edges = std::vector<wire::Edge>;

// \param make gives a writer to the sink
template <class Make>
std::string written(const Edges& edges, Make make) {
  std::string text;
  capture::StringSink sink(text);
  auto writer = make(sink);
  EXPECT_TRUE(writer.write(edges).ok());
  EXPECT_TRUE(writer.finish(edges.back().time).ok());
  return text;
}

const std::vector<std::string> ma_and_slo{"MA", "SLO"};

// A file of Saleae Logic 2 for one of the lines.
std::string saleae_of(const Edges& edges, wire::LineIndex line) {
  Edges own;
  for (wire::Edge edge : edges) {
    if (edge.line != line) continue;
    edge.line = 0;
    own.push_back(edge);
  }
  return written(own, [](capture::ByteSink& sink) {
    return capture::SaleaeBinaryWriter({"x"}, Hertz{}, sink);
  });
}

struct Spelling {
  const char* low;
  const char* high;
  bool exponent = false;  // of the times, as numpy.savetxt writes them
};

constexpr std::array<Spelling, 6> spellings{
    {{"0", "1"},
     {"0.0", "1.0"},
     {"0.000000000000000000e+00", "1.000000000000000000e+00", true},
     {"00", "01"},
     {"1", "2"},
     {"0.000", "3.300"}}};

std::string csv_of(const Edges& edges, const Spelling& spelling) {
  std::string text = "time_ns,MA,SLO\n";
  std::array<const char*, 2> levels{"", ""};
  for (std::size_t i = 0; i < edges.size(); ++i) {
    levels.at(edges[i].line) = edges[i].level == wire::Level::high ? spelling.high : spelling.low;
    if (i + 1 < edges.size() && edges[i + 1].time == edges[i].time) continue;
    std::array<char, 128> row{};
    const double time = static_cast<double>(edges[i].time.count) * 1e-3;
    const char* const ma = levels[0];
    const char* const slo = levels[1];
    if (spelling.exponent) {
      std::snprintf(row.data(), row.size(), "%.18e,%s,%s\n", time, ma, slo);
    } else {
      std::snprintf(row.data(), row.size(), "%.3f,%s,%s\n", time, ma, slo);
    }
    text += row.data();
  }
  return text;
}

struct Setting {
  const char* format;
  unsigned kilohertz;
};
constexpr std::array<Setting, 5> settings{{{"resolute-26", 2'500},
                                           {"fs-36-28", 10'000},
                                           {"ic-mhm", 4'000},
                                           {"fs-36-28", 5'000},
                                           {"lenz-b3", 1'000}}};

// Pulses of faults have 2 % of a period or more; those of a line that is stuck may be shorter.
constexpr unsigned samples_of_period = 100;

// Whether samples may show something else between these times: a pulse shorter than two samples,
// edges of both lines in another order, an edge of SLO where the decoder samples, which is that long
// after a rising edge of MA, or a period of MA at the limit of an irregular one.
bool is_below_a_sample(const Edges& edges, Picoseconds step, Picoseconds from, Picoseconds to,
                       Picoseconds sampling) {
  const auto near = [&](Picoseconds a, Picoseconds b, std::int64_t samples) {
    return std::abs(a.count - b.count) < samples * step.count;
  };
  const Picoseconds period = step * samples_of_period;
  std::vector<Picoseconds> sampled;
  for (const wire::Edge& edge : edges) {
    if (edge.line != 0 || edge.level != wire::Level::high) continue;
    const Picoseconds since = sampled.empty() ? period : edge.time + sampling - sampled.back();
    const bool at_limit = near(since, period * decode::irregular_below_percent / 100, 1) ||
                          near(since, period * decode::irregular_above_percent / 100, 1);
    if (at_limit && edge.time >= from && edge.time <= to) return true;
    sampled.push_back(edge.time + sampling);
  }
  for (std::size_t i = 1; i < edges.size(); ++i) {
    const wire::Edge& edge = edges[i];
    if (edge.time < from || edge.time > to) continue;
    for (std::size_t k = i; k-- > 0 && near(edge.time, edges[k].time, 2);) {
      if (edges[k].line == edge.line || near(edge.time, edges[k].time, 1)) return true;
    }
    if (edge.line == 1 && std::any_of(sampled.begin(), sampled.end(),
                                      [&](Picoseconds time) { return near(time, edge.time, 2); })) {
      return true;
    }
  }
  return false;
}

Picoseconds ps_of(double ns) { return Picoseconds{std::llround(ns * 1e3)}; }

class SameRows {
 public:
  explicit SameRows(std::size_t number) : number_(number) {}

  void run_all() {
    if (!simulate()) return;
    const std::string vcd = folder_.file("line.vcd", written(edges_, [](capture::ByteSink& sink) {
                                           return capture::VcdWriter(ma_and_slo, sink);
                                         }));
    rows_ = decode({vcd});
    ASSERT_FALSE(rows_.empty());
    expect_changes();
    expect_samples();
  }

  static inline std::size_t compared = 0;
  static inline std::size_t excepted = 0;

 private:
  bool simulate() {
    const auto kind = [](std::size_t k) {
      return std::string(sim::fault_list[k % sim::simulated_fault_count].name);
    };
    // Some faults need the format of BiSS Safety, and each kind is given once.
    const std::string other = kind(number_ * 7 + (number_ % 11 == 5 ? 4 : 3));
    const std::string line = folder_.path("line.csv");
    for (std::size_t i = 0; i < settings.size(); ++i) {
      setting_ = settings[(number_ + i) % settings.size()];
      const Outcome made =
          run("simulate -f {} --clock {} --cable {} --cycles 6 --motion random --seed {} --fault "
              "{} --fault {} -o {}",
              setting_.format, std::to_string(setting_.kilohertz) + "kHz",
              std::to_string(1 + number_ % 40) + "m", std::to_string(number_ + 1),
              kind(number_) + ":0.3", other + ":0.1", line);
      if (made.status != 0) continue;
      edges_ = edges_of(line);
      return true;
    }
    ADD_FAILURE() << "no format has " << kind(number_);
    return false;
  }

  std::vector<Row> decode(Words files) const {
    files.insert(files.begin(), {"decode", "-f", setting_.format, "--to", "csv"});
    return rows_of(run_ok(files).out);
  }

  void expect_changes() {
    const auto same = [this](Words files) {
      const std::string name = files.front();
      EXPECT_EQ(decode(std::move(files)), rows_) << name;
      ++compared;
    };
    for (std::size_t i = 0; i < spellings.size(); ++i) {
      same({folder_.file("spelled" + std::to_string(i) + ".csv", csv_of(edges_, spellings.at(i)))});
    }
    same({folder_.file("line.fst", fst_of(capture::fst_parts_of({"MA", "SLO"}, edges_)))});
    same({folder_.file("line.saleae.csv", written(edges_, [](capture::ByteSink& sink) {
                         return capture::EventCsvWriter(ma_and_slo, sink,
                                                        capture::CsvDialect::saleae);
                       }))});
    // Doubles are finer than a picosecond.
    same({folder_.file("MA.bin", saleae_of(edges_, 0)),
          folder_.file("SLO.bin", saleae_of(edges_, 1)), "--resolution", "1ps"});
  }

  void expect_samples() {
    const Hertz rate{setting_.kilohertz * samples_of_period * 1'000};
    const Picoseconds step{picoseconds_per_second / rate.count};
    const std::string raw =
        folder_.file("line.raw", written(edges_, [rate](capture::ByteSink& sink) {
                       return capture::RawWriter(capture::packed_layout(ma_and_slo, rate), sink);
                     }));
    same_samples(
        "raw", step,
        {raw, "--raw-rate", std::to_string(rate.count) + "Hz", "--ma", "D0", "--slo", "D1"});
    same_samples("sr", step,
                 {folder_.file("line.sr", written(edges_, [rate](capture::ByteSink& sink) {
                                 return capture::SrWriter(ma_and_slo, rate, sink);
                               }))});
    const auto count = static_cast<std::size_t>(edges_.back().time.count / step.count + 100);
    const auto samples = capture::scope_samples(edges_, step, count, number_);
    const capture::ScopeText& maker = capture::scope_texts.at(number_ % 4 == 0 ? 2 : 7);
    same_samples("scope", step,
                 {folder_.file("scope.csv", scope_text(maker, samples, step)), "--ma",
                  number_ % 4 == 0 ? "CH1" : "Ampl1", "--slo", number_ % 4 == 0 ? "CH2" : "Ampl2"});
  }

  void same_samples(const std::string& name, Picoseconds step, const Words& files) {
    ++compared;
    std::vector<Row> rows = decode(files);
    const double step_ns = static_cast<double>(step.count) * 1e-3;
    // The oscilloscope goes on after the last edge, so that the last cycle may have more bits.
    const std::size_t last = name == "scope" ? rows_.size() - 1 : rows_.size();
    for (std::size_t i = 0; i < (name == "scope" ? last : std::max(rows.size(), last)); ++i) {
      const bool both = i < rows.size() && i < rows_.size();
      const double begin = i < rows_.size() ? std::stod(rows_[i]["time_ns"]) : 0;
      const double end = i + 1 < rows_.size() ? std::stod(rows_[i + 1]["time_ns"]) : 1e12;
      bool equal = both;
      std::string how = both ? "" : "rows";
      for (const auto& [column, value] : both ? rows_[i] : Row()) {
        const bool compared_column = column == "status" || column == "raw" ||
                                     column.starts_with("position") || column.starts_with("nE") ||
                                     column.starts_with("nW") || column.starts_with("crc");
        if (!compared_column || rows[i][column] == value) continue;
        equal = false;
        how += column + ' ' + rows[i][column] + " for " + value + "; ";
      }
      if (both) {
        const double late = std::stod(rows[i]["time_ns"]) - begin;
        if (std::abs(late) > step_ns + 1e-3) {
          equal = false;
          how += "late by " + std::to_string(late);
        }
      }
      if (equal) continue;
      const std::string& delay = rows_[std::min(i, rows_.size() - 1)]["line_delay_ns"];
      const double sampling_ns = (delay.empty() ? 0 : std::stod(delay)) + 5e5 / setting_.kilohertz;
      if (is_below_a_sample(edges_, step, ps_of(begin - 1'000), ps_of(end), ps_of(sampling_ns))) {
        ++excepted;
        return;
      }
      ADD_FAILURE() << name << " of capture " << number_ << " in " << setting_.format << ", row "
                    << i << ": " << how;
      return;
    }
  }

  std::size_t number_;
  Folder folder_;
  Setting setting_{};
  Edges edges_;
  std::vector<Row> rows_;
};

TEST(SameRows, EveryFaultInEveryFormat_GivesTheRowsOfTheVcd) {
  for (std::size_t i = 0; i < captures(); ++i) {
    SCOPED_TRACE(i);
    SameRows(i).run_all();
  }
  std::printf("%zu captures, %zu files compared; %zu differ in what is shorter than a sample\n",
              captures(), SameRows::compared, SameRows::excepted);
  EXPECT_LE(20 * SameRows::excepted, SameRows::compared);
}

}  // namespace biss::verbs::same_rows_test
