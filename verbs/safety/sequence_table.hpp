// The table of safety sequences.
#pragma once

#include <span>
#include <string>

#include "lab/sequence.hpp"
#include "report/table.hpp"

namespace biss::verbs {

/// CSV and JSON lines have all columns. The sum of an error's rows follows them.
/// \return false if the sink failed
bool write_sequences(std::span<const lab::SequenceResult> results, report::Format to,
                     report::TextSink& sink, const report::TableOptions& table_options = {});

/// Why a row has not passed, in one line: false alarms, late verdicts, ….
std::string failure_of(const lab::SequenceResult& result);

}  // namespace biss::verbs
