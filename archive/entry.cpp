#include "archive/entry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <compare>
#include <limits>

#include "report/text.hpp"

namespace biss::archive {

namespace {

// A share of cycles; 0 of 0 is 0.
struct Share {
  std::uint64_t part = 0;
  std::uint64_t whole = 0;
};

std::strong_ordering compare(const Share& a, const Share& b) {
  if (a.part == 0 || b.part == 0) return (a.part != 0) <=> (b.part != 0);
  using Product = unsigned __int128;
  return Product{a.part} * b.whole <=> Product{b.part} * a.whole;
}

// The shares of the cycles of a link that make it bad, the worst first. The last one is not a
// finding: without a frame format the checksums cannot be judged.
constexpr std::size_t share_count = 6;
using Shares = std::array<Share, share_count>;

Shares shares_of(const Counts& counts) {
  return {{{counts.faults(), counts.cycles},
           {counts.errors, counts.cycles},
           {counts.limited, counts.cycles},
           {counts.marginal, counts.margin_judged},
           {counts.warnings, counts.cycles},
           {counts.count(CycleStatus::unchecked), counts.cycles}}};
}

bool is_damaged(const FileEntry& entry) { return !entry.cause.empty() && !is_foreign(entry.cause); }

// The highest share of any link.
Shares worst_shares(const FileEntry& entry) {
  Shares worst{};
  for (const LinkEntry& link : entry.links) {
    const auto shares = shares_of(link.counts);
    for (std::size_t i = 0; i < worst.size(); ++i) {
      if (compare(shares[i], worst[i]) > 0) worst[i] = shares[i];
    }
  }
  return worst;
}

// 0 comes first.
int rank_of(const FileEntry& entry) {
  if (entry.links.empty()) return entry.has_finding() ? 1 : 4;
  if (entry.has_finding()) return 0;
  return worst_shares(entry).back().part != 0 ? 2 : 3;
}

using std::chrono::year_month_day;

// Nothing unless these are the numbers of a day.
std::optional<Day> day_of_parts(std::string_view year, std::string_view month,
                                std::string_view day) {
  const auto y = report::number_in<unsigned>(year);
  const auto m = report::number_in<unsigned>(month);
  const auto d = report::number_in<unsigned>(day);
  if (!y || !m || !d) return std::nullopt;
  const year_month_day date{std::chrono::year(static_cast<int>(*y)), std::chrono::month(*m),
                            std::chrono::day(*d)};
  if (!date.ok()) return std::nullopt;
  return static_cast<Day>(std::chrono::sys_days(date).time_since_epoch().count());
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// The day of `2024-03-17`, `20240317` or `20240317093000` at the front, without a further digit.
// Not all digits in a path are dates, so the years are limited.
std::optional<Day> front_day(std::string_view text) {
  if (text < "1990" || text >= "21") return std::nullopt;
  const auto digits =
      static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), is_digit) - text.begin());
  if (digits == 8 || digits == 14) {
    return day_of_parts(text.substr(0, 4), text.substr(4, 2), text.substr(6, 2));
  }
  constexpr std::string_view separators = "-_./";
  if (digits != 4 || text.size() < 10 || separators.find(text[4]) == separators.npos ||
      text[7] != text[4] || (text.size() > 10 && is_digit(text[10]))) {
    return std::nullopt;
  }
  return day_of_parts(text.substr(0, 4), text.substr(5, 2), text.substr(8, 2));
}

}  // namespace

bool is_foreign(std::string_view cause) {
  constexpr std::array<std::string_view, 7> foreign{
      "unknown_format", "layout_missing", "no_lines", "other_protocol",
      "no_such_line",   "not_a_file",     "link"};
  return std::find(foreign.begin(), foreign.end(), cause) != foreign.end();
}

bool FileEntry::has_finding() const {
  if (is_damaged(*this)) return true;
  return std::any_of(links.begin(), links.end(), [](const LinkEntry& link) {
    const auto shares = shares_of(link.counts);
    return std::any_of(shares.begin(), std::prev(shares.end()),
                       [](const Share& share) { return share.part != 0; });
  });
}

bool is_worse(const FileEntry& a, const FileEntry& b) {
  if (rank_of(a) != rank_of(b)) return rank_of(a) < rank_of(b);
  const auto of_a = worst_shares(a);
  const auto of_b = worst_shares(b);
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    const auto order = compare(of_a[i], of_b[i]);
    if (order != 0) return order > 0;
  }
  if (is_damaged(a) != is_damaged(b)) return is_damaged(a);
  return a.path < b.path;
}

std::string utf8_text(std::string_view text) {
  std::string escaped;
  bool valid = text.find("\\x") == std::string_view::npos;
  for (std::string_view rest = text; !rest.empty();) {
    const report::CodePoint point = report::front_code_point(rest);
    valid = valid && point.valid;
    if (point.valid && rest.front() != '\\') {
      escaped.append(rest.substr(0, point.bytes));
    } else {
      escaped += fmt::format("\\x{:02X}", static_cast<unsigned char>(rest.front()));
    }
    rest.remove_prefix(point.bytes);
  }
  return valid ? std::string(text) : escaped;
}

// ---- Days

std::optional<Day> day_in(std::string_view path) {
  std::optional<Day> last;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i != 0 && is_digit(path[i - 1])) continue;
    if (const auto day = front_day(path.substr(i))) last = day;
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
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return std::nullopt;
  return day_of_parts(text.substr(0, 4), text.substr(5, 2), text.substr(8));
}

// ---- Histograms

using decode::Distribution;

Histogram::Histogram(const Distribution& values) : count_(values.count()) {
  if (count_ == 0) return;
  min_ = values.min();
  max_ = values.max();
  values.for_each_bucket(
      [this](std::int64_t begin, std::uint64_t count) { buckets_[begin] += count; });
}

void Histogram::add(const Histogram& other) {
  if (other.count_ == 0) return;
  min_ = count_ == 0 ? other.min_ : std::min(min_, other.min_);
  max_ = std::max(max_, other.max_);
  count_ += other.count_;
  for (const auto& [begin, count] : other.buckets_) buckets_[begin] += count;
}

std::int64_t Histogram::median() const {
  const std::uint64_t rank = (count_ - 1) / 2;
  std::uint64_t below = 0;
  auto at = buckets_.begin();
  while (below + at->second <= rank) below += (at++)->second;
  return std::clamp(Distribution::bucket_middle(at->first), min_, max_);
}

bool Histogram::assign(const std::vector<Bucket>& buckets, std::int64_t min, std::int64_t max) {
  std::uint64_t count = 0;
  std::int64_t before = -1;
  for (const auto& [begin, values] : buckets) {
    if (begin <= before || Distribution::bucket_begin(begin) != begin) return false;
    if (values == 0 || values > std::numeric_limits<std::uint64_t>::max() - count) return false;
    before = begin;
    count += values;
  }
  const bool fits = buckets.empty()
                        ? min == 0 && max == 0
                        : min >= 0 && min <= max &&
                              Distribution::bucket_begin(min) == buckets.front().first &&
                              Distribution::bucket_begin(max) == buckets.back().first;
  if (!fits) return false;
  buckets_ = {buckets.begin(), buckets.end()};
  count_ = count;
  min_ = min;
  max_ = max;
  return true;
}

}  // namespace biss::archive
