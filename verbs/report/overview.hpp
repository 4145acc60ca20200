// The overview of a whole capture in a page: lowest and highest values against time, and counts by
// cause.
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "report/table.hpp"

namespace biss::verbs {

/// Takes all rows of `biss decode`, in memory that does not grow with them: rows are counted in groups
/// of the same size, which doubles when there are too many of them.
class Overview {
 public:
  explicit Overview(std::span<const report::Column> columns);

  void add(std::span<const report::Cell> cells);

  std::uint64_t rows() const { return rows_; }
  /// The same as `envelope` and `causes` of view/src/core/report.ts.
  nlohmann::json envelope() const;
  nlohmann::json causes() const;

 private:
  struct Extremes {
    double low = std::numeric_limits<double>::quiet_NaN();
    double high = std::numeric_limits<double>::quiet_NaN();

    void take(const Extremes& other);
  };
  struct Group {
    std::int64_t time = 0;
    std::vector<Extremes> values;
    /// By place in causes_.
    std::vector<std::uint64_t> counts;

    void count(std::size_t cause, std::uint64_t times = 1);
  };
  struct Cause {
    std::string column;
    std::string name;
  };

  Group& group_for(std::int64_t time);
  void join_groups();
  void count_cells(Group& group, std::span<const report::Cell> cells);
  std::size_t cause_for(const std::string& column, std::string_view name);

  std::size_t time_column_ = 0;
  // Places of the columns that are drawn, and of the columns with causes.
  std::vector<std::pair<std::size_t, std::string>> drawn_;
  std::vector<std::pair<std::size_t, report::Column>> counted_;
  std::vector<Cause> causes_;
  std::vector<Group> groups_;
  std::uint64_t each_ = 1;
  std::uint64_t in_last_ = 0;
  std::uint64_t rows_ = 0;
  std::int64_t last_time_ = 0;
};

}  // namespace biss::verbs
