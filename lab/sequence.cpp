#include "lab/sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

#include "lab/parallel.hpp"
#include "lab/sequence_block.hpp"
#include "lab/sequence_theory.hpp"
#include "lab/statistics.hpp"

namespace biss::lab {
namespace {

constexpr std::array<SequenceVariant, 31> variants = [] {
  using E = TransmissionError;
  using I = Injection;
  return std::array<SequenceVariant, 31>{{
      {E::corruption, I::corrupt, "flips:0.5"},
      {E::corruption, I::corrupt, "flips:0.1"},
      {E::corruption, I::corrupt, "flips:0.01"},
      {E::corruption, I::corrupt, "flips:0.001"},
      {E::corruption, I::corrupt, "burst:8"},
      {E::corruption, I::corrupt, "burst:16"},
      {E::corruption, I::corrupt, "burst:32"},
      {E::repetition, I::previous, "previous"},
      {E::repetition, I::older, "older"},
      {E::repetition, I::any_age, "any_age"},
      {E::sequence, I::exchanged, "exchanged"},
      {E::sequence, I::shuffled, "shuffled"},
      {E::sequence, I::overtaken, "overtaken"},
      {E::loss, I::no_answer, "no_answer"},
      {E::loss, I::skipped, "skipped", "passed_over"},
      {E::loss, I::not_called, "not_called", "unheard"},
      {E::loss, I::whole_period, "whole_period"},
      {E::delay, I::watched, "watched"},
      {E::delay, I::unwatched, "unwatched"},
      {E::delay, I::stored, "stored"},
      {E::delay, I::constant, "constant"},
      {E::insertion, I::stale, "stale"},
      {E::insertion, I::foreign, "foreign"},
      {E::masquerade, I::noise, "noise"},
      {E::masquerade, I::noise_word, "noise_word"},
      {E::masquerade, I::wrong_start_value, "start_value"},
      {E::masquerade, I::polynomial, "polynomial"},
      {E::masquerade, I::standard, "standard"},
      {E::addressing, I::one_frame, "one_frame"},
      {E::addressing, I::permanent, "permanent", "for_good"},
      {E::addressing, I::foreign_start_value, "start_value"},
  }};
}();

constexpr std::uint64_t undamaged_block = 65'536;
constexpr std::uint64_t event_block = 1'024;

using Counters = SequencePlan::Counters;

// The plans of all rows, one for each pair of counters and setup.
class Frames {
 public:
  explicit Frames(const SequencePlan& plan) : plan_(plan) {}

  const SequenceFrame* of(const SequenceRow& row) {
    const std::pair wanted(Counters{row.counter, row.encoder_counter}, row.is_constant());
    for (const auto& [key, frame] : made_) {
      if (key == wanted) return frame.get();
    }
    auto frame =
        SequenceFrame::make(plan_.format, plan_.setup_of(row), row.counter, row.encoder_counter);
    if (!frame) return nullptr;
    made_.emplace_back(wanted, std::make_unique<SequenceFrame>(std::move(*frame)));
    return made_.back().second.get();
  }

