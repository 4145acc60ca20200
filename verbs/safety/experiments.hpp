// The experiments of `biss safety` as functions: the request, the result, its table, and whether it
// is as expected. A verb prints one experiment; evidence puts all of them into a folder.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/safety/verdict.hpp"
#include "lab/campaign.hpp"
#include "lab/campaign_theory.hpp"
#include "lab/sequence.hpp"
#include "sim/fault.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/safety_format.hpp"

namespace biss::verbs {

class Verb;

/// Options of every experiment.
struct ExperimentOptions {
  std::string format{};
  std::uint64_t seed = 1;
  unsigned threads = 0;
  report::Format to = report::Format::table;
  std::string output{};
};

void add_seed_option(Verb verb, std::uint64_t& seed);
void add_threads_option(Verb verb, unsigned& threads);

/// The frame and its monitor; throws a VerbError if `-f` is wrong.
SafetyFormat monitored_by(const std::string& format);
/// The mistake in `-f`.
VerbError wrong_format(const std::string& format);

/// Writes a table to the output that the options name.
ExitStatus print_rows(const std::vector<FieldRow>& rows, const ExperimentOptions& options,
                      Host& host);

struct LineRequest : ExperimentOptions {
  std::uint64_t cycles = 50'000;
  /// By default the highest rate of the configuration's shortest cycle.
  std::optional<Hertz> rate;
};

/// The counts of a fault of the line model.
struct LineCounts {
  std::uint64_t injected = 0;
  std::uint64_t detected = 0;
  std::uint64_t accepted_wrong = 0;
  std::uint64_t reaction = 0;
  std::array<std::uint64_t, safety_verdict_count> verdicts{};
  /// Verdicts on requests without a fault.
  std::uint64_t undamaged = 0;
  /// The undamaged frames with a fault verdict: false alarms, or faults that are detected late.
  std::uint64_t false_alarms = 0;
  /// The undamaged frames that are `safe` with a position that was not sent.
  std::uint64_t wrong_undamaged = 0;
};

/// By sim::FaultKind.
using LineResult = std::array<LineCounts, sim::simulated_fault_count>;

/// Throws a VerbError if the line model cannot do it.
LineResult run_line_model(const SafetyFormat& monitored, const LineRequest& request, Host& host);
std::vector<FieldRow> line_table(const LineResult& result, std::uint64_t cycles);
/// Done, or data_failed after a message for each fault that has a wrong count.
ExitStatus judge_line(const LineResult& result, Host& host);

/// Counts all usual faults, rows by importance sampling included. Throws a VerbError if a fault does
/// not apply to this frame.
lab::CampaignState run_usual_campaign(const lab::CampaignFrame& frame, std::uint64_t frames,
                                      const ExperimentOptions& options, Host& host);

/// A fault of a campaign, and its measurements.
struct CampaignRow {
  lab::FaultChoice fault;
  /// The counts of the fault in the state.
  const lab::CampaignCounts& counts;
  std::optional<lab::CampaignTheory> theory;
  /// By lab::Acceptance; none if the fault has no counts of this kind.
  std::array<std::optional<lab::CampaignEstimate>, lab::acceptance_count> estimates{};
};

/// \pre the state outlives the rows
std::vector<CampaignRow> campaign_rows(const lab::CampaignFrame& frame,
                                       const lab::CampaignState& state);
/// CSV and JSON lines have a row for each fault, the human-readable table a row for each fault and
/// check.
std::vector<FieldRow> campaign_table(std::span<const CampaignRow> rows, report::Format to);
/// Done, or data_failed after a message: a count is more than five standard deviations from the
/// theory.
ExitStatus judge_campaign(std::span<const CampaignRow> rows, Host& host);
/// A deviation for the human-readable table, `+1.53`; 0 after rounding has no sign.
std::string sigma_text(long double sigma);

/// Everything: undamaged frames at full speed with both counters, set up and learned; both wrong
/// counter ranges; the eight errors with the setup's counter (1…63 if it is learned).
lab::SequencePlan usual_sequences(const SafetyFormat& monitored, std::uint64_t frames,
                                  std::uint64_t faults, std::uint64_t seed);
/// The same as lab::run_sequences(), with the progress on a terminal. Throws wrong_format().
std::vector<lab::SequenceResult> run_sequence_plan(const lab::SequencePlan& plan,
                                                   const ExperimentOptions& options, Host& host);
/// The sum of an error's rows follows them.
/// CSV and JSON lines have more columns.
std::vector<FieldRow> sequence_table(std::span<const lab::SequenceResult> results,
                                     report::Format to);
/// Done, or data_failed after a message for the first row that has not passed.
ExitStatus judge_sequences(std::span<const lab::SequenceResult> results, Host& host);

}  // namespace biss::verbs
