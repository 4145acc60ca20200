// The experiments of `biss safety` as functions: the request, the result, its table, and whether it is
// as it must be. A verb prints one experiment; evidence puts all of them into a folder.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/safety/verdict.hpp"
#include "lab/campaign.hpp"
#include "lab/sequence.hpp"
#include "report/table.hpp"
#include "sim/fault.hpp"
#include "verbs/common/exit_status.hpp"
#include "verbs/common/safety_format.hpp"

namespace biss::verbs {

class Host;

struct LineRequest {
  std::uint64_t cycles = 50'000;
  std::uint64_t seed = 1;
  /// By default the highest rate of the configuration's shortest cycle.
  std::optional<Hertz> rate;
  unsigned threads = 0;
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
  /// Of these, fault verdicts: false alarms, or faults that are detected late.
  std::uint64_t false_alarms = 0;
  /// Of these, `safe` with a position that was not sent.
  std::uint64_t wrong_undamaged = 0;
};

/// By sim::FaultKind.
using LineResult = std::array<LineCounts, sim::simulated_fault_count>;

/// \return one line of text where the line model cannot do it (usage: exit status 2)
tl::expected<LineResult, std::string> run_line_model(const SafetyFormat& monitored,
                                                     const LineRequest& request, Host& host);
/// \return false if the sink failed
bool write_line(const LineResult& result, std::uint64_t cycles, report::Format to,
                report::TextSink& sink, const report::TableOptions& options = {});
/// Done, or data_failed after a message for each fault that has a wrong count.
ExitStatus judge_line(const LineResult& result, Host& host);

struct CampaignRequest {
  std::uint64_t frames = 10'000'000;
  std::uint64_t seed = 1;
  unsigned threads = 0;
};

/// Counts all usual faults, rows by importance sampling included.
/// \return one line of text where a fault is none of this frame (usage: exit status 2)
tl::expected<lab::CampaignState, std::string> run_usual_campaign(const lab::CampaignFrame& frame,
                                                                 const CampaignRequest& request,
                                                                 Host& host);

/// As lab::run_sequences(), with the progress on a terminal.
std::optional<std::vector<lab::SequenceResult>> run_sequence_plan(const lab::SequencePlan& plan,
                                                                  unsigned threads, Host& host);
/// Done, or data_failed after a message for the first row that has not passed.
ExitStatus judge_sequences(std::span<const lab::SequenceResult> results, Host& host);

}  // namespace biss::verbs
