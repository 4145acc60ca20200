#include "decode/statistics.hpp"

#include <algorithm>

#include "decode/times.hpp"

namespace biss::decode {

void Counts::add(const Counts& other) {
  cycles += other.cycles;
  for (std::size_t i = 0; i < by_status.size(); ++i) by_status[i] += other.by_status[i];
  errors += other.errors;
  warnings += other.warnings;
  for (std::size_t i = 0; i < by_limit.size(); ++i) by_limit[i] += other.by_limit[i];
  limited += other.limited;
  marginal += other.marginal;
  margin_judged += other.margin_judged;
}

std::uint64_t Counts::faults() const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < by_status.size(); ++i) {
    if (is_fault(static_cast<CycleStatus>(i))) sum += by_status[i];
  }
  return sum;
}

CycleStatus Counts::foremost_fault() const {
  auto foremost = CycleStatus::ok;
  std::uint64_t most = 0;
  for (std::size_t i = 0; i < by_status.size(); ++i) {
    const auto status = static_cast<CycleStatus>(i);
    if (!is_fault(status) || by_status[i] <= most) continue;
    foremost = status;
    most = by_status[i];
  }
  return foremost;
}

void Statistics::add(const Cycle& cycle, LimitSet exceeded) {
  ++counts_.cycles;
  if (exceeded != 0) {
    ++counts_.limited;
    for (std::size_t i = 0; i < limit_count; ++i) {
      if ((exceeded & set_of(static_cast<Limit>(i))) != 0) ++counts_.by_limit[i];
    }
  }
  ++counts_.by_status[static_cast<std::size_t>(cycle.status)];
  if (cycle.frame) {
    const auto channels = cycle.frame->channels();
    if (std::any_of(channels.begin(), channels.end(), [](auto& c) { return !c.nE; }))
      ++counts_.errors;
    if (std::any_of(channels.begin(), channels.end(), [](auto& c) { return !c.nW; }))
      ++counts_.warnings;
  }
  if (cycle.marginal) ++counts_.margin_judged;
  if (cycle.marginal.value_or(false)) ++counts_.marginal;
  // A pulse or a piece of a cycle is not a request of the master.
  const bool whole = cycle.status != CycleStatus::ma_glitch && !is_cut(cycle.status);
  if (!whole) {
    if (cycle.status != CycleStatus::ma_glitch) last_time_.reset();
    return;
  }
  if (last_time_) interval_.add(elapsed(*last_time_, cycle.time).count);
  last_time_ = cycle.time;
  if (cycle.period) period_.add(cycle.period->count);
  if (cycle.line_delay) line_delay_.add(cycle.line_delay->count);
  if (cycle.early) early_.add(cycle.early->count);
  if (cycle.ack) ack_.add(cycle.ack->count);
  if (cycle.ack && cycle.period) {
    ack_clocks_.add(periods_in(*cycle.ack, *cycle.period));
  }
  if (cycle.duty_per_mille) duty_.add(*cycle.duty_per_mille);
}

}  // namespace biss::decode
