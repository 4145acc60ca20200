// The share of injected faults that must be accepted, by exact calculation.
#pragma once

#include <optional>

#include "lab/sequence_frame.hpp"

namespace biss::lab {

/// The share of a row's events that the monitor must accept; lab/reports/safety.md derives it.
/// \return nothing if it is not known: campaign_theory() returns nothing, or a word of zeros is a
///   good one
std::optional<long double> sequence_theory(const SequenceFrame& frame, const SequenceRow& row);

}  // namespace biss::lab
