#include "verbs/report/overview.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>

namespace biss::verbs {

namespace {

using nlohmann::json;

constexpr std::size_t groups_max = 10'000;
// Bins of the pictures next to the counts.
constexpr std::size_t bins = 60;

// Times in picoseconds, as in the page.
std::optional<double> number_of(const report::Cell& cell) {
  switch (cell.kind()) {
    case report::Kind::unsigned_integer:
      return static_cast<double>(cell.unsigned_value());
    case report::Kind::signed_integer:
      return static_cast<double>(cell.signed_value());
    case report::Kind::nanoseconds:
      return static_cast<double>(cell.time().count);
    case report::Kind::real:
      return cell.real_value();
    default:
      return std::nullopt;
  }
}

// A picture needs no further digits; null if there is no value.
json drawn_number(double value) {
  if (std::isnan(value)) return nullptr;
  const double rounded = std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr);
  if (rounded == std::floor(rounded) && std::abs(rounded) < 9e15) {
    return static_cast<std::int64_t>(rounded);
  }
  return rounded;
}

}  // namespace

void Overview::Extremes::take(const Extremes& other) {
  low = std::fmin(low, other.low);
  high = std::fmax(high, other.high);
}

void Overview::Group::count(std::size_t cause, std::uint64_t times) {
  if (counts.size() <= cause) counts.resize(cause + 1);
  counts[cause] += times;
}

Overview::Overview(std::span<const report::Column> columns) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const report::Column& column = columns[i];
    if (column.name == "time_ns") time_column_ = i;
    if (column.plot != 0) drawn_.emplace_back(i, column.name);
    if (column.role != report::Role::value) counted_.emplace_back(i, column);
  }
}

void Overview::add(std::span<const report::Cell> cells) {
  last_time_ = cells[time_column_].time().count;
  Group& group = group_for(last_time_);
  for (std::size_t k = 0; k < drawn_.size(); ++k) {
    if (const auto value = number_of(cells[drawn_[k].first])) {
      group.values[k].take({*value, *value});
    }
  }
  count_cells(group, cells);
  ++rows_;
}

Overview::Group& Overview::group_for(std::int64_t time) {
  if (groups_.empty() || in_last_ == each_) {
    if (groups_.size() == groups_max) join_groups();
    groups_.push_back({time, std::vector<Extremes>(drawn_.size()), {}});
    in_last_ = 0;
  }
  ++in_last_;
  return groups_.back();
}

void Overview::join_groups() {
  for (std::size_t i = 0; i < groups_.size(); i += 2) {
    Group& group = groups_[i / 2];
    if (i != 0) group = std::move(groups_[i]);
    const Group& next = groups_[i + 1];
    for (std::size_t k = 0; k < group.values.size(); ++k) group.values[k].take(next.values[k]);
    for (std::size_t k = 0; k < next.counts.size(); ++k) group.count(k, next.counts[k]);
  }
  groups_.resize(groups_.size() / 2);
  each_ *= 2;
}

void Overview::count_cells(Group& group, std::span<const report::Cell> cells) {
  for (const auto& [place, column] : counted_) {
    const report::Cell& cell = cells[place];
    const std::string& name = column.name;
    if (cell.kind() == report::Kind::flag) {
      const bool bad_at_1 = column.role == report::Role::warning_at_1;
      if (cell.unsigned_value() == (bad_at_1 ? 1U : 0U)) {
        group.count(cause_for(name, bad_at_1 ? name : name + "=0"));
      }
    } else if (cell.kind() == report::Kind::text) {
      std::string_view rest = cell.text();
      while (!rest.empty()) {
        const std::size_t end = std::min(rest.find(';'), rest.size());
        group.count(cause_for(name, rest.substr(0, end)));
        rest.remove_prefix(std::min(end + 1, rest.size()));
      }
    }
  }
}

// A linear search is enough for the few causes.
std::size_t Overview::cause_for(const std::string& column, std::string_view name) {
  const auto found = std::find_if(causes_.begin(), causes_.end(), [&](const Cause& cause) {
    return cause.name == name && cause.column == column;
  });
  if (found != causes_.end()) return static_cast<std::size_t>(found - causes_.begin());
  causes_.push_back({column, std::string(name)});
  return causes_.size() - 1;
}

json Overview::envelope() const {
  json times = json::array();
  const std::int64_t from = groups_.empty() ? 0 : groups_.front().time;
  for (const Group& group : groups_) times.push_back(group.time - from);
  json columns = json::object();
  for (std::size_t k = 0; k < drawn_.size(); ++k) {
    json low = json::array();
    json high = json::array();
    for (const Group& group : groups_) {
      low.push_back(drawn_number(group.values[k].low));
      high.push_back(drawn_number(group.values[k].high));
    }
    columns[drawn_[k].second] = {{"low", std::move(low)}, {"high", std::move(high)}};
  }
  return {{"from", std::to_string(from)},
          {"rows", each_},
          {"times", std::move(times)},
          {"columns", std::move(columns)}};
}

json Overview::causes() const {
  const std::int64_t from = groups_.empty() ? 0 : groups_.front().time;
  const double length = std::max(1.0, static_cast<double>(last_time_ - from));
  std::vector<std::vector<std::uint64_t>> over(causes_.size(), std::vector<std::uint64_t>(bins));
  for (const Group& group : groups_) {
    const double share = static_cast<double>(group.time - from) / length;
    const auto bin = std::min(bins - 1, static_cast<std::size_t>(share * bins));
    for (std::size_t k = 0; k < group.counts.size(); ++k) over[k][bin] += group.counts[k];
  }
  std::vector<json> causes;
  for (std::size_t k = 0; k < causes_.size(); ++k) {
    std::uint64_t count = 0;
    for (const std::uint64_t one : over[k]) count += one;
    causes.push_back({{"column", causes_[k].column},
                      {"name", causes_[k].name},
                      {"count", count},
                      {"over", over[k]}});
  }
  const auto place = [&](const json& cause) {
    const auto at = std::find_if(counted_.begin(), counted_.end(), [&](const auto& each) {
      return each.second.name == cause["column"].get<std::string>();
    });
    return at - counted_.begin();
  };
  std::stable_sort(causes.begin(), causes.end(), [&](const json& a, const json& b) {
    if (place(a) != place(b)) return place(a) < place(b);
    return a["count"].get<std::uint64_t>() > b["count"].get<std::uint64_t>();
  });
  return {{"rows", rows_}, {"causes", causes}};
}

}  // namespace biss::verbs
