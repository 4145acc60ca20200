#include "explain/evidence.hpp"

#include <algorithm>
#include <cmath>

#include "decode/polarity.hpp"
#include "decode/times.hpp"

namespace biss::explain {

namespace {

using decode::Cycle;
using decode::LevelChange;
using decode::Rule;
using wire::Level;

// A gap is a multiple of the step within a share of the step.
constexpr std::int64_t grid_tolerance = 12;
// Gaps longer than this many steps are no evidence of the step.
constexpr std::int64_t grid_steps = 40;
constexpr std::size_t rows_kept = 4096;

bool lies_on(Picoseconds gap, Picoseconds step) {
  const std::int64_t off = (gap.count + step.count / 2) % step.count - step.count / 2;
  return grid_tolerance * std::max(off, -off) <= step.count;
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
void push(decode::LineChanges& line, const decode::LineRun& run, Picoseconds from, bool inverted) {
  const auto begin = std::lower_bound(run.times.begin(), run.times.end(), from.count);
  auto index = static_cast<std::size_t>(begin - run.times.begin());
  const auto level = [&](std::size_t i) {
    return decode::seen_as(run.first_high == (i % 2 == 0) ? Level::high : Level::low, inverted);
  };
  if (index != 0) {
    line.changes.clear();
    line.before = level(index - 1);
  }
  for (; index < run.times.size(); ++index) {
    line.push({Picoseconds{run.times[index]}, level(index)});
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

void SampleGrid::push(wire::Edge edge, wire::LineIndex ma) {
  if (gaps_.size() < gaps_kept) {
    if (last_ && *last_ < edge.time) gaps_.push_back(decode::elapsed(*last_, edge.time));
    last_ = edge.time;
    if (edge.line != ma) ++slo_edges_;
  }
  if (edge.line != ma) return;
  auto& levels = ma_levels_[edge.level == wire::Level::high ? 0 : 1];
  if (last_ma_ && levels.size() < gaps_kept / 2) {
    levels.push_back(decode::elapsed(*last_ma_, edge.time));
  }
  last_ma_ = edge.time;
}

// A level of a clock that is sampled lasts a step more at times.
bool SampleGrid::varies_by(Picoseconds step) const {
  for (const auto& levels : ma_levels_) {
    std::array<std::size_t, 16> lengths{};
    for (const Picoseconds level : levels) {
      const std::int64_t steps = decode::periods_in(level, step);
      if (steps < std::ssize(lengths)) ++lengths[static_cast<std::size_t>(steps)];
    }
    std::size_t in_a_row = 0;
    for (std::size_t steps = 1; steps < lengths.size(); ++steps) {
      const bool occurs = lengths[steps] >= 3 && 400 * lengths[steps] > levels.size();
      in_a_row = occurs ? in_a_row + 1 : 0;
      if (in_a_row == 2) return true;
    }
  }
  return false;
}

std::optional<Picoseconds> SampleGrid::step() const {
  if (gaps_.size() < 64 || ma_levels_[0].size() < 16 || slo_edges_ < 16) return std::nullopt;
  const Picoseconds step = *std::min_element(gaps_.begin(), gaps_.end());
  std::size_t on = 0;
  std::size_t judged = 0;
  for (const Picoseconds gap : gaps_) {
    if (gap > grid_steps * step) continue;
    ++judged;
    if (lies_on(gap, step)) ++on;
  }
  if (judged < 64 || 100 * on < 97 * judged || !varies_by(step)) return std::nullopt;
  return step;
}

Observer::Observer(const ObserverSetup& setup, std::span<const wire::Edge> beginning)
    : setup_(setup),
      check_({.format = setup.format,
              .timing = setup.timing,
              // Shows too a sign of life of 6 bits that begins again with 0.
              .renishaw_cables = true,
              .compensated = setup.margin.compensated,
              .resolution = setup.margin.resolution}) {
  for (std::size_t k = 0; setup.format && k < setup.format->channel_count; ++k) {
    plausibility_.emplace_back(*setup.format, k);
  }
  SampleGrid grid;
  for (const wire::Edge& edge : beginning) {
    if (edge.line == setup.lines.ma || edge.line == setup.lines.slo)
      grid.push(edge, setup.lines.ma);
  }
  evidence_.resolution = setup.margin.resolution;
  if (evidence_.resolution.count == 0) evidence_.resolution = grid.step().value_or(Picoseconds{});
  evidence_.has_format = setup.format.has_value();
  evidence_.usual = usual_of(cycles_of(setup, beginning), setup.format);
  pricer_.emplace(setup.format, evidence_.resolution, evidence_.usual);
}

// Edges from this time on are still needed.
Picoseconds Observer::needed_from() const {
  return waiting_.empty() ? last_end_ : waiting_.front().second.time;
}

void Observer::take(std::span<const wire::Edge> edges) {
  for (const wire::Edge& edge : edges) {
    if (edge.line == setup_.lines.ma) {
      ++evidence_.ma_edges;
      ma_.push({edge.time, decode::seen_as(edge.level, setup_.lines.ma_inverted)});
    } else if (edge.line == setup_.lines.slo) {
      ++evidence_.slo_edges;
      slo_.push({edge.time, decode::seen_as(edge.level, setup_.lines.slo_inverted)});
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
  ma_.forget_before(needed_from());
  slo_.forget_before(needed_from());
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
  if (plain_ != 0) {
    Row row;
    row.count = static_cast<double>(plain_);
    row.likely[static_cast<std::size_t>(RequestKind::ok)] = 1;
    row.likely[static_cast<std::size_t>(RequestKind::foreign)] = 1.0F / 256;
    evidence_.rows.push_back(row);
  }
  for (Row& row : evidence_.rows) {
    if (&row != &evidence_.rows.back() || plain_ == 0) row.count *= static_cast<double>(stride_);
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
  const Picoseconds limit = next.value_or(last_end_);
  const Picoseconds after =
      decode::shifted(decode::shifted(cycle.time, cycle.clocked), picoseconds(1));
  const auto before = slo_.between(Picoseconds{INT64_MIN}, cycle.time);
  const Prices prices =
      pricer_->read({.cycle = cycle,
                     .number = number,
                     .ma = ma_.between(cycle.time, after),
                     .ma_after = ma_.between(after, limit),
                     .slo_before = before.empty() ? slo_.before : before.back().level,
                     .slo = slo_.between(cycle.time, limit),
                     .limit = limit,
                     .last_of_capture = last},
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