 private:
  const SequencePlan& plan_;
  std::vector<std::pair<std::pair<Counters, bool>, std::unique_ptr<SequenceFrame>>> made_;
};

void set_sigma(SequenceResult& result, long double expected, long double variance) {
  if (result.theory && expected > 0) {
    result.sigma = deviation_of(result.counts.accepted, expected, variance);
  }
}

// Calculates what depends on counts and theory.
void finish(SequenceResult& result, const SequenceFrame& frame) {
  if (result.row.task == SequenceTask::counter_mode) result.theory = 0;
  if (result.row.task == SequenceTask::fault) {
    result.bound_cycles = reaction_bound(frame, result.row);
  }
  const auto events = static_cast<long double>(result.counts.events);
  const long double share = result.theory.value_or(0);
  set_sigma(result, share * events, share * (1 - share) * events);
}

// Adds up consecutive rows of one error.
class ErrorSum {
 public:
  explicit ErrorSum(const SequenceResult& first) : sum_(first) {
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
    // Indices belong to a row.
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

bool same_error(const SequenceRow& a, const SequenceRow& b) {
  return a.task == SequenceTask::fault && b.task == SequenceTask::fault && a.kind == b.kind &&
         a.counter == b.counter && a.encoder_counter == b.encoder_counter;
}

std::vector<SequenceResult> with_sums(const std::vector<SequenceResult>& results) {
  std::vector<SequenceResult> all;
  for (std::size_t first = 0; first < results.size();) {
    std::size_t end = first;
    ErrorSum sum(results[first]);
    while (end < results.size() &&
           (end == first || same_error(results[first].row, results[end].row))) {
      sum.add(results[end]);
      all.push_back(results[end++]);
    }
    if (end - first > 1) all.push_back(sum.total());
    first = end;
  }
  return all;
}

}  // namespace

std::span<const SequenceVariant> variants_of(TransmissionError error) {
  const auto of_error = [error](const SequenceVariant& each) { return each.error == error; };
  const auto first = std::find_if(variants.begin(), variants.end(), of_error);
  return {first, std::find_if_not(first, variants.end(), of_error)};
}

std::string_view SequenceRow::name() const {
  if (task == SequenceTask::undamaged) return "undamaged";
  if (task == SequenceTask::counter_mode) return "counter_mode";
  return biss::name_of(kind);
}

std::string_view SequenceRow::variant_name() const {
  if (task != SequenceTask::fault) return sequence_motion_names[static_cast<std::size_t>(motion)];
  const auto all = variants_of(kind);
  return variant < all.size() ? all[variant].name : "all";
}

std::uint64_t SequenceRow::seed(std::uint64_t campaign_seed) const {
  const std::string_view variant_text =
      task == SequenceTask::fault ? variants_of(kind)[variant].seed_name() : variant_name();
  return row_seed(campaign_seed, fmt::format("{}:{}:{}:{}", name(), variant_text, name_of(counter),
                                             name_of(encoder_counter)));
}

TrialBlocks SequenceRow::blocks() const {
  return {size, task == SequenceTask::undamaged ? undamaged_block : event_block};
}

std::uint64_t SequenceCounts::detected() const {
  return std::accumulate(verdicts.begin(), verdicts.end(), std::uint64_t{0});
}

void SequenceCounts::add_odd(std::uint64_t index) {
  const auto place = std::lower_bound(odd.begin(), odd.end(), index);
  if (place != odd.end() && *place == index) return;
  if (place == odd.end() && odd.size() == odd_kept) return;
  odd.insert(place, index);
  if (odd.size() > odd_kept) odd.pop_back();
}

void SequenceCounts::add(const SequenceCounts& other) {
  frames += other.frames;
  false_alarms += other.false_alarms;
  misread += other.misread;
  position_wraps += other.position_wraps;
  counter_wraps += other.counter_wraps;
  events += other.events;
  accepted += other.accepted;
  wrong += other.wrong;
  late += other.late;
  unexpected += other.unexpected;
  for (std::size_t k = 0; k < verdicts.size(); ++k) verdicts[k] += other.verdicts[k];
  worst_cycles = std::max(worst_cycles, other.worst_cycles);
  for (const std::uint64_t index : other.odd) add_odd(index);
}

SafetySetup SequencePlan::setup_of(const SequenceRow& row) const {
  SafetySetup chosen = setup;
  if (row.is_constant()) {
    chosen.frame_gap_max = std::max(setup.frame_gap_max, setup.cycle_min * 4);
    chosen.budget = {.faults = 2, .window = std::max(chosen.frame_gap_max, setup.cycle_min * 64)};
  }
  return chosen;
}

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
  const std::uint64_t count = variants_of(kind).size();
  for (unsigned variant = 0; variant < count; ++variant) {
    rows.push_back({.task = SequenceTask::fault,
                    .kind = kind,
                    .variant = variant,
                    .counter = counters.monitor,
                    .encoder_counter = counters.encoder,
                    .size = faults / count + (variant < faults % count ? 1 : 0)});
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
    const std::function<void(const SequenceProgress&)>& report) {
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
    if (report) report(progress);
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
