#include "lab/sequence.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "lab/experiment.hpp"
#include "lab/parallel.hpp"
#include "lab/sequence_block.hpp"
#include "lab/sequence_fault.hpp"
#include "lab/sequence_frame.hpp"
#include "lab/sequence_theory.hpp"

namespace biss::lab {
namespace {

using Counters = SequencePlan::Counters;

// The monitors of all rows, one for each pair of counters.
class Frames {
 public:
  explicit Frames(const SequencePlan& plan) : plan_(plan) {}

  const SequenceFrame* of(const SequenceRow& row) {
    const Counters wanted{row.counter, row.encoder_counter};
    for (const auto& [counters, frame] : made_) {
      if (counters == wanted) return frame.get();
    }
    auto frame = SequenceFrame::make(plan_.format, plan_.setup, row.counter, row.encoder_counter);
    if (!frame) return nullptr;
    made_.emplace_back(wanted, std::make_unique<SequenceFrame>(std::move(*frame)));
    return made_.back().second.get();
  }

 private:
  const SequencePlan& plan_;
  std::vector<std::pair<Counters, std::unique_ptr<SequenceFrame>>> made_;
};

void set_sigma(SequenceResult& result, long double expected, long double variance) {
  if (result.theory && expected > 0) {
    result.sigma = deviation_of(result.counts.accepted, expected, variance);
  }
}

// What follows from counts and theory.
void finish(SequenceResult& result, const SequenceFrame& frame) {
  if (result.row.task == SequenceTask::counter_mode) result.theory = 0;
  if (result.row.task == SequenceTask::fault) {
    result.bound_cycles = reaction_bound(frame, result.row);
  }
  const auto events = static_cast<long double>(result.counts.events);
  const long double share = result.theory.value_or(0);
  set_sigma(result, share * events, share * (1 - share) * events);
}

// Adds up rows of one kind that stand one behind the other.
class KindSum {
 public:
  explicit KindSum(const SequenceResult& first) : sum_(first) {
    sum_.row.variant = static_cast<unsigned>(variants_of(first.row.kind).size());
    sum_.row.size = 0;
    sum_.counts = {};
  }
  void add(const SequenceResult& result) {
    sum_.row.size += result.row.size;
    sum_.counts.add(result.counts);
    sum_.bound_cycles = std::max(sum_.bound_cycles, result.bound_cycles);
    const auto events = static_cast<long double>(result.counts.events);
    if (!result.theory) {
      sum_.theory.reset();
      known_ = false;
    } else {
      expected_ += *result.theory * events;
      variance_ += *result.theory * (1 - *result.theory) * events;
    }
  }
  SequenceResult total() {
    // Indices of several rows mean nothing.
    sum_.counts.odd.clear();
    sum_.sigma.reset();
    if (known_ && sum_.counts.events != 0)
      sum_.theory = expected_ / static_cast<long double>(sum_.counts.events);
    set_sigma(sum_, expected_, variance_);
    return sum_;
  }

