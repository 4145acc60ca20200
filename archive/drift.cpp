#include "archive/summary.hpp"

#include <algorithm>
#include <map>

namespace biss::archive {

namespace {

using Wide = __int128;

constexpr std::int64_t largest_value = std::int64_t{1} << 53U;
// With this many values no sum below overflows.
constexpr std::size_t most_values = 10'000'000;
constexpr std::int64_t days_per_year = 365;
constexpr std::int64_t million = 1'000'000;

// Rounded half away from zero. \pre divisor > 0
std::int64_t rounded_ratio(Wide dividend, Wide divisor) {
  const Wide half = divisor / 2;
  return static_cast<std::int64_t>((dividend < 0 ? dividend - half : dividend + half) / divisor);
}

}  // namespace

std::optional<std::int64_t> change_per_year(std::span<const DatedValue> values) {
  if (values.empty() || values.size() > most_values) return std::nullopt;
  const Day first = values.front().day;
  const Wide count = static_cast<Wide>(values.size());
  Wide days = 0;
  Wide sum = 0;
  Wide squares = 0;
  Wide products = 0;
  for (const DatedValue& each : values) {
    const Wide day = Wide{each.day} - first;
    const Wide value = std::min(each.value, largest_value);
    days += day;
    sum += value;
    squares += day * day;
    products += day * value;
  }
  const Wide divisor = count * squares - days * days;
  if (divisor == 0) return std::nullopt;
  return rounded_ratio((count * products - days * sum) * days_per_year, divisor);
}

std::vector<DatedValue> medians_of(std::span<const PlacedLink> captures, Quantity quantity) {
  std::vector<DatedValue> values;
  for (const PlacedLink& each : captures) {
    const auto& range = each.link->ranges[static_cast<std::size_t>(quantity)];
    if (range) values.push_back({*each.file->day, range->median});
  }
  return values;
}

std::vector<DatedValue> fault_rates_of(std::span<const PlacedLink> captures) {
  std::vector<DatedValue> values;
  for (const PlacedLink& each : captures) {
    const Counts& counts = each.link->counts;
    if (counts.cycles == 0) continue;
    values.push_back(
        {*each.file->day, rounded_ratio(Wide{counts.faults()} * million, Wide{counts.cycles})});
  }
  return values;
}

std::vector<DayFigures> days_of(std::span<const PlacedLink> captures) {
  std::map<Day, std::vector<PlacedLink>> by_day;
  for (const PlacedLink& each : captures) by_day[*each.file->day].push_back(each);
  std::vector<DayFigures> days;
  for (const auto& [day, of_day] : by_day) {
    DayFigures& figures = days.emplace_back();
    figures.day = day;
    figures.captures = of_day.size();
    for (const PlacedLink& each : of_day) figures.counts.add(each.link->counts);
    for (std::size_t i = 0; i < quantity_count; ++i) {
      auto medians = medians_of(of_day, static_cast<Quantity>(i));
      if (medians.empty()) continue;
      const auto middle = medians.begin() + static_cast<std::ptrdiff_t>((medians.size() - 1) / 2);
      std::nth_element(medians.begin(), middle, medians.end(),
                       [](const DatedValue& a, const DatedValue& b) { return a.value < b.value; });
      figures.medians[i] = middle->value;
    }
  }
  return days;
}

}  // namespace biss::archive
