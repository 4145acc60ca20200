// Long sequences of safety frames for the whole monitor: undamaged frames, and the eight
// transmission errors of IEC 61784-3. docs/safety-experiments.md describes the counts.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "biss/frame/format.hpp"
#include "biss/safety/setup.hpp"
#include "biss/safety/verdict.hpp"
#include "lab/experiment.hpp"

namespace biss::lab {

enum class SequenceTask : std::uint8_t {
  undamaged,     ///< frames as the encoder sends them: only `safe` after start-up
  counter_mode,  ///< a counter of the other range: only the verdict `counter_mode`
  fault,         ///< a transmission error, injected again and again into a safe sequence
};

/// How an undamaged encoder moves. Every 512 frames it moves to another place, every second time to
/// one from which it passes zero; it moves 256 frames in one direction and 256 back.
enum class SequenceMotion : std::uint8_t {
  max,    ///< full speed: just below half a turn from frame to frame
  steps,  ///< every speed from one count to half the range, each magnitude equally often
  creep,  ///< a count or two in both directions, near a multiple of any power of two
};

inline constexpr std::array<std::string_view, 3> sequence_motion_names{"max", "steps", "creep"};

/// The text of the option --counter.
constexpr std::string_view name_of(CounterMode mode) {
  return counter_mode_names[static_cast<std::size_t>(mode)];
}

class FaultRun;
class SequenceFrame;
struct SequenceRow;

/// The exact share of a row's events that the monitor must accept; nothing if it is not known.
using SequenceTheory = std::optional<long double>(const SequenceFrame& frame,
                                                  const SequenceRow& row);

/// A way to inject a transmission error; docs/safety-experiments.md describes each.
struct SequenceVariant {
  TransmissionError error{};
  /// The name that users see; a fault that parse_fault() takes if bits are corrupted.
  std::string_view name;
  /// Injects one event. Null for `constant`: there the fault has existed since power-up.
  void (*inject)(FaultRun& run) = nullptr;
  /// Null: 0.
  SequenceTheory* theory = nullptr;
  /// The monitor is not called during the fault: only its watchdog can detect it.
  bool silent = false;
};

std::span<const SequenceVariant> variants_of(TransmissionError error);

/// A row of the table.
struct SequenceRow {
  SequenceTask task = SequenceTask::undamaged;
  /// For a fault: the error, and which of its variants.
  TransmissionError kind{};
  unsigned variant = 0;
  /// The counter mode of the monitor.
  CounterMode counter = CounterMode::count_1_63;
  /// The counter mode of the encoder; not `learned`.
  CounterMode encoder_counter = CounterMode::count_1_63;
  SequenceMotion motion = SequenceMotion::max;
  /// Undamaged frames, else events.
  std::uint64_t size = 0;

  bool operator==(const SequenceRow&) const = default;
  /// undamaged, counter_mode, or the name of the error.
  std::string_view name() const;
  /// The motion, or the variant of the error; `all` for a sum of variants.
  std::string_view variant_name() const;
  /// \pre task is `fault`, and the row is not a sum
  const SequenceVariant& injection() const { return variants_of(kind)[variant]; }
  bool is_constant() const { return task == SequenceTask::fault && injection().inject == nullptr; }
  /// The seed of the row's random numbers. It depends on everything but `size`, and not on other
  /// rows.
  std::uint64_t seed(std::uint64_t campaign_seed) const;
  /// Values of the encoder's counter.
  unsigned period() const { return encoder_counter == CounterMode::count_0_63 ? 64 : 63; }
  /// Its frames or events in blocks.
  TrialBlocks blocks() const;
};

/// The number of odd indices that are kept, the lowest ones.
inline constexpr std::size_t odd_kept = 16;

/// The counts of a row: whole numbers, sums in any order.
struct SequenceCounts {
  /// Undamaged frames that the monitor received, those between faults included.
  std::uint64_t frames = 0;
  /// Verdicts other than `safe` for these frames, or by time alone before them, after start-up.
  std::uint64_t false_alarms = 0;
  /// Undamaged frames that were safe with another position, counter or warning than was sent.
  std::uint64_t misread = 0;
  std::uint64_t position_wraps = 0;
  std::uint64_t counter_wraps = 0;

