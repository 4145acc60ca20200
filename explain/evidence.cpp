#include "explain/evidence.hpp"

#include <algorithm>
#include <cmath>

#include "decode/polarity.hpp"
#include "decode/times.hpp"
#include "explain/pricer.hpp"

namespace biss::explain {

namespace {

using decode::Cycle;
using decode::LevelChange;
using decode::Rule;
using wire::Level;

// A gap is a multiple of the step within a share of the step.
constexpr std::int64_t grid_tolerance = 12;
// Gaps longer than this many steps are not evidence of the step.
constexpr std::int64_t grid_steps = 40;
constexpr std::size_t gaps_kept = 4096;
constexpr std::size_t rows_kept = 4096;
constexpr std::size_t edges_kept = std::size_t{1} << 18U;

bool lies_on(Picoseconds gap, Picoseconds step) {
  const std::int64_t off = (gap.count + step.count / 2) % step.count - step.count / 2;
  return grid_tolerance * std::max(off, -off) <= step.count;
}

// A level of a clock that is sampled lasts a step more at times.
bool varies_by(Picoseconds step, const std::vector<Picoseconds>& levels) {
  std::array<std::size_t, 16> lengths{};
  for (const Picoseconds level : levels) {
    const std::int64_t steps = decode::periods_in(level, step);
    if (steps < std::ssize(lengths)) ++lengths[static_cast<std::size_t>(steps)];
  }
  std::size_t in_a_row = 0;
  for (std::size_t steps = 1; steps < lengths.size() && in_a_row < 2; ++steps) {
    const bool occurs = lengths[steps] >= 3 && 400 * lengths[steps] > levels.size();
    in_a_row = occurs ? in_a_row + 1 : 0;
  }
  return in_a_row == 2;
}

// The smallest step of all edge times, if the capture has sampled the lines. Nothing if the edges do
// not lie on a coarse grid.
//
// A file of changes does not give its sample period. If all gaps between edges are whole multiples of
// the smallest one, and one level of MA lasts a step more at times, that gap is the sample period.
// (High and low alone may differ by a step: an uneven duty does that.)
std::optional<Picoseconds> sample_step(std::span<const wire::Edge> edges,
                                       const decode::Lines& lines) {
  std::vector<Picoseconds> gaps;
  // How long MA was low and high.
  std::array<std::vector<Picoseconds>, 2> ma_levels;
  std::optional<Picoseconds> last;
  std::optional<Picoseconds> last_ma;
  std::size_t slo_edges = 0;
  for (const auto& [time, line, level] : edges) {
    if (line != lines.ma && line != lines.slo) continue;
    if (gaps.size() < gaps_kept) {
      if (last && *last < time) gaps.push_back(decode::elapsed(*last, time));
      last = time;
      if (line != lines.ma) ++slo_edges;
    }
    if (line != lines.ma) continue;
    auto& levels = ma_levels[level == Level::high ? 0 : 1];
    if (last_ma && levels.size() < gaps_kept / 2) {
      levels.push_back(decode::elapsed(*last_ma, time));
    }
    last_ma = time;
  }
  if (gaps.size() < 64 || ma_levels[0].size() < 16 || slo_edges < 16) return std::nullopt;
  const Picoseconds step = *std::min_element(gaps.begin(), gaps.end());
  std::erase_if(gaps, [step](Picoseconds gap) { return gap > grid_steps * step; });
  const auto on = std::count_if(gaps.begin(), gaps.end(),
                                [step](Picoseconds gap) { return lies_on(gap, step); });
  const bool found = gaps.size() >= 64 && 100 * on >= 97 * std::ssize(gaps) &&
                     (varies_by(step, ma_levels[0]) || varies_by(step, ma_levels[1]));
  return found ? std::optional(step) : std::nullopt;
}

bool warns(const Frame& frame) {
  const auto channels = frame.channels();
  return std::any_of(channels.begin(), channels.end(), [](const auto& each) { return !each.nW; });
}

// The limits of the master, the encoder and its times. The other rules of `check` have causes of
// their own.
constexpr Rule limit_rules[] = {Rule::ack_shortest,   Rule::ack_longest,  Rule::clock_max,
                                Rule::clock_min,      Rule::clock_change, Rule::cycle_min,
                                Rule::duty,           Rule::ma_level,     Rule::timeout_shortest,
                                Rule::timeout_longest};

// The changes of a run from this time on.
void push(decode::LineHistory& line, const decode::LineRun& run, Picoseconds from, bool inverted) {
  const auto begin = std::lower_bound(run.times.begin(), run.times.end(), from.count);
  auto index = static_cast<std::size_t>(begin - run.times.begin());
  const auto level = [&](std::size_t i) { return decode::seen_as(run.level(i), inverted); };
  if (index != 0) line.restart(level(index - 1), Picoseconds{run.times[index - 1]});
  for (; index < run.times.size(); ++index) {
    line.push_recent({Picoseconds{run.times[index]}, level(index)}, edges_kept);
  }
}

std::vector<Cycle> cycles_of(const ObserverSetup& setup, std::span<const wire::Edge> beginning) {
  const std::vector<wire::Edge> edges = decode::first_edges(setup.lines, beginning);
  std::vector<Cycle> cycles;
  DeviceTiming timing = setup.timing;
  timing.timeout = setup.timeout;
  decode::Decoder decoder(decode::CycleReader(setup.format, timing, setup.margin),
                          [&](const Cycle& cycle) {
                            if (!is_cut(cycle.status)) cycles.push_back(cycle);
                          });
  decoder.push(edges, setup.lines);
  decoder.finish(edges.empty() ? Picoseconds{} : edges.back().time);
  return cycles;
}

}  // namespace

Observer::Observer(const ObserverSetup& setup, std::span<const wire::Edge> beginning)
    : setup_(setup),
      check_({.format = setup.format,
              .timing = setup.timing,
              // Also shows a sign of life of 6 bits that begins again with 0.
              .renishaw_cables = true,
              .compensated = setup.margin.compensated,
              .resolution = setup.margin.resolution}) {
  for (std::size_t k = 0; setup.format && k < setup.format->channel_count; ++k) {
    plausibility_.emplace_back(*setup.format, k);
  }
  evidence_.resolution = setup.margin.resolution;
  if (evidence_.resolution.count == 0) {
    evidence_.resolution = sample_step(beginning, setup.lines).value_or(Picoseconds{});
  }
  evidence_.has_format = setup.format.has_value();
  evidence_.usual = usual_of(cycles_of(setup, beginning), setup.format);
  pricer_ = std::make_unique<Pricer>(setup.format, evidence_.resolution, evidence_.usual);
}

Observer::~Observer() = default;

// Edges from this time on are still needed.
Picoseconds Observer::needed_from() const {
  return waiting_.empty() ? last_end_ : waiting_.front().second.time;
}

void Observer::take(std::span<const wire::Edge> edges) {
  for (const wire::Edge& edge : edges) {
    if (edge.line == setup_.lines.ma) {
      ++evidence_.ma_edges;
      ma_.push_recent({edge.time, decode::seen_as(edge.level, setup_.lines.ma_inverted)},
                      edges_kept);
    } else if (edge.line == setup_.lines.slo) {
      ++evidence_.slo_edges;
      slo_.push_recent({edge.time, decode::seen_as(edge.level, setup_.lines.slo_inverted)},
                       edges_kept);
    }
  }
}

void Observer::take(const decode::PairRun& run) {
  evidence_.ma_edges += run.ma.times.size();
  evidence_.slo_edges += run.slo.times.size();
  push(ma_, run.ma, needed_from(), setup_.lines.ma_inverted);
  push(slo_, run.slo, needed_from(), setup_.lines.slo_inverted);
}

void Observer::add(std::uint64_t number, const Cycle& cycle) {
  last_end_ = decode::shifted(cycle.time, cycle.clocked);
  ++evidence_.statuses[static_cast<std::size_t>(cycle.status)];
  const std::uint64_t jumps = check_.faults(Rule::sign_of_life);
  check_.push(number, cycle);
  if (check_.faults(Rule::sign_of_life) != jumps) life_jumps_.add(number, cycle.time);
  if (waiting_.empty() && !is_cut(cycle.status) && pricer_->is_plain(cycle)) {
    process({number, cycle}, std::nullopt, false);
  } else {
    waiting_.emplace_back(number, cycle);
  }
}

void Observer::settle() {
  while (!waiting_.empty()) {
    const Cycle& cycle = waiting_.front().second;
    const bool has_next = waiting_.size() > 1;
    if (!has_next && !is_cut(cycle.status) && !pricer_->is_plain(cycle)) break;
    process(waiting_.front(), has_next ? std::optional(waiting_[1].second.time) : std::nullopt,
            false);
    waiting_.pop_front();
  }
  ma_.forget(ma_.from(needed_from()));
  slo_.forget(slo_.from(needed_from()));
}

const Evidence& Observer::finish(Picoseconds end_time) {
  settle();
  for (const Waiting& each : waiting_) {
    process(each, std::max(end_time, each.second.time), true);
  }
  waiting_.clear();
  check_.finish();
  for (const Rule rule : limit_rules) {
    const decode::RuleResult result = check_.result(rule);
    const bool pauses = rule == Rule::clock_change && evidence_.count(RequestKind::paused) != 0;
    if (result.verdict == decode::Verdict::fail && !pauses)
      evidence_.limits.push_back({rule, result});
  }
  evidence_.life_zeros = check_.faults(Rule::counter_values);
  move_good(RequestKind::life_jump, life_jumps_);
  Sightings implausible;
  for (const Plausibility& each : plausibility_) {
    evidence_.late_turns = std::max(evidence_.late_turns, each.longest());
    evidence_.steps.add(each.steps());
    implausible.add(each.turns());
  }
  implausible.add(evidence_.steps);
  move_good(RequestKind::implausible, implausible);
  for (Row& row : evidence_.rows) row.count *= static_cast<double>(stride_);
  if (plain_ != 0) {
    Row& row = evidence_.rows.emplace_back();
    row.count = static_cast<double>(plain_);
    row.likely[static_cast<std::size_t>(RequestKind::ok)] = 1;
    row.likely[static_cast<std::size_t>(RequestKind::foreign)] = 1.0F / 256;
  }
  return evidence_;
}

// Without a format the decoder cannot detect that the capture ends within a request.
bool Observer::is_cut_at_end(const Cycle& cycle, Picoseconds end_of_capture) const {
  const Picoseconds end = decode::shifted(cycle.time, cycle.clocked);
  return evidence_.cycles != 0 && cycle.rising_edges < evidence_.usual.clocks &&
         decode::elapsed(end, end_of_capture) < 2 * evidence_.usual.period;
}

void Observer::process(const Waiting& waiting, std::optional<Picoseconds> next, bool last) {
  const auto& [number, cycle] = waiting;
  if (is_cut(cycle.status)) return;
  if (last && next && is_cut_at_end(cycle, *next)) return;
  ++evidence_.cycles;
  if (is_good(cycle.status)) ++evidence_.good;
  for (Plausibility& each : plausibility_) each.push(number, cycle);
  note_frame(number, cycle);
  if (pricer_->is_plain(cycle)) {
    note_times(cycle, true);
    pricer_->learn(cycle);
    silence_ = 0;
    ++plain_;
    evidence_.kinds[0].add(number, cycle.time);
    return;
  }
  note_times(cycle, false);
  if (cycle.status == CycleStatus::unknown_level) return;
  const Prices prices =
      pricer_->read(decode::edges_of(cycle, number, ma_, slo_, next.value_or(last_end_), last),
                    unusual_ % stride_ == 0);
  if (pricer_->position_is_likely()) ++evidence_.likely_positions;
  evidence_.pulses_on_ma += pricer_->ma_pulses();
  evidence_.pulses_on_slo += pricer_->slo_pulses();
  note_unusual(number, cycle, prices);
}

void Observer::note_unusual(std::uint64_t number, const Cycle& cycle, const Prices& prices) {
  // The cheapest kind of the request. The last two kinds, a foreign word and a literal, are used
  // only if no other kind is possible.
  auto cheapest = std::min_element(prices.begin(), prices.end() - 2);
  if (*cheapest == impossible) cheapest = prices.end() - 1;
  const auto kind = static_cast<RequestKind>(cheapest - prices.begin());
  evidence_.kinds[static_cast<std::size_t>(kind)].add(number, cycle.time);
  const bool cut = cycle.status == CycleStatus::truncated && kind != RequestKind::zeros;
  if (cut && pricer_->shows_error()) evidence_.cut_errors.add(number, cycle.time);
  silence_ = kind == RequestKind::silent ? silence_ + 1 : 0;
  if (silence_ == 1) ++evidence_.silent_runs;
  evidence_.longest_silence = std::max(evidence_.longest_silence, silence_);
  if (kind == RequestKind::smeared) evidence_.smear = std::max(evidence_.smear, pricer_->smear());
  add_row(prices);
}

void Observer::add_row(const Prices& prices) {
  if (unusual_++ % stride_ != 0) return;
  if (evidence_.rows.size() == rows_kept) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < rows_kept; i += 2) evidence_.rows[kept++] = evidence_.rows[i];
    evidence_.rows.resize(kept);
    stride_ *= 2;
  }
  const float least = *std::min_element(prices.begin(), prices.end());
  Row row;
  for (std::size_t k = 0; k < kind_count; ++k) row.likely[k] = std::exp2(least - prices[k]);
  evidence_.rows.push_back(row);
}

