#include "sim/fault_schedule.hpp"

#include <algorithm>
#include <utility>

#include "biss/timing/step.hpp"

namespace biss::sim {

namespace {

// The seed of the draws for a kind in a cycle. Wrong frames, which were added later, count down from
// the other end, so that the seeds of the line faults did not change.
std::uint64_t draw_of(FaultKind kind, std::uint64_t number) {
  const auto index = static_cast<std::uint64_t>(kind);
  if (index < line_fault_kind_count) return scrambled(number * line_fault_kind_count + index + 1U);
  return scrambled(~(number * line_fault_kind_count + index - line_fault_kind_count));
}

Picoseconds share_of(Picoseconds time, Random& random) {
  return part_of(time, random.below(time_parts));
}

// These change the bits that the master receives on SLO, so a bit can be their place.
bool affects_slo(FaultKind kind) {
  return kind == FaultKind::glitch_slo || kind == FaultKind::slo_low ||
         kind == FaultKind::slo_high || kind == FaultKind::cut;
}

// A pause has a clock after it.
std::uint32_t last_clock_of(FaultKind kind, const NominalCycle& nominal) {
  return nominal.clocks - (kind == FaultKind::ma_pause && nominal.clocks > 1 ? 2U : 1U);
}

// Bits of the payload; a burst begins before the last one.
FaultPlaces bits_of(FaultKind kind, unsigned payload_bits) {
  const bool pattern = kind == FaultKind::flip || kind == FaultKind::burst;
  const unsigned last_bits = kind == FaultKind::burst ? 2 : 1;
  if ((!pattern && !affects_slo(kind)) || payload_bits < last_bits) return {};
  return {0, payload_bits - last_bits, pattern};
}

}  // namespace

FaultPlaces places_of(FaultKind kind, PlaceUnit unit, const NominalCycle& nominal) {
  if (unit == PlaceUnit::bit) return bits_of(kind, nominal.payload_bits);
  const std::uint64_t clocks = nominal.clocks;
  switch (entry_of(kind).extent) {
    case FaultExtent::span:
    case FaultExtent::pulse:
      return {0, clocks - 1U, false};
    case FaultExtent::clock:
    case FaultExtent::bounce:
      return {0, last_clock_of(kind, nominal), true};
    case FaultExtent::idle_pulse: {
      const std::int64_t periods = nominal.interval.count / nominal.period.count;
      return {clocks, std::max(static_cast<std::uint64_t>(periods), clocks + 1U) - 1U, false};
    }
    default:
      return {};
  }
}

FaultSchedule::FaultSchedule(std::vector<FaultRule> rules, std::uint64_t seed)
    : rules_(std::move(rules)), seed_(scrambled(seed ^ 0x5DEECE66DU)) {
  std::stable_partition(rules_.begin(), rules_.end(),
                        [](const FaultRule& rule) { return rule.cycle.has_value(); });
}

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
    Random random(seed_ ^ draw_of(rule.kind, number));
    const bool drawn = (random.next() >> 32U) < rule.share;
    const bool hit = rule.cycle ? *rule.cycle == number : drawn;
    if (!hit || (lasting_ & set_of(rule.kind)) != 0) continue;
    lasting_ |= set_of(rule.kind);
    details_[static_cast<std::size_t>(rule.kind)] = random.next();
    inject(rule, random, number, begin);
  }
}

// A given place does not change the other draws.
void FaultSchedule::inject(const FaultRule& rule, Random& random, std::uint64_t number,
                           Picoseconds begin) {
  const FaultKind kind = rule.kind;
  const FaultExtent extent = entry_of(kind).extent;
  std::optional<FaultPlace>& place = places_[static_cast<std::size_t>(kind)] = rule.place;
  Picoseconds at = begin;
  if (!has_place(kind) || extent == FaultExtent::bit || extent == FaultExtent::bits) {
    const std::uint64_t cycles = extent == FaultExtent::cycles ? 1 + random.below(3) : 1;
    add({at, kind, true});
    endings_.push_back({kind, number + cycles, {}});
    return;
  }
  if (extent == FaultExtent::span) {
    const Picoseconds drawn = place_in_frame(random);
    add({at + (place ? time_of(*place) : drawn), kind, true});
    endings_.push_back({kind, number + 1 + random.below(3), share_of(nominal_.interval, random)});
    return;
  }
  const Picoseconds tick = std::max(nominal_.period / 50, picoseconds(1));
  const std::uint64_t drawn_clock = random.below(last_clock_of(kind, nominal_) + 1U);
  Picoseconds width = tick + share_of(nominal_.period / 10, random);
  if (extent == FaultExtent::clock || extent == FaultExtent::bounce) {
    if (!place) place = {PlaceUnit::clock, drawn_clock * 1000U};
    at += time_of(*place);
  }
  if (extent == FaultExtent::clock) {
    at -= tick;
    width = nominal_.low_time + 2 * tick;
  } else if (extent == FaultExtent::bounce) {
    // After a rising or a falling edge.
    at += tick;
    if (random.below(2) != 0) at += nominal_.low_time;
  } else if (place) {
    at += time_of(*place);
  } else if (extent == FaultExtent::pulse) {
    at += place_in_frame(random);
    if (kind == FaultKind::glitch_slo) at += nominal_.line_delay;
  } else {
    at += place_after_frame(random);
  }
  at = std::max(at, begin);
  add({at, kind, true});
  add({at + width, kind, false});
}

// Since the beginning of the cycle.
Picoseconds FaultSchedule::time_of(FaultPlace place) const {
  const Picoseconds time = nominal_.period * static_cast<std::int64_t>(place.thousandths) / 1000;
  if (place.unit == PlaceUnit::clock) return time;
  return nominal_.data_clock * nominal_.period + nominal_.low_time + nominal_.line_delay + time;
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

Picoseconds FaultSchedule::place_after_frame(Random& random) const {
  const Picoseconds frame = nominal_.clocks * nominal_.period;
  return frame + share_of(std::max(nominal_.interval - frame, nominal_.period), random);
}

}  // namespace biss::sim
