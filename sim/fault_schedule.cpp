#include "sim/fault_schedule.hpp"

#include <algorithm>
#include <utility>

#include "biss/timing/step.hpp"

namespace biss::sim {

namespace {

// How a kind lies in time.
enum class Extent {
  whole,   // this cycle and no other
  cycles,  // whole cycles
  span,    // from a point in the frame to one in a later cycle
  pulse,   // short, within the frame
  idle_pulse,
  clock,   // from just before a falling edge of MA to just behind the rising one
  bounce,  // just behind an edge of MA
};

Extent extent_of(FaultKind kind) {
  switch (kind) {
    case FaultKind::glitch_ma:
    case FaultKind::glitch_slo:
    case FaultKind::extra_clock:
      return Extent::pulse;
    case FaultKind::glitch_ma_idle:
    case FaultKind::glitch_slo_idle:
      return Extent::idle_pulse;
    case FaultKind::lost_clock:
      return Extent::clock;
    case FaultKind::double_clock:
      return Extent::bounce;
    case FaultKind::ma_low:
    case FaultKind::ma_high:
    case FaultKind::slo_low:
    case FaultKind::slo_high:
    case FaultKind::cut:
    case FaultKind::delay_step:
    case FaultKind::brown_out:
      return Extent::span;
    case FaultKind::swap_ma:
    case FaultKind::swap_slo:
    case FaultKind::exchange:
    case FaultKind::frozen:
      return Extent::cycles;
    case FaultKind::flip:
    case FaultKind::burst:
    case FaultKind::late_start:
    case FaultKind::no_answer:
    case FaultKind::nE:
    case FaultKind::nW:
      return Extent::whole;
  }
  return Extent::whole;
}

Picoseconds share_of(Picoseconds time, Random& random) {
  return time * static_cast<std::int64_t>(random.below(1U << 20U)) / (1 << 20);
}

}  // namespace

FaultSchedule::FaultSchedule(std::vector<FaultRule> rules, std::uint64_t seed)
    : rules_(std::move(rules)), seed_(scrambled(seed ^ 0x5DEECE66DU)) {}

Picoseconds FaultSchedule::next() const { return actions_.empty() ? never : actions_.back().time; }

FaultAction FaultSchedule::take() {
  const FaultAction action = actions_.back();
  actions_.pop_back();
  lasting_ = action.begins ? lasting_ | set_of(action.kind) : lasting_ & ~set_of(action.kind);
  return action;
}

void FaultSchedule::begin_cycle(std::uint64_t number, Picoseconds begin) {
  std::erase_if(endings_, [&](const Ending& ending) {
    if (ending.cycle > number) return false;
    if (ending.after.count == 0) lasting_ &= ~set_of(ending.kind);
    add({begin + ending.after, ending.kind, false});
    return true;
  });
  for (const FaultRule& rule : rules_) {
    const std::uint64_t kind = static_cast<std::uint64_t>(rule.kind) + 1U;
    Random random(seed_ ^ scrambled(number * fault_kind_count + kind));
    const bool drawn = (random.next() >> 32U) < rule.share;
    const bool hit = rule.cycle ? *rule.cycle == number : drawn;
    if (!hit || (lasting_ & set_of(rule.kind)) != 0) continue;
    lasting_ |= set_of(rule.kind);
    details_[static_cast<std::size_t>(rule.kind)] = random.next();
    strike(rule.kind, random, number, begin);
  }
}

void FaultSchedule::strike(FaultKind kind, Random& random, std::uint64_t number,
                           Picoseconds begin) {
  const Extent extent = extent_of(kind);
  Picoseconds at = begin;
  if (extent == Extent::whole || extent == Extent::cycles) {
    const std::uint64_t cycles = extent == Extent::whole ? 1 : 1 + random.below(3);
    add({at, kind, true});
    endings_.push_back({kind, number + cycles, {}});
    return;
  }
  if (extent == Extent::span) {
    add({at + place_in_frame(random), kind, true});
    endings_.push_back({kind, number + 1 + random.below(3), share_of(nominal_.interval, random)});
    return;
  }
  const Picoseconds tick = std::max(nominal_.period / 50, picoseconds(1));
  const auto clock = static_cast<std::int64_t>(random.below(nominal_.clocks));
  Picoseconds width = tick + share_of(nominal_.period / 10, random);
  if (extent == Extent::clock) {
    at += clock * nominal_.period - tick;
    width = nominal_.low_time + 2 * tick;
  } else if (extent == Extent::bounce) {
    // Of a rising or a falling edge.
    at += clock * nominal_.period + tick;
    if (random.below(2) != 0) at += nominal_.low_time;
  } else if (extent == Extent::pulse) {
    at += place_in_frame(random);
    if (kind == FaultKind::glitch_slo) at += nominal_.line_delay;
  } else {
    at += place_behind_frame(random);
  }
  at = std::max(at, begin);
  add({at, kind, true});
  add({at + width, kind, false});
}

void FaultSchedule::add(FaultAction action) {
  const auto place =
      std::lower_bound(actions_.begin(), actions_.end(), action,
                       [](const FaultAction& a, const FaultAction& b) { return a.time > b.time; });
  actions_.insert(place, action);
}

Picoseconds FaultSchedule::place_in_frame(Random& random) const {
  return share_of(nominal_.clocks * nominal_.period, random);
}

Picoseconds FaultSchedule::place_behind_frame(Random& random) const {
  const Picoseconds frame = nominal_.clocks * nominal_.period;
  return frame + share_of(std::max(nominal_.interval - frame, nominal_.period), random);
}

}  // namespace biss::sim