  /// Injected faults, or trials of a wrong counter range.
  std::uint64_t events = 0;
  /// Events with a frame that was safe and must not be; see SequenceResult::theory.
  std::uint64_t accepted = 0;
  /// Accepted events whose position is not the position of the encoder.
  std::uint64_t wrong = 0;
  /// Events that were neither accepted nor detected within the bound.
  std::uint64_t late = 0;
  /// Events whose first verdict is not one of the error's verdicts.
  std::uint64_t unexpected = 0;
  /// The first verdict of each event that was not accepted.
  std::array<std::uint64_t, safety_verdict_count> verdicts{};
  /// The longest time from the first affected request to that verdict, in cycles, rounded up.
  std::uint64_t worst_cycles = 0;
  /// Indices of frames or events in false_alarms, misread, accepted, late or unexpected.
  std::vector<std::uint64_t> odd{};

  bool operator==(const SequenceCounts&) const = default;

  /// Events that were not accepted and had a verdict.
  std::uint64_t detected() const;
  void add_odd(std::uint64_t index) { keep_lowest(odd, index, odd_kept); }
  void add(const SequenceCounts& other);
};

/// The rows to run. The same plan has the same results for any number of threads.
struct SequencePlan {
  FrameFormat format{};
  /// The monitor's setup; its counter mode is used for the faults.
  SafetySetup setup{};
  std::uint64_t seed = 1;
  std::vector<SequenceRow> rows{};

  struct Counters {
    CounterMode monitor{};
    CounterMode encoder{};
    bool operator==(const Counters&) const = default;
    /// The monitor is set up for the other range.
    bool differ() const { return monitor != CounterMode::learned && monitor != encoder; }
  };

  /// The setup of a row's monitor. For `constant` it has a budget of faults, so that a fault can be
  /// tolerated between a stimulus and its answer.
  SafetySetup setup_of(const SequenceRow& row) const;
  void add_undamaged(SequenceMotion motion, Counters counters, std::uint64_t frames);
  void add_counter_mode(Counters counters, std::uint64_t trials);
  /// A row for each variant of the error; `faults` are divided evenly between them.
  void add_fault(TransmissionError kind, Counters counters, std::uint64_t faults);
};

/// The result of a row; or the sum of an error's rows, whose variant is variants_of().size().
struct SequenceResult {
  SequenceRow row{};
  SequenceCounts counts{};
  /// The exact share of events that must be accepted, 0 included. None if it is not known; then it
  /// is not checked.
  std::optional<long double> theory{};
  /// The deviation of `accepted` from theory in standard deviations. None without a theory, or if
  /// it is 0.
  std::optional<double> sigma{};
  /// For a fault or trial: the verdict must come within this number of cycles.
  unsigned bound_cycles = 0;

  /// No false alarm; nothing misread, late or unexpected; at most sequence_sigma_limit from theory.
  bool passed() const;
};

/// By chance exceeded once in 3.5 million, on either side.
inline constexpr double sequence_sigma_limit = 5;

/// Blocks of all rows.
struct SequenceProgress {
  std::uint64_t done = 0;
  std::uint64_t all = 0;
};

/// Runs a plan.
/// \param threads 0: one for each core
/// \param report called after each block, from any thread, one call at a time
/// \return a result for each row, and one more after the rows of an error with several variants;
///   nothing if format and setup cannot be monitored (see CampaignFrame::make())
std::optional<std::vector<SequenceResult>> run_sequences(
    const SequencePlan& plan, unsigned threads = 0,
    const std::function<void(const SequenceProgress&)>& report = {});

}  // namespace biss::lab
