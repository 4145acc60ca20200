// Long runs of safety frames in order before the whole monitor: undamaged ones by the billion, each
// of the eight kinds of fault by the million. docs/safety-sequences.md says what is counted.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "biss/frame/format.hpp"
#include "biss/safety/setup.hpp"
#include "biss/safety/verdict.hpp"
#include "lab/sequence_counts.hpp"
#include "lab/sequence_row.hpp"

namespace biss::lab {

/// What is asked for. The same plan gives the same results, whatever the threads.
struct SequencePlan {
  FrameFormat format{};
  /// The monitor's; its counter mode is that of the faults.
  SafetySetup setup{};
  std::uint64_t seed = 1;
  std::vector<SequenceRow> rows{};

  /// A CounterMode each.
  struct Counters {
    CounterMode monitor{};
    CounterMode encoder{};
    bool operator==(const Counters&) const = default;
    /// The monitor is set up for the other range.
    bool differ() const { return monitor != CounterMode::learned && monitor != encoder; }
  };

  /// Rows: `frames` undamaged ones of each pair, or as many trials as `faults` where it differs.
  void add_undamaged(SequenceMotion motion, Counters counters, std::uint64_t frames);
  void add_counter_mode(Counters counters, std::uint64_t trials);
  /// `faults` of a kind, shared evenly between its variants, a row each.
  void add_fault(TransmissionError kind, Counters counters, std::uint64_t faults);
};

/// Everything there is: undamaged at `motion` with both counters, set up and learned; both wrong
/// assumptions; the eight kinds with the setup's counter (1…63 where it is learned).
SequencePlan whole_plan(const FrameFormat& format, const SafetySetup& setup, std::uint64_t frames,
                        std::uint64_t faults, std::uint64_t seed = 1);

/// A row and what came of it; or the sum of a kind's rows, whose variant is variants_of().size().
struct SequenceResult {
  SequenceRow row{};
  SequenceCounts counts{};
  /// The share of the events that has to be accepted: exact, 0 included. None where it is not
  /// known, and then nothing is judged by it.
  std::optional<long double> theory{};
  /// By how much the accepted ones are more than the theory, in standard deviations: the normal
  /// deviate as unlikely as their number. None without theory, or where it is 0.
  std::optional<double> sigma{};
  /// Of a fault or trial: the verdict has to come within so many cycles.
  unsigned bound_cycles = 0;

  /// No false alarm, nothing misread, late, under a wrong name, or more than five standard
  /// deviations from the theory.
  bool passed() const;
};

/// Five standard deviations: by chance once in 3.5 million, on either side.
inline constexpr double sequence_sigma_limit = 5;

struct SequenceProgress {
  /// Blocks, of all rows.
  std::uint64_t done = 0;
  std::uint64_t all = 0;
};

/// Runs a plan on all cores.
/// \param threads 0: as many as there are cores
/// \param told now and then, from any thread, one at a time
/// \return a result a row, and one more behind the rows of a kind that has several; none where
///   format and setup are no pair of words that can be monitored (see CampaignFrame::make())
std::optional<std::vector<SequenceResult>> run_sequences(
    const SequencePlan& plan, unsigned threads = 0,
    const std::function<void(const SequenceProgress&)>& told = {});

}  // namespace biss::lab
