#include "live/link_health.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

namespace biss::live {
namespace {

constexpr std::size_t recent_max = 64;
constexpr std::size_t history_max = 200;
constexpr std::size_t changes_max = 100;
// An alarm ends after this many intervals without its reason.
constexpr std::uint32_t quiet_min = 16;

bool is_missing(CycleStatus status) {
  return status == CycleStatus::no_response || status == CycleStatus::not_ready ||
         status == CycleStatus::no_start;
}

double share_of(std::uint64_t count, std::uint64_t cycles) {
  return cycles == 0 ? 0 : static_cast<double>(count) / static_cast<double>(cycles);
}

// Whether `count` events are more than chance gives in one interval of 10^9 at most, if
// `expected` is their mean: Chernoff's bound of the Poisson distribution.
bool is_no_chance(double count, double expected) {
  constexpr double log_of_chance = -20.7;
  return count > expected && count - expected - count * std::log(count / expected) < log_of_chance;
}

std::string first_of(std::initializer_list<std::string> reasons) {
  for (const std::string& each : reasons) {
    if (!each.empty()) return each;
  }
  return "";
}

}  // namespace

void HealthPoint::add(const HealthPoint& other) {
  for (std::size_t k = 0; k < level_count; ++k) {
    const auto& more = other.levels[k];
    if (!more) continue;
    if (!levels[k]) {
      levels[k] = more;
    } else if (const auto all = static_cast<double>(good + other.good); all > 0) {
      *levels[k] += std::llround(static_cast<double>(*more - *levels[k]) *
                                 static_cast<double>(other.good) / all);
    }
  }
  cycles += other.cycles;
  good += other.good;
  for (std::size_t k = 0; k < event_count; ++k) events[k] += other.events[k];
}

void Baseline::add(const HealthPoint& point) {
  ++intervals;
  for (std::size_t k = 0; k < level_count; ++k) {
    if (!point.levels[k]) continue;
    const std::int64_t value = *point.levels[k];
    const auto [low, high] = ranges[k].value_or(std::array{value, value});
    ranges[k] = {std::min(low, value), std::max(high, value)};
  }
  for (std::size_t k = 0; k < event_count; ++k) {
    shares[k] = std::max(shares[k], share_of(point.events[k], point.cycles));
  }
}

void LinkHealth::add(const HealthSample& sample) {
  decode::Counts& counts = state_.counts;
  ++counts.cycles;
  ++counts.by_status[static_cast<std::size_t>(sample.status)];
  counts.errors += sample.error ? 1 : 0;
  counts.warnings += sample.warning ? 1 : 0;
  HealthPoint& point = now_.point;
  ++point.cycles;
  point.count(Event::error) += sample.error ? 1 : 0;
  point.count(Event::warning) += sample.warning ? 1 : 0;
  point.count(Event::noisy) += sample.noisy ? 1 : 0;
  if (is_missing(sample.status)) {
    ++missing_in_a_row_;
    return;
  }
  if (is_fault(sample.status)) ++point.count(Event::damaged);
  if (!is_good(sample.status)) return;
  ++point.good;
  if (missing_in_a_row_ != 0) {
    ++point.count(missing_in_a_row_ == 1 ? Event::damaged : Event::gap);
    missing_in_a_row_ = 0;
  }
  if (sample.period) state_.period = sample.period->count;
  const std::optional<std::int64_t> levels[] = {sample.delay, sample.ack, sample.margin};
  for (std::size_t k = 0; k < level_count; ++k) {
    if (levels[k]) now_.levels[k].add(*levels[k]);
  }
}

std::optional<HealthPoint> LinkHealth::end_interval(std::int64_t time, bool even_if_few) {
  changes_.clear();
  if (now_.point.cycles < cycles_min && !even_if_few) return std::nullopt;
  HealthPoint point = now_.point;
  point.time = time;
  for (std::size_t k = 0; k < level_count; ++k) {
    const decode::Distribution& values = now_.levels[k];
    if (values.count() == 0) continue;
    point.levels[k] =
        k == static_cast<std::size_t>(Level::margin) ? values.tenth() : values.median();
  }
  if (const auto delay = point.level(Level::delay); delay && setup_.unit == LinkUnit::clock) {
    now_.levels[0].for_each_bucket([&](std::int64_t begin, std::uint64_t count) {
      if (begin != *delay) point.count(Event::shifted) += count;
    });
  }
  now_ = {};
  take(point);
  return point;
}

void LinkHealth::take(const HealthPoint& point) {
  changes_.clear();
  keep(point);
  const bool is_judged = state_.baseline.intervals >= setup_.baseline;
  if (is_judged) ++state_.intervals;
  judge(point.time);
  if (is_judged || point.good == 0) return;
  state_.baseline.add(point);
  state_.reference.add(point);
}

void LinkHealth::keep(const HealthPoint& point) {
  if (state_.recent.size() == recent_max) {
    const bool is_quiet = std::all_of(state_.reasons.begin(), state_.reasons.end(),
                                      [](const std::string& reason) { return reason.empty(); });
    if (is_quiet && state_.intervals >= recent_max) state_.reference.add(state_.recent.front());
    state_.recent.erase(state_.recent.begin());
  }
  state_.recent.push_back(point);
  std::vector<HealthPoint>& history = state_.history;
  if (state_.last_joined != 0 && state_.last_joined < state_.joined) {
    history.back().add(point);
    ++state_.last_joined;
    return;
  }
  if (history.size() == history_max) {
    for (std::size_t k = 0; k < history_max / 2; ++k) {
      history[k] = history[2 * k];
      history[k].add(history[2 * k + 1]);
    }
    history.resize(history_max / 2);
    state_.joined *= 2;
  }
  history.push_back(point);
  state_.last_joined = 1;
}

void LinkHealth::judge(std::int64_t time) {
  for (std::size_t k = 0; k < alarm_count; ++k) {
    const auto alarm = static_cast<Alarm>(k);
    std::string& reason = state_.reasons[k];
    std::string now = reason_of(alarm);
    const bool was_on = !reason.empty();
    if (!now.empty()) {
      state_.quiet[k] = 0;
      reason = std::move(now);
      if (was_on) continue;
    } else if (!was_on || ++state_.quiet[k] < quiet_min) {
      continue;
    }
    changes_.push_back({time, alarm, !was_on, reason, state_.counts.faults()});
    if (was_on) reason.clear();
    if (state_.changes.size() == changes_max) state_.changes.erase(state_.changes.begin());
    state_.changes.push_back(changes_.back());
  }
}

std::string LinkHealth::reason_of(Alarm alarm) const {
  const HealthPoint& last = state_.recent.back();
  if (alarm == Alarm::silent) {
    if (last.good != 0) return "";
    return last.cycles == 0 ? "no cycle was read"
                            : fmt::format("no good frame in {} cycles", last.cycles);
  }
  if (state_.baseline.intervals < setup_.baseline) return "";
  const std::string other_delay = moved(Level::delay, 32);
  const std::string less_margin = moved(Level::margin);
  switch (alarm) {
    case Alarm::contact:
      return more_often(Event::gap, "answers to several requests in a row are missing");
    case Alarm::encoder:
      return first_of({more_often(Event::error, "nE is active"),
                       more_often(Event::warning, "nW is active"), moved(Level::ack)});
    case Alarm::noise:
      return first_of({more_often(Event::damaged, "frames are damaged"),
                       more_often(Event::noisy,
                                  "pulses, or changes of SLO close to a sampling point, are seen"),
                       other_delay.empty() ? less_margin : ""});
    case Alarm::cable:
      return other_delay.empty() || less_margin.empty() ? "" : less_margin + ", and " + other_delay;
    case Alarm::delay:
      return first_of(
          {moved(Level::delay, 8),
           more_often(Event::shifted, "the answer comes a clock earlier or later than usual")});
    case Alarm::silent:
      break;
  }
  return "";
}

// Empty unless the event is more frequent in the last interval, the last 16, or the last 64, than the
// baseline and the intervals without an alarm before allow.
std::string LinkHealth::more_often(Event event, std::string_view what) const {
  const auto index = static_cast<std::size_t>(event);
  const double largest_share = state_.baseline.shares[index];
  HealthPoint window;
  const std::size_t most = std::min<std::uint64_t>(state_.recent.size(), state_.intervals);
  for (std::size_t k = 1; k <= most; ++k) {
    window.add(state_.recent[state_.recent.size() - k]);
    if (k != 1 && k != 16 && k != most) continue;
    const std::uint64_t count = window.events[index];
    if (count < 3 || share_of(count, window.cycles) <= 2 * largest_share) continue;
    const std::uint64_t before = state_.reference.events[index];
    const std::uint64_t cycles = state_.reference.cycles;
    // The highest rate at which what was before is not unlikely. Chance makes no gaps.
    const auto likely = static_cast<double>(before + 1);
    const double rate = (likely + 3 * std::sqrt(likely)) / static_cast<double>(cycles);
    const bool is_new_gap = event == Event::gap && before == 0;
    if (is_new_gap ||
        is_no_chance(static_cast<double>(count), rate * static_cast<double>(window.cycles))) {
      return fmt::format("{} {} times in {} cycles; {} times in {} before", what, count,
                         window.cycles, before, cycles);
    }
  }
  return "";
}

// Empty unless the last two intervals are that far from the baseline, on the same side; a margin:
// below it.
// \param part of a period: the least move of a line delay
std::string LinkHealth::moved(Level level, std::int64_t part) const {
  const auto& range = state_.baseline.ranges[static_cast<std::size_t>(level)];
  const HealthPoint& now = state_.recent.back();
  // A few frames of many are a wrong sample of the line.
  if (!range || state_.intervals < 2 || state_.recent.size() < 2 || 2 * now.good < now.cycles)
    return "";
  const std::int64_t low = (*range)[0];
  const std::int64_t high = (*range)[1];
  const bool is_clock = setup_.unit == LinkUnit::clock;
  const std::int64_t least = std::max(
      {level == Level::margin ? 50
       : level == Level::ack  ? std::max<std::int64_t>(high / 4, is_clock ? 2 : 1'000'000)
                              : std::max<std::int64_t>(is_clock ? 1 : state_.period / part, 1),
       3 * (high - low)});
  const auto side_of = [&](const HealthPoint& point) {
    const auto value = point.level(level);
    if (value && *value - high >= least && level != Level::margin) return 1;
    return value && low - *value >= least ? -1 : 0;
  };
  const int side = side_of(now);
  if (side == 0 || side_of(state_.recent[state_.recent.size() - 2]) != side) return "";
  return fmt::format("{} {}; {} to {} in the baseline", name_of(level),
                     level_text(level, *now.level(level)), level_text(level, low),
                     level_text(level, high));
}

std::string LinkHealth::level_text(Level level, std::int64_t value) const {
  if (level == Level::margin) {
    return fmt::format("{:.1f} % of a period", static_cast<double>(value) / 10);
  }
  if (setup_.unit == LinkUnit::clock)
    return fmt::format("{} clock{}", value, value == 1 ? "" : "s");
  return fmt::format("{:.1f} ns", static_cast<double>(value) / 1000);
}

std::string LinkHealth::trend_text(Level level) const {
  constexpr std::size_t least_points = 20;
  std::vector<std::pair<double, double>> points;
  for (const HealthPoint& point : state_.history) {
    if (const auto value = point.level(level)) {
      points.emplace_back(static_cast<double>(point.time - state_.history.front().time) / 86'400,
                          static_cast<double>(*value));
    }
  }
  // A change within minutes is not a trend of days.
  if (points.size() < least_points || points.back().first - points.front().first < 0.25) return "";
  double mean_x = 0;
  double mean_y = 0;
  const auto n = static_cast<double>(points.size());
  for (const auto& [x, y] : points) {
    mean_x += x / n;
    mean_y += y / n;
  }
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (const auto& [x, y] : points) {
    xx += (x - mean_x) * (x - mean_x);
    xy += (x - mean_x) * (y - mean_y);
    yy += (y - mean_y) * (y - mean_y);
  }
  if (xx <= 0) return "";
  const double slope = xy / xx;
  const double doubt = std::sqrt(std::max(yy - slope * xy, 0.0) / (n - 2) / xx);
  if (std::abs(slope) <= 5 * doubt) return "";
  const auto days = [&](double per_day) {
    return level_text(level, std::llround(std::abs(per_day)));
  };
  return fmt::format("{} {} a day, ± {}", slope < 0 ? "falls by" : "grows by", days(slope),
                     days(2 * doubt));
}

}  // namespace biss::live
