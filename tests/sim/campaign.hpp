// A damaged line, decoded and compared with the truth.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "decode/cycle.hpp"
#include "sim/line.hpp"

namespace biss::campaign {

/// The results of the cycles with the same fault.
struct Tally {
  std::uint64_t cycles = 0;
  /// By status; `ok` with the true position.
  std::array<std::uint64_t, cycle_status_count> statuses{};
  /// `ok` with another position, nE = 1.
  std::uint64_t wrong = 0;
  /// `ok` with another position and nE = 0: not trusted().
  std::uint64_t wrong_error = 0;
  /// No row at the time of the request.
  std::uint64_t missing = 0;

  std::uint64_t right() const { return statuses[0]; }
};

/// The result of a complete run.
struct Outcome {
  /// Cycles with an entry of that kind, alone or with others.
  std::array<std::uint64_t, sim::simulated_fault_count> injected{};
  /// Cycles with that entry alone, and none before it.
  std::array<Tally, sim::simulated_fault_count> alone{};
  /// Cycles without an entry after a cycle with one.
  Tally behind;
  /// Cycles with several entries, or with one entry after a cycle with one.
  Tally several;
  /// Neither the cycle nor the one before it has an entry.
  Tally undamaged;
  /// The undamaged cycles that are not `ok` with the true position, one line for each.
  std::string complaints;
  /// Rows at a time without a request.
  std::uint64_t extra_rows = 0;
  /// The master's own readings: good frames with another position and nE = 1 in undamaged cycles.
  std::uint64_t master_wrong = 0;
  std::uint64_t master_failed = 0;
};

/// MA and SLO are exchanged at the recorder during the last `length` of every `every` cycles: from
/// within the first of these cycles to within the last. Counts as the fault `exchange`.
struct ProbeExchange {
  std::uint64_t every = 0;  ///< 0: never
  std::uint64_t length = 0;
};

/// Runs the line for `cycles` cycles and decodes its capture.
Outcome run(const sim::LineSetup& setup, std::uint64_t cycles, const ProbeExchange& probes = {});

/// Every kind of fault at this share of cycles, in parts of 2^32.
std::vector<sim::FaultRule> all_faults(std::uint64_t share);

}  // namespace biss::campaign
