// The eight kinds of fault, committed in a running sequence.
#pragma once

#include <cstdint>

#include "lab/sequence_block.hpp"

namespace biss::lab {

/// Block `block` of a fault's row: events of one variant, each from a safe monitor.
/// \param start_up so many frames of a monitor that knows nothing may be `starting`
SequenceCounts count_faults(const SequenceFrame& frame, const SequenceRow& row, std::uint64_t seed,
                            std::uint64_t block, const SequenceWatcher& watcher, unsigned start_up);

/// A fault's verdict has to come within so many cycles after the first request that has it: in the
/// same one, or where a frame stays away and nobody asks, when the watchdog bites.
unsigned reaction_bound(const SequenceFrame& frame, const SequenceRow& row);

}  // namespace biss::lab
