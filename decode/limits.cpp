#include "decode/limits.hpp"

#include <algorithm>

#include "decode/times.hpp"

namespace biss::decode {

namespace {

// The line delay may vary by a period divided by this (D2, characteristics, row 8).
constexpr std::int64_t delay_divisor = 4;

// The rules of the limits before `release`, which has two.
constexpr std::array limit_rules{Rule::clock_max, Rule::clock_min, Rule::clock_change,
                                 Rule::cycle_min};
static_assert(limit_rules.size() == static_cast<std::size_t>(Limit::release));

Limit limit_of(Rule rule) {
  const auto* const found = std::find(limit_rules.begin(), limit_rules.end(), rule);
  return static_cast<Limit>(found - limit_rules.begin());
}

}  // namespace

std::string_view name_of(Limit limit) {
  if (limit == Limit::release) return "release";
  return text_of(limit_rules[static_cast<std::size_t>(limit)]).name;
}

std::string text_of(LimitSet limits) {
  std::string text;
  for (std::size_t i = 0; i < limit_count; ++i) {
    const auto limit = static_cast<Limit>(i);
    if ((limits & set_of(limit)) == 0) continue;
    if (!text.empty()) text += ';';
    text += name_of(limit);
  }
  return text;
}

ReleaseBounds release_bounds(const DeviceTiming& timing, const Cycle& cycle) {
  const Picoseconds period = *cycle.period;
  // The encoder measures from the first falling to the second rising edge of MA: D2, row 6.
  const std::int64_t low_per_mille = 1000 - std::int64_t{cycle.duty_per_mille.value_or(500)};
  const Picoseconds adaptive = period + period * low_per_mille / 1000;
  const Picoseconds time = timing.timeout.time;
  if (timing.timeout.rule == TimeoutRule::adaptive) return {adaptive, adaptive + time};
  if (timing.timeout.rule == TimeoutRule::cycle) {
    const Picoseconds rest = time - cycle.clocked;
    return {std::max(rest, std::int64_t{biss_release_half_periods_min} * period / 2),
            std::max(rest, release_time(timing.timeout, period))};
  }
  if (timing.timeout == Timeout{}) {
    return {std::min(adaptive, biss_static_timeout_min),
            std::max(adaptive, biss_static_timeout_max)};
  }
  return {std::min(time, biss_static_timeout_min), time};
}

Picoseconds release_doubt(const Cycle& cycle, Picoseconds bound) {
  return *cycle.period / delay_divisor + cycle.uncertainty +
         (bound + cycle.clocked) / oscillator_divisor;
}

bool LimitWatch::knows(Limit limit) const {
  if (limit == Limit::clock_change) return timing_.clock_constant;
  if (limit == Limit::cycle_min) return timing_.cycle_min.count != 0;
  return limit != Limit::release || timing_.timeout != Timeout{};
}

std::span<const Comparison> LimitWatch::compare(const Cycle& cycle) {
  count_ = 0;
  if (cycle.period && has_whole_clock(cycle.status)) compare_clock(cycle);
  compare_interval(cycle);
  const bool complete = is_good(cycle.status) || cycle.status == CycleStatus::ack_range;
  if (complete && knows(Limit::release)) compare_release(cycle);
  return std::span(comparisons_).first(count_);
}

LimitSet LimitWatch::judge(const Cycle& cycle) {
  LimitSet exceeded = 0;
  for (const Comparison& made : compare(cycle)) {
    if (made.exceeded()) exceeded = static_cast<LimitSet>(exceeded | set_of(limit_of(made.rule)));
  }
  return exceeded;
}

void LimitWatch::compare_clock(const Cycle& cycle) {
  const Picoseconds period = *cycle.period;
  // The period is the mean of all of them.
  const std::int64_t periods = std::max<std::int64_t>(1, std::int64_t{cycle.rising_edges} - 1);
  const Picoseconds doubt =
      period / oscillator_divisor + std::max(cycle.uncertainty, resolution_) / periods;
  add({Rule::clock_max, period, period_of(timing_.clock_max), false, doubt});
  if (timing_.clock_min.count != 0) {
    add({Rule::clock_min, period, period_of(timing_.clock_min), true, doubt});
  }
  if (timing_.clock_constant && cycle.clock_change) {
    add({Rule::clock_change, cycle.clock_change->most, period / ClockChange::divisor, true,
         cycle.clock_change->doubt});
  }
}

void LimitWatch::compare_interval(const Cycle& cycle) {
  if (cycle.status == CycleStatus::ma_glitch) return;
  const auto before = last_time_;
  last_time_.reset();
  if (is_cut(cycle.status) || cycle.status == CycleStatus::unknown_level) {
    return;
  }
  last_time_ = cycle.time;
  const Picoseconds uncertainty = std::max({cycle.uncertainty, last_uncertainty_, resolution_});
  last_uncertainty_ = cycle.uncertainty;
  if (!before || !knows(Limit::cycle_min)) return;
  add({Rule::cycle_min, elapsed(*before, cycle.time), timing_.cycle_min, false,
       timing_.cycle_min / oscillator_divisor + uncertainty});
}

void LimitWatch::compare_release(const Cycle& cycle) {
  if (!cycle.period || !cycle.release || !cycle.line_delay) return;
  const ReleaseBounds bounds = release_bounds(timing_, cycle);
  const Picoseconds seen = *cycle.release - *cycle.line_delay;
  const bool by_cycle = timing_.timeout.rule == TimeoutRule::cycle;
  // When SLO rises after a longer frame is not known.
  if (by_cycle && bounds.least != bounds.most) return;
  // The uncertainty of two times, with two edges each.
  const Picoseconds coarse = 2 * resolution_;
  add({Rule::timeout_shortest, seen, bounds.least, false,
       release_doubt(cycle, bounds.least) + coarse});
  // For the other rules, the time is one that is typical, or excludes register accesses.
  if (by_cycle) {
    add({Rule::timeout_longest, seen, bounds.most, true,
         release_doubt(cycle, bounds.most) + coarse});
  }
}

}  // namespace biss::decode
