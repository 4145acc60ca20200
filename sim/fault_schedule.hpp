// Which faults the line model injects: into which cycle, at which place, for how long.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/timing/step.hpp"
#include "sim/fault.hpp"
#include "sim/random.hpp"

namespace biss::sim {

/// An undisturbed cycle, by which faults are placed.
struct NominalCycle {
  Picoseconds period{};
  Picoseconds low_time{};
  /// From one request to the next.
  Picoseconds interval{};
  /// Rising edges of MA.
  std::uint32_t clocks = 0;
  /// The clock with which the encoder sends its first bit of data.
  std::uint32_t data_clock = 0;
  /// MA to SLO as the master sees it.
  Picoseconds line_delay{};
  unsigned payload_bits = 0;
};

/// The places in a cycle at which a kind can begin: bits or clocks from `first` to `last`, both
/// included; a point in one of them, or a whole bit or clock. None if `last` is below `first`.
struct FaultPlaces {
  std::uint64_t first = 1;
  std::uint64_t last = 0;
  bool whole = true;

  constexpr bool empty() const { return last < first; }
  constexpr bool contains(FaultPlace place) const {
    return place.whole() >= first && place.whole() <= last &&
           (!whole || place.thousandths % 1000U == 0);
  }
};

// The seed of the draws for a kind in a cycle. Wrong frames, which were added later, count down from
// the other end, so that the seeds of the line faults did not change.
inline std::uint64_t draw_of(FaultKind kind, std::uint64_t number) {
  const auto index = static_cast<std::uint64_t>(kind);
  if (index < line_fault_kind_count) return scrambled(number * line_fault_kind_count + index + 1U);
  return scrambled(~(number * line_fault_kind_count + index - line_fault_kind_count));
}

inline Picoseconds share_of(Picoseconds time, Random& random) {
  return part_of(time, random.below(time_parts));
}

// These change what the master receives on SLO, so a bit can be their place.
inline bool affects_slo(FaultKind kind) {
  return kind == FaultKind::glitch_slo || kind == FaultKind::slo_low ||
         kind == FaultKind::slo_high || kind == FaultKind::cut;
}

// A pause has a clock after it.
inline std::uint32_t last_clock_of(FaultKind kind, const NominalCycle& nominal) {
  return nominal.clocks - (kind == FaultKind::ma_pause && nominal.clocks > 1 ? 2U : 1U);
}

// Bits of the payload; a burst begins before the last one.
inline FaultPlaces bits_of(FaultKind kind, unsigned payload_bits) {
  const bool pattern = kind == FaultKind::flip || kind == FaultKind::burst;
  const unsigned last_bits = kind == FaultKind::burst ? 2 : 1;
  if ((!pattern && !affects_slo(kind)) || payload_bits < last_bits) return {};
  return {0, payload_bits - last_bits, pattern};
}

inline FaultPlaces places_of(FaultKind kind, PlaceUnit unit, const NominalCycle& nominal) {
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

/// A fault begins or ends.
struct FaultAction {
  Picoseconds time{};
  FaultKind kind{};
  bool begins = false;
};

/// Draws faults for each cycle from the seed, the kind and the cycle's number alone: a rule that is
/// added or changed does not change the faults of the others.
///
/// A kind does not begin again while it lasts. In a cycle that a rule names, this rule applies and
/// no other of its kind.
class FaultSchedule {
 public:
  /// \pre a rule's place is one of places_of() for the nominal cycle
  FaultSchedule(std::vector<FaultRule> rules, std::uint64_t seed)
      : seed_(scrambled(seed ^ 0x5DEECE66DU)) {
    set_rules(std::move(rules));
  }

  /// The rules from the next cycle on. A fault that lasts ends as it was drawn.
  void set_rules(std::vector<FaultRule> rules) {
    rules_ = std::move(rules);
    std::stable_partition(rules_.begin(), rules_.end(),
                          [](const FaultRule& rule) { return rule.cycle.has_value(); });
  }

  bool empty() const { return rules_.empty(); }
  void set_nominal(const NominalCycle& nominal) { nominal_ = nominal; }
  const NominalCycle& nominal() const { return nominal_; }

  /// Draws the actions of a cycle, in the order of time; some of them are at `begin`.
  void begin_cycle(std::uint64_t number, Picoseconds begin) {
    std::erase_if(endings_, [&](const Ending& ending) {
      if (ending.cycle > number) return false;
      if (ending.after.count == 0) lasting_ &= ~set_of(ending.kind);
      // Not before its begin, if the caller's master requests earlier than nominal.
      Picoseconds end = begin + ending.after;
      for (const FaultAction& action : actions_) {
        if (action.begins && action.kind == ending.kind) end = std::max(end, action.time);
      }
      add({end, ending.kind, false});
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

  /// Returns the time of the next action, or `never`.
  Picoseconds next() const { return actions_.empty() ? never : actions_.back().time; }

  /// Removes the next action and returns it. \pre next() is not `never`
  FaultAction take() {
    const FaultAction action = actions_.back();
    actions_.pop_back();
    lasting_ = action.begins ? lasting_ | set_of(action.kind) : lasting_ & ~set_of(action.kind);
    return action;
  }

  /// Returns a random number for this cycle and kind, for the details of the fault.
  std::uint64_t detail(FaultKind kind) const { return details_[static_cast<std::size_t>(kind)]; }
  /// Returns the place at which the kind last began, if a rule gives the place or the kind takes a
  /// whole clock.
  std::optional<FaultPlace> place(FaultKind kind) const {
    return places_[static_cast<std::size_t>(kind)];
  }

 private:
  struct Ending {
    FaultKind kind{};
    std::uint64_t cycle = 0;
    Picoseconds after{};
  };

  // A given place does not change the other draws.
  void inject(const FaultRule& rule, Random& random, std::uint64_t number, Picoseconds begin) {
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
      const Picoseconds frame = nominal_.clocks * nominal_.period;
      at += frame + share_of(std::max(nominal_.interval - frame, nominal_.period), random);
    }
    at = std::max(at, begin);
    add({at, kind, true});
    add({at + width, kind, false});
  }

  void add(FaultAction action) {
    const auto place = std::lower_bound(
        actions_.begin(), actions_.end(), action,
        [](const FaultAction& a, const FaultAction& b) { return a.time > b.time; });
    actions_.insert(place, action);
  }

  // Since the beginning of the cycle.
  Picoseconds time_of(FaultPlace place) const {
    const Picoseconds time = nominal_.period * static_cast<std::int64_t>(place.thousandths) / 1000;
    if (place.unit == PlaceUnit::clock) return time;
    return nominal_.data_clock * nominal_.period + nominal_.low_time + nominal_.line_delay + time;
  }

  Picoseconds place_in_frame(Random& random) const {
    return share_of(nominal_.clocks * nominal_.period, random);
  }

  std::vector<FaultRule> rules_;
  std::uint64_t seed_;
  NominalCycle nominal_;
  std::vector<FaultAction> actions_;  // the next one last
  std::vector<Ending> endings_;
  FaultSet lasting_ = 0;
  std::array<std::uint64_t, fault_kind_count> details_{};
  std::array<std::optional<FaultPlace>, fault_kind_count> places_{};
};

}  // namespace biss::sim
