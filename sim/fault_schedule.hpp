// Which faults the line model injects: into which cycle, at which place, for how long.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "biss/base/units.hpp"
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

FaultPlaces places_of(FaultKind kind, PlaceUnit unit, const NominalCycle& nominal);

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
  FaultSchedule(std::vector<FaultRule> rules, std::uint64_t seed);

  bool empty() const { return rules_.empty(); }
  void set_nominal(const NominalCycle& nominal) { nominal_ = nominal; }
  const NominalCycle& nominal() const { return nominal_; }

  /// Draws the actions of a cycle, in the order of time; some of them are at `begin`.
  void begin_cycle(std::uint64_t number, Picoseconds begin);

  /// Returns the time of the next action, or `never`.
  Picoseconds next() const;
  /// Removes the next action and returns it. \pre next() is not `never`
  FaultAction take();

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

  void inject(const FaultRule& rule, Random& random, std::uint64_t number, Picoseconds begin);
  void add(FaultAction action);
  Picoseconds time_of(FaultPlace place) const;
  Picoseconds place_in_frame(Random& random) const;
  Picoseconds place_after_frame(Random& random) const;

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
