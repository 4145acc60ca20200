// Which faults strike in which cycle, where in it, and for how long.
#pragma once

#include <cstdint>
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
  /// MA to SLO as the master sees it.
  Picoseconds line_delay{};
  unsigned payload_bits = 0;
};

/// A fault begins or ends.
struct FaultAction {
  Picoseconds time{};
  FaultKind kind{};
  bool begins = false;
};

/// What strikes, drawn anew for each cycle from the seed, the kind and the cycle's number alone: a
/// rule that is added or changed leaves the others' strikes where they were.
///
/// No kind strikes again while it lasts.
class FaultSchedule {
 public:
  FaultSchedule(std::vector<FaultRule> rules, std::uint64_t seed);

  bool empty() const { return rules_.empty(); }
  void set_nominal(const NominalCycle& nominal) { nominal_ = nominal; }

  /// Lays out a cycle: what begins or ends in it, in the order of time, some of it at `begin`.
  void begin_cycle(std::uint64_t number, Picoseconds begin);

  /// When the next action is due; `never` where there is none.
  Picoseconds next() const;
  /// \pre next() is not `never`
  FaultAction take();

  /// A number of its own for each cycle and kind: what exactly the fault is.
  std::uint64_t detail(FaultKind kind) const { return details_[static_cast<std::size_t>(kind)]; }

 private:
  struct Ending {
    FaultKind kind{};
    std::uint64_t cycle = 0;
    Picoseconds after{};
  };

  void strike(FaultKind kind, Random& random, std::uint64_t number, Picoseconds begin);
  void add(FaultAction action);
  Picoseconds place_in_frame(Random& random) const;
  Picoseconds place_behind_frame(Random& random) const;

  std::vector<FaultRule> rules_;
  std::uint64_t seed_;
  NominalCycle nominal_;
  std::vector<FaultAction> actions_;  // the next one last
  std::vector<Ending> endings_;
  FaultSet lasting_ = 0;
  std::array<std::uint64_t, fault_kind_count> details_{};
};

}  // namespace biss::sim
