// The table of runs of safety frames in order.
#pragma once

#include <span>
#include <string>

#include "lab/sequence.hpp"
#include "report/table.hpp"

namespace biss::cli {

/// Machines get every column; eyes those that say something, and a kind's sum as its last row.
/// \return false where the sink did not take it
bool write_sequences(std::span<const lab::SequenceResult> results, report::Format to,
                     report::TextSink& sink, bool colour);

/// Why a row has not passed, for one line: its false alarms, what came late, ….
std::string failure_of(const lab::SequenceResult& result);

}  // namespace biss::cli