 private:
  SequenceResult sum_;
  long double expected_ = 0;
  long double variance_ = 0;
  bool known_ = true;
};

bool same_kind(const SequenceRow& a, const SequenceRow& b) {
  return a.task == SequenceTask::fault && b.task == SequenceTask::fault && a.kind == b.kind &&
         a.counter == b.counter && a.encoder_counter == b.encoder_counter;
}

std::vector<SequenceResult> with_sums(const std::vector<SequenceResult>& results) {
  std::vector<SequenceResult> all;
  for (std::size_t first = 0; first < results.size();) {
    std::size_t end = first;
    KindSum sum(results[first]);
    while (end < results.size() &&
           (end == first || same_kind(results[first].row, results[end].row))) {
      sum.add(results[end]);
      all.push_back(results[end++]);
    }
    if (end - first > 1) all.push_back(sum.total());
    first = end;
  }
  return all;
}

}  // namespace

void SequencePlan::add_undamaged(SequenceMotion motion, Counters counters, std::uint64_t frames) {
  rows.push_back({.task = SequenceTask::undamaged,
                  .counter = counters.monitor,
                  .encoder_counter = counters.encoder,
                  .motion = motion,
                  .size = frames});
}

void SequencePlan::add_counter_mode(Counters counters, std::uint64_t trials) {
  rows.push_back({.task = SequenceTask::counter_mode,
                  .counter = counters.monitor,
                  .encoder_counter = counters.encoder,
                  .size = trials});
}

void SequencePlan::add_fault(TransmissionError kind, Counters counters, std::uint64_t faults) {
  const std::uint64_t variants = variants_of(kind).size();
  for (unsigned variant = 0; variant < variants; ++variant) {
    rows.push_back({.task = SequenceTask::fault,
                    .kind = kind,
                    .variant = variant,
                    .counter = counters.monitor,
                    .encoder_counter = counters.encoder,
                    .size = faults / variants + (variant < faults % variants ? 1 : 0)});
  }
}

SequencePlan whole_plan(const FrameFormat& format, const SafetySetup& setup, std::uint64_t frames,
                        std::uint64_t faults, std::uint64_t seed) {
  using enum CounterMode;
  SequencePlan plan{.format = format, .setup = setup, .seed = seed};
  for (const CounterMode encoder : {count_1_63, count_0_63}) {
    plan.add_undamaged(SequenceMotion::max, {encoder, encoder}, frames);
    plan.add_undamaged(SequenceMotion::max, {learned, encoder}, frames);
  }
  plan.add_counter_mode({count_0_63, count_1_63}, faults);
  plan.add_counter_mode({count_1_63, count_0_63}, faults);
  const CounterMode encoder = setup.counter.mode == count_0_63 ? count_0_63 : count_1_63;
  for (const SafetyMeasure& measure : safety_measures) {
    plan.add_fault(measure.error, {setup.counter.mode, encoder}, faults);
  }
  return plan;
}

bool SequenceResult::passed() const {
  if (counts.false_alarms != 0 || counts.misread != 0 || counts.late != 0 ||
      counts.unexpected != 0) {
    return false;
  }
  if (!theory) return true;
  if (*theory == 0) return counts.accepted == 0;
  return std::abs(sigma.value_or(0)) <= sequence_sigma_limit;
}

std::optional<std::vector<SequenceResult>> run_sequences(
    const SequencePlan& plan, unsigned threads,
    const std::function<void(const SequenceProgress&)>& told) {
  Frames frames(plan);
  std::vector<SequenceResult> results;
  std::vector<const SequenceFrame*> frame_of;
  for (const SequenceRow& row : plan.rows) {
    frame_of.push_back(frames.of(row));
    if (frame_of.back() == nullptr) return std::nullopt;
    results.push_back({.row = row});
  }
  parallel_for(threads, results.size(), [&](std::size_t row) {
    if (plan.rows[row].task != SequenceTask::fault) return;
    results[row].theory = sequence_theory(*frame_of[row], plan.rows[row]);
  });
  std::vector<ExperimentRow<SequenceCounts>> rows;
  SequenceProgress progress;
  for (const SequenceRow& row : plan.rows) {
    rows.push_back({row.blocks(), {}, {}});
    progress.all += row.blocks().count();
  }
  ExperimentRun run{.threads = threads, .save_seconds = 0};
  run.save = [&] {
    progress.done = 0;
    for (const auto& row : rows) progress.done += row.done.size();
    if (told) told(progress);
    return true;
  };
  run_experiment(rows, run, [&](std::size_t row, std::uint64_t block) {
    return count_sequence(*frame_of[row], plan.rows[row], plan.seed, block);
  });
  for (std::size_t row = 0; row < results.size(); ++row) results[row].counts = rows[row].counts;
  for (std::size_t row = 0; row < results.size(); ++row) finish(results[row], *frame_of[row]);
  return with_sums(results);
}

}  // namespace biss::lab
