#include "archive/entry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "report/text.hpp"

namespace biss::archive {

namespace {

using std::chrono::year_month_day;

bool is_digit(char letter) { return letter >= '0' && letter <= '9'; }

std::size_t digits_at(std::string_view text) {
  const auto end = std::find_if_not(text.begin(), text.end(), is_digit);
  return static_cast<std::size_t>(end - text.begin());
}

// \pre all are digits
unsigned number_of(std::string_view digits) { return *report::number_in<unsigned>(digits); }

std::optional<Day> day_of_parts(unsigned year, unsigned month, unsigned day) {
  const year_month_day date{std::chrono::year(static_cast<int>(year)), std::chrono::month(month),
                            std::chrono::day(day)};
  if (!date.ok()) return std::nullopt;
  return static_cast<Day>(std::chrono::sys_days(date).time_since_epoch().count());
}

// Digits in a path are not all dates.
std::optional<Day> likely_day(std::string_view year, std::string_view month, std::string_view day) {
  const unsigned number = number_of(year);
  if (number < 1990 || number > 2099) return std::nullopt;
  return day_of_parts(number, number_of(month), number_of(day));
}

// The text begins like `2024-03-17`, with any of these separators.
bool is_separated(std::string_view text, std::string_view separators) {
  return text.size() >= 10 && separators.find(text[4]) != std::string_view::npos &&
         text[7] == text[4] && digits_at(text) == 4 && digits_at(text.substr(5)) == 2 &&
         digits_at(text.substr(8)) == 2;
}

std::optional<Day> separated(std::string_view text) {
  if (!is_separated(text, "-_./")) return std::nullopt;
  return likely_day(text.substr(0, 4), text.substr(5, 2), text.substr(8, 2));
}

// `20240317` or `20240317093000`.
std::optional<Day> joined(std::string_view text) {
  const std::size_t digits = digits_at(text);
  if (digits != 8 && digits != 14) return std::nullopt;
  return likely_day(text.substr(0, 4), text.substr(4, 2), text.substr(6, 2));
}

}  // namespace

std::optional<Day> day_in(std::string_view path) {
  std::optional<Day> last;
  for (std::size_t at = 0; at < path.size(); ++at) {
    if (!is_digit(path[at]) || (at != 0 && is_digit(path[at - 1]))) continue;
    const std::string_view rest = path.substr(at);
    auto day = separated(rest);
    if (!day) day = joined(rest);
    if (day) last = day;
  }
  return last;
}

Day day_of(std::int64_t time) {
  constexpr std::int64_t day_ns = std::int64_t{86'400} * 1'000'000'000;
  return static_cast<Day>(time / day_ns - (time % day_ns < 0 ? 1 : 0));
}

std::string day_text(Day day) {
  const year_month_day date{std::chrono::sys_days(std::chrono::days(day))};
  return fmt::format("{:04}-{:02}-{:02}", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()));
}

std::optional<Day> day_from(std::string_view text) {
  if (text.size() != 10 || !is_separated(text, "-")) return std::nullopt;
  return day_of_parts(number_of(text.substr(0, 4)), number_of(text.substr(5, 2)),
                      number_of(text.substr(8, 2)));
}

}  // namespace biss::archive
