// What a monitor checks, in the words of the analysis: the one place where the two meet.
#pragma once

#include "biss/safety/setup.hpp"
#include "lab/pair.hpp"
#include "lab/structure.hpp"

namespace biss::lab {

/// The comparison of a setup. Counter and nE are always judged by a monitor.
constexpr PairChecks pair_checks_of(const SafetySetup& setup) {
  return {.compare_bits = setup.comparison.compare_bits,
          .tolerance_lsb = setup.comparison.tolerance_lsb,
          .compare_turns = setup.comparison.multiturn == MultiturnRule::with_carry};
}

/// The same for faults of structure, CDS sent as 0.
constexpr StructureModel structure_model_of(const SafetySetup& setup) {
  return {.pair = true, .checks = pair_checks_of(setup)};
}

}  // namespace biss::lab
