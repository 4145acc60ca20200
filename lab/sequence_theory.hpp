// How many faults of a run of frames have to be accepted, by exact calculation.
#pragma once

#include <optional>

#include "lab/sequence_frame.hpp"
#include "lab/sequence_row.hpp"

namespace biss::lab {

/// The share of a row's events that the monitor has to accept; docs/safety-sequences.md derives it.
/// \return none where it is not known: campaign_theory() has none, or a format in which a word of
///   zeros is a good one
std::optional<long double> sequence_theory(const SequenceFrame& frame, const SequenceRow& row);

/// The number of standard deviations by which `accepted` of `events` is above `expected`: exact for
/// few by Poisson's distribution, else by the normal one. \pre expected is above 0
/// \param variance of the number of accepted events
double deviation_of(std::uint64_t accepted, long double expected, long double variance);

}  // namespace biss::lab
