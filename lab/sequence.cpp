#include "lab/sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "lab/experiment.hpp"
#include "lab/sequence_block.hpp"
#include "lab/sequence_theory.hpp"
#include "lab/statistics.hpp"

namespace biss::lab {
namespace {

constexpr std::uint64_t undamaged_block = 65'536;
constexpr std::uint64_t event_block = 1'024;

using Counters = SequencePlan::Counters;

void set_sigma(SequenceResult& result, long double expected, long double variance) {
  if (result.theory && expected > 0) {
    result.sigma = deviation_of(result.counts.accepted, expected, variance);
  }
}

// The sum of several rows of one error.
SequenceResult sum_of(std::span<const SequenceResult> rows) {
  SequenceResult sum{.row = rows[0].row, .theory = rows[0].theory};
  sum.row.variant = static_cast<unsigned>(variants_of(sum.row.kind).size());
  sum.row.size = 0;
  long double expected = 0;
  long double variance = 0;
  for (const SequenceResult& each : rows) {
    sum.row.size += each.row.size;
    sum.counts.add(each.counts);
    sum.bound_cycles = std::max(sum.bound_cycles, each.bound_cycles);
    const auto events = static_cast<long double>(each.counts.events);
    const long double share = each.theory.value_or(0);
    expected += share * events;
    variance += share * (1 - share) * events;
    if (!each.theory) sum.theory.reset();
  }
  // Indices belong to a row.
  sum.counts.odd.clear();
  if (sum.theory && sum.counts.events != 0) {
    sum.theory = expected / static_cast<long double>(sum.counts.events);
  }
  set_sigma(sum, expected, variance);
  return sum;
}

bool same_error(const SequenceRow& a, const SequenceRow& b) {
  return a.task == SequenceTask::fault && b.task == SequenceTask::fault && a.kind == b.kind &&
         a.counter == b.counter && a.encoder_counter == b.encoder_counter;
}

std::vector<SequenceResult> with_sums(std::span<const SequenceResult> results) {
  std::vector<SequenceResult> all;
  while (!results.empty()) {
    std::size_t count = 1;
    while (count < results.size() && same_error(results[0].row, results[count].row)) ++count;
    all.insert(all.end(), results.begin(), results.begin() + static_cast<std::ptrdiff_t>(count));
    if (count > 1) all.push_back(sum_of(results.first(count)));
    results = results.subspan(count);
  }
  return all;
}

}  // namespace

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
  return row_seed(campaign_seed, fmt::format("{}:{}:{}:{}", name(), seed_name(variant_name()),
                                             name_of(counter), name_of(encoder_counter)));
}

TrialBlocks SequenceRow::blocks() const {
  return {size, task == SequenceTask::undamaged ? undamaged_block : event_block};
}

std::uint64_t SequenceCounts::detected() const {
  return std::accumulate(verdicts.begin(), verdicts.end(), std::uint64_t{0});
}

void SequenceCounts::add(const SequenceCounts& other) {
  for (const auto sum :
       {&SequenceCounts::frames, &SequenceCounts::false_alarms, &SequenceCounts::misread,
        &SequenceCounts::position_wraps, &SequenceCounts::counter_wraps, &SequenceCounts::events,
        &SequenceCounts::accepted, &SequenceCounts::wrong, &SequenceCounts::late,
        &SequenceCounts::unexpected}) {
    this->*sum += other.*sum;
  }
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
  // One for each pair of counters and setup.
  std::map<std::tuple<CounterMode, CounterMode, bool>, std::optional<SequenceFrame>> frames;
  std::vector<const SequenceFrame*> frame_of;
  for (const SequenceRow& row : plan.rows) {
    const auto [at, fresh] =
        frames.try_emplace({row.counter, row.encoder_counter, row.is_constant()});
    if (fresh) {
      at->second =
          SequenceFrame::make(plan.format, plan.setup_of(row), row.counter, row.encoder_counter);
    }
    if (!at->second) return std::nullopt;
    frame_of.push_back(&*at->second);
  }
  std::vector<SequenceResult> results(plan.rows.size());
  parallel_for(threads, results.size(), [&](std::size_t n) {
    const SequenceRow& row = plan.rows[n];
    results[n].row = row;
    if (row.task == SequenceTask::undamaged) return;
    results[n].theory = sequence_theory(*frame_of[n], row);
    results[n].bound_cycles = reaction_bound(*frame_of[n], row);
  });
  std::vector<ExperimentRow<SequenceCounts>> rows;
  SequenceProgress progress;
  for (const SequenceRow& row : plan.rows) {
    rows.push_back({row.blocks(), {}, {}});
    progress.all += row.blocks().count();
  }
  ExperimentRun run{.threads = threads};
  run.interrupted = [&] {
    ++progress.done;
    if (report) report(progress);
    return false;
  };
  run_experiment(rows, run, [&](std::size_t row, std::uint64_t block) {
    return count_sequence(*frame_of[row], plan.rows[row], plan.seed, block);
  });
  for (std::size_t n = 0; n < results.size(); ++n) {
    SequenceResult& result = results[n];
    result.counts = rows[n].counts;
    const auto events = static_cast<long double>(result.counts.events);
    const long double share = result.theory.value_or(0);
    set_sigma(result, share * events, share * (1 - share) * events);
  }
  return with_sums(results);
}

}  // namespace biss::lab
