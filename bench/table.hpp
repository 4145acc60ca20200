// The table of all figures: the subject, its reference, and its limit.
#pragma once

#include <benchmark/benchmark.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace biss::bench {

enum class Unit {
  nanoseconds,      ///< processor time an item
  megabytes,        ///< 10^6 bytes a second
  million_a_second  ///< 10^6 items a second
};

/// One row of the table. The figure is the median of the repetitions; the best one is shown next to
/// it.
struct Row {
  /// Also the name to filter for.
  std::string name{};
  Unit unit = Unit::nanoseconds;
  /// Name of the row it is compared with, empty for none.
  std::string reference{};
  /// The limit in nanoseconds an item; 0 for none.
  double target = 0;
  /// The limit as a share of the reference's time; 0 for none.
  double share = 0;
  /// The benchmark measures the time itself.
  bool own_time = false;
};

class Table {
 public:
  /// Registers `run` under the row's name. Rows of nanoseconds and items count items, rows of
  /// megabytes count bytes; both by the state's own counters.
  void add(Row row, std::function<void(benchmark::State&)> run);
  void take(const benchmark::BenchmarkReporter::Run& run);

  /// The table as Markdown, without the rows that were not run.
  std::string text() const;
  /// The errors, one line for each benchmark.
  const std::vector<std::string>& errors() const { return errors_; }

 private:
  struct Figure {
    double median = 0;
    double best = 0;
  };
  bool has(const std::string& name) const;
  Figure figure_of(const Row& row) const;
  std::string line_of(const Row& row) const;

  std::vector<Row> rows_;
  // Items or bytes a second of each repetition.
  std::map<std::string, std::vector<double>> rates_;
  std::vector<std::string> errors_;
};

/// The conditions of the measurement: processor, compiler, flags.
std::string circumstances();

}  // namespace biss::bench
