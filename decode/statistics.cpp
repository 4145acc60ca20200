#include "decode/statistics.hpp"

#include <algorithm>

#include "decode/times.hpp"

namespace biss::decode {

void Statistics::add(const Cycle& cycle, LimitSet exceeded) {
  ++cycles_;
  if (exceeded != 0) {
    ++limited_;
    for (std::size_t i = 0; i < limit_count; ++i) {
      if ((exceeded & set_of(static_cast<Limit>(i))) != 0) ++by_limit_[i];
    }
  }
  ++by_status_[static_cast<std::size_t>(cycle.status)];
  if (cycle.frame) {
    const auto channels = cycle.frame->channels();
    if (std::any_of(channels.begin(), channels.end(), [](auto& c) { return !c.nE; })) ++errors_;
    if (std::any_of(channels.begin(), channels.end(), [](auto& c) { return !c.nW; })) ++warnings_;
  }
  if (cycle.marginal) ++margin_judged_;
  if (cycle.marginal.value_or(false)) ++marginal_;
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
