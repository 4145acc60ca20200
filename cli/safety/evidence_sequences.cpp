// Frames in order for the bundle: undamaged ones, and the eight kinds of fault.
#include "cli/safety/evidence.hpp"
#include "cli/safety/sequence_table.hpp"
#include "lab/sequence.hpp"
#include "report/table.hpp"

namespace biss::cli {
namespace {

// Every event after which a frame was safe that must not be counts, whatever its position was.
CoverageRow row_of(const lab::SequenceResult& result) {
  const lab::SequenceCounts& counts = result.counts;
  CoverageRow row{.kind = name_of(result.row.kind),
                  .by = "sequences",
                  .fault = std::string(result.row.variant_name()),
                  .committed = counts.events,
                  .detected = counts.recognised(),
                  .accepted_wrong = counts.accepted,
                  .theory = {},
                  .reaction = {},
                  .verdicts = verdicts_text(counts.verdicts)};
  if (result.theory) row.theory = static_cast<double>(*result.theory);
  if (counts.recognised() != 0) row.reaction = counts.worst_cycles;
  set_share(row);
  return row;
}

bool is_sum(const lab::SequenceResult& result) {
  return result.row.variant == lab::variants_of(result.row.kind).size();
}

}  // namespace

EvidencePart evidence_sequences(const EvidenceQuestion& question) {
  const EvidenceOptions& options = question.options;
  const lab::SequencePlan plan = lab::whole_plan(question.format, question.setup, options.frames,
                                                 options.faults, options.seed);
  EvidencePart part;
  const auto results = lab::run_sequences(plan, question.threads);
  if (!results) {
    part.error = "these two words are too long for the sequences: 64 bits a word, 126 together";
    return part;
  }
  for (const lab::SequenceResult& result : *results) {
    if (!result.passed()) part.findings.push_back("sequences.csv, " + failure_of(result));
    if (result.row.task == lab::SequenceTask::fault && !is_sum(result)) {
      part.coverage.push_back(row_of(result));
    }
  }
  report::StringSink csv;
  write_sequences(*results, report::Format::csv, csv, false);
  part.files.push_back({"sequences.csv", csv.text()});
  return part;
}

}  // namespace biss::cli
