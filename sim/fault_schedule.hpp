// Which faults strike in which cycle, where in it, and for how long.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "biss/base/units.hpp"
#include "sim/fault.hpp"
#include "sim/random.hpp"

namespace biss::sim {

/// An undisturbed cycle, which faults are laid out by.
struct NominalCycle {
  Picoseconds period{};
  Picoseconds low_time{};
  /// From one request to the next.
  Picoseconds interval{};
  /// Rising edges of MA.
  std::uint32_t clocks = 0;
  /// The clock that makes the encoder send its first bit of data.
  std::uint32_t data_clock = 0;
  /// MA to SLO as the master sees it.
  Picoseconds line_delay{};
  unsigned payload_bits = 0;
};

/// Where a kind can strike in a cycle: bits or clocks from `first` to `last`, both included, of
/// which it takes a point, or a whole one. `last` below `first`: nowhere.
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

FaultPlaces places_of(FaultKind kind, PlaceUnit unit, const NominalCycle& nominal);

/// A fault begins or ends.
struct FaultAction {
  Picoseconds time{};
  FaultKind kind{};
  bool begins = false;
};

/// What strikes, drawn anew for each cycle from the seed, the kind and the cycle's number alone: a
/// rule that is added or changed leaves the others' strikes where they were.
///
/// No kind strikes again while it lasts. In a cycle that a rule names, that rule strikes and no
/// other of its kind.
class FaultSchedule {
 public:
  /// \pre a rule's place is one of places_of() for the nominal cycle
  FaultSchedule(std::vector<FaultRule> rules, std::uint64_t seed);

  bool empty() const { return rules_.empty(); }
  void set_nominal(const NominalCycle& nominal) { nominal_ = nominal; }
  const NominalCycle& nominal() const { return nominal_; }

  /// Lays out a cycle: what begins or ends in it, in the order of time, some of it at `begin`.
  void begin_cycle(std::uint64_t number, Picoseconds begin);

  /// When the next action is due; `never` where there is none.
  Picoseconds next() const;
  /// \pre next() is not `never`
  FaultAction take();

  /// A number of its own for each cycle and kind: what exactly the fault is.
  std::uint64_t detail(FaultKind kind) const { return details_[static_cast<std::size_t>(kind)]; }
  /// Where the kind struck last, if a rule said so or it strikes a whole clock.
  std::optional<FaultPlace> place(FaultKind kind) const {
    return places_[static_cast<std::size_t>(kind)];
  }

 private:
  struct Ending {
    FaultKind kind{};
    std::uint64_t cycle = 0;
    Picoseconds after{};
  };

  void strike(const FaultRule& rule, Random& random, std::uint64_t number, Picoseconds begin);
  void add(FaultAction action);
  Picoseconds time_of(FaultPlace place) const;
  Picoseconds place_in_frame(Random& random) const;
  Picoseconds place_behind_frame(Random& random) const;

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