// Moves frames that were plain to a kind that only the whole capture shows.
void Observer::move_good(RequestKind to, const Sightings& seen) {
  const std::uint64_t count = std::min(seen.count, plain_);
  if (count == 0) return;
  plain_ -= count;
  evidence_.kinds[0].count -= count;
  evidence_.kinds[static_cast<std::size_t>(to)].add(seen);
  Row row;
  row.likely[static_cast<std::size_t>(to)] = 1;
  row.count = static_cast<double>(count) / static_cast<double>(stride_);
  evidence_.rows.push_back(row);
}

void Observer::note_frame(std::uint64_t number, const Cycle& cycle) {
  if (cycle.ack && cycle.line_delay) ++evidence_.answered;
  if (is_good(cycle.status)) ++evidence_.passed;
  const BitView raw = cycle.raw.view();
  if (raw.size_bits() > 3) {
    ++evidence_.last_bits[static_cast<std::size_t>(raw.word(raw.size_bits() - 2, 2))];
  }
  const std::size_t stop = 2 + std::size_t{evidence_.usual.payload_bits};
  const bool short_of_bits =
      (cycle.status == CycleStatus::ack_range || cycle.status == CycleStatus::unchecked) &&
      raw.size_bits() < stop;
  if (cycle.status == CycleStatus::truncated || short_of_bits) {
    ++evidence_.truncated;
    if (cycle.ack && cycle.period) {
      evidence_.truncated_ack_clocks.add(decode::periods_in(*cycle.ack, *cycle.period));
    }
    if (raw.size_bits() < stop) {
      evidence_.missing_bits.add(static_cast<std::int64_t>(stop - raw.size_bits()));
    }
    if (raw.size_bits() != 0 && !raw[raw.size_bits() - 1]) ++evidence_.truncated_low;
  }
  if (cycle.status == CycleStatus::crc && raw.size_bits() > stop && stop > 3) {
    ++evidence_.failed_checks;
    if (!raw[stop - 1]) ++evidence_.last_bit_low;
    if (raw[stop]) ++evidence_.stops_high;
  }
  if (cycle.frame && warns(*cycle.frame)) evidence_.warnings.add(number, cycle.time);
}

void Observer::note_times(const Cycle& cycle, bool good) {
  evidence_.rising_edges.add(static_cast<std::int64_t>(cycle.rising_edges));
  if (cycle.period) evidence_.period.add(cycle.period->count);
  if (cycle.line_delay) evidence_.line_delay.add(cycle.line_delay->count);
  if (const auto rest = pricer_->rest_before(cycle)) {
    (good ? evidence_.good_rest : evidence_.rest_of_bad).add(rest->count);
  }
  if (!good) return;
  if (cycle.release) evidence_.release.add(cycle.release->count);
  if (!cycle.ack || !cycle.period) return;
  const std::int64_t ack_clocks = decode::periods_in(*cycle.ack, *cycle.period);
  evidence_.ack_clocks.add(ack_clocks);
  if (!cycle.frame) return;
  const std::int64_t needed = 1 + ack_clocks + 3 + std::int64_t{evidence_.usual.payload_bits};
  evidence_.extra_clocks.add(std::int64_t{cycle.rising_edges} - needed);
}

}  // namespace biss::explain
