// The table of all figures: what is measured, against what, and how fast it should be.
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

/// A line of the table. The figure is the median of the repetitions, beside it the best one.
struct Row {
  /// Also the name to filter for.
  std::string name{};
  Unit unit = Unit::nanoseconds;
  /// Name of the row it is compared with, empty for none.
  std::string reference{};
  /// The most that is wanted, in nanoseconds; 0 for none.
  double target = 0;
  /// The benchmark takes the time itself.
  bool own_time = false;
};

class Table {
 public:
  /// Registers `run` under the row's name. Rows of nanoseconds and items count items, those of
  /// megabytes count bytes; both by the state's own counters.
  void add(Row row, std::function<void(benchmark::State&)> run);
  void take(const benchmark::BenchmarkReporter::Run& run);

  /// The table as Markdown, without the rows that were not run.
  std::string text() const;
  /// What went wrong, a line a benchmark.
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

/// Where and how the figures were made: processor, compiler, flags.
std::string circumstances();

}  // namespace biss::bench
