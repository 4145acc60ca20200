#include "decode/decoder.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "decode/cycle_rules.hpp"
#include "decode/limits.hpp"
#include "decode/times.hpp"

namespace biss::decode {

namespace {

using wire::Level;

// The slowest legal clock, and a little more.
constexpr Picoseconds longest_period = microseconds(16);
constexpr Picoseconds period_when_unknown = period_of(biss_clock_min);

// Two line delays of one line may differ by a fourth of a period.
constexpr std::int64_t usual_delay_share = 4;

bool lacks_stop(const Cycle& cycle) { return cycle.frame && !cycle.frame->stop_seen; }

}  // namespace

void Decoder::push_ma(LevelChange change) {
  if (change.level == ma_level_) return;
  const bool initial = ma_level_ == Level::unknown && ma_.empty() && !idle_known_;
  ma_level_ = change.level;
  if (initial) {
    begin_time_ = change.time;
    return;
  }
  if (skipping_) {
    skip(change.time);
    if (skipping_) return;
  }
  ma_.push_back(change);
  // Nearly every edge is the next one of the current cycle.
  const bool next_clock = scanned_ + 1 == ma_.size() && scanned_ != 0 &&
                          scanned_ < max_cycle_edges && scanned_ % faster_clock_step != 0 &&
                          elapsed(ma_[scanned_ - 1].time, change.time) <= pause_;
  if (next_clock) {
    ++scanned_;
  } else {
    drain(false);
  }
}

void Decoder::push_slo(LevelChange change) {
  // Without a current request only the level counts.
  if (ma_.empty() && held_.empty()) slo_.forget_before(change.time);
  slo_.push(change);
}

void Decoder::push(std::span<const wire::Edge> edges, const Lines& lines) {
  for (const wire::Edge& edge : edges) {
    if (edge.line == lines.ma) {
      push_ma({edge.time, seen_as(edge.level, lines.ma_inverted)});
    } else if (edge.line == lines.slo) {
      push_slo({edge.time, seen_as(edge.level, lines.slo_inverted)});
    }
  }
}

void Decoder::push(const PairRun& run, RunPlace from, RunPlace to,
                   std::span<const CleanCycle> clean) {
  RunPlace at = from;
  for (const CleanCycle& cycle : clean) {
    // A frame without a checksum may be a part of a cycle.
    if (reader_.knows_timeout() && !reader_.checked_payload_bits()) break;
    if (at != cycle.begin || !waits()) {
      // The edge that begins the cycle shows whether everything before it is read.
      const RunPlace begun{cycle.begin.ma + 1, cycle.begin.slo};
      push_mixed(run, at, begun);
      at = begun;
      if (!waits_since_this_edge()) continue;
    }
    // All edges before it are read, so the cycles that may continue are known. The clock of STOP
    // may come after a pause.
    if (may_join(cycle.reading, Picoseconds{run.ma.times[cycle.end.ma]})) continue;
    emit_clean(cycle, run);
    at = cycle.end;
  }
  push_mixed(run, at, to);
}

// Whether a clean cycle may be a part of another one: together with the held cycles, or with the
// next cycle.
bool Decoder::may_join(const CycleReading& reading, Picoseconds next) const {
  if (is_right(reading)) return false;
  const Picoseconds last_edge = shifted(reading.cycle.time, reading.cycle.clocked);
  return !held_.empty() || may_wait(reading.cycle, elapsed(last_edge, next));
}

// Pushes the changes in the order of their times; at equal times, the change of SLO first.
void Decoder::push_mixed(const PairRun& run, RunPlace from, RunPlace to) {
  while (from.ma < to.ma || from.slo < to.slo) {
    const bool slo_next =
        from.ma == to.ma || (from.slo < to.slo && run.slo.times[from.slo] <= run.ma.times[from.ma]);
    if (slo_next) {
      const LevelChange change{Picoseconds{run.slo.times[from.slo]}, run.slo.level(from.slo)};
      const bool none = from.slo == 0 && slo_.level_before(slo_.size()) == change.level;
      if (!none) push_slo(change);
      ++from.slo;
    } else {
      push_ma({Picoseconds{run.ma.times[from.ma]}, run.ma.level(from.ma)});
      ++from.ma;
    }
  }
}

// MA rests, and all requests before have been emitted.
bool Decoder::waits() const {
  return idle_known_ && !skipping_ && scanned_ == 0 && ma_.empty() && ma_level_ == Level::high;
}

// The last edge was a falling one of MA, and may begin a request; all before it has been emitted.
bool Decoder::waits_since_this_edge() const {
  return idle_known_ && !skipping_ && scanned_ == 0 && ma_.size() == 1;
}

void Decoder::emit_clean(const CleanCycle& clean, const PairRun& run) {
  const Cycle& cycle = clean.reading.cycle;
  usual_clocks_ = cycle.clocked.count / cycle.period->count;
  deliver_held();
  ma_.clear();
  ma_level_ = Level::high;
  const bool high = (clean.end.slo - clean.begin.slo) % 2 == 0;
  slo_.restart(high ? Level::high : Level::low, Picoseconds{run.slo.times[clean.end.slo - 1]});
  deliver(cycle);
  doubt_.reset();
}

void Decoder::finish(Picoseconds end_time) {
  end_time_ = end_time;
  drain(true);
  deliver_held();
  hand_on_unjudged(nullptr);
}

void Decoder::drain(bool at_end) {
  while (find_begin(at_end) && take_cycle(at_end)) {
  }
}

bool Decoder::find_begin(bool at_end) {
  if (scanned_ != 0) return true;
  if (idle_known_) drop_return_to_idle();
  if (ma_.empty() || (ma_.size() < lookahead_edges && !at_end)) return false;
  period_ = period_ahead();
  pause_ = pause_ahead();
  if (!idle_known_ && 2 * elapsed(begin_time_, ma_.front().time) >= 3 * period_) {
    // The capture begins with an idle gap: the first edge is a beginning, not the middle.
    idle_known_ = true;
    drop_return_to_idle();
    if (ma_.empty()) return false;
  }
  scanned_ = 1;
  return true;
}

// A rising edge after a cycle's end is MA going back to idle (CDM = 1), not a clock.
void Decoder::drop_return_to_idle() {
  const auto begin = std::find_if(ma_.begin(), ma_.end(), [](const LevelChange& change) {
    return change.level != Level::high;
  });
  ma_.erase(ma_.begin(), begin);
}

Picoseconds Decoder::period_ahead() const {
  std::array<Picoseconds, lookahead_edges> periods{};
  std::size_t count = 0;
  // From rise to rise and from fall to fall, so that an uneven duty does not matter.
  for (std::size_t i = 2; i < ma_.size() && i < lookahead_edges; ++i) {
    const Picoseconds period = elapsed(ma_[i - 2].time, ma_[i].time);
    if (period <= longest_period) periods[count++] = period;
  }
  if (count == 0) return period_when_unknown;
  const auto middle = periods.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(periods.begin(), middle, periods.begin() + static_cast<std::ptrdiff_t>(count));
  return std::max(*middle, picoseconds(1));
}

// The longest of the next gaps of the clock, and a little more.
Picoseconds Decoder::pause_ahead() const {
  Picoseconds longest{};
  for (std::size_t i = 1; i < ma_.size() && i < lookahead_edges; ++i) {
    const Picoseconds gap = elapsed(ma_[i - 1].time, ma_[i].time);
    if (gap < period_) longest = std::max(longest, gap);
  }
  return longest + period_ / pause_share;
}

// Emits the cycle at the front when its end is known. False: more edges are needed.
bool Decoder::take_cycle(bool at_end) {
  for (; scanned_ < ma_.size(); ++scanned_) {
    if (scanned_ == max_cycle_edges) {
      give_up();
      return false;
    }
    if (scanned_ >= faster_clock_edges && scanned_ % faster_clock_step == 0) {
      follow_clock(ma_[scanned_ - faster_clock_edges].time, ma_[scanned_].time);
    }
    if (begins_with_pulse()) {
      emit(read(0, ma_[scanned_].time, false));
      return true;
    }
    const Picoseconds gap = elapsed(ma_[scanned_ - 1].time, ma_[scanned_].time);
    // A time with an unknown level is not an idle gap.
    if (gap <= pause_ || ma_[scanned_ - 1].level == Level::unknown) continue;
    const std::size_t next_fall = scanned_ + (ma_[scanned_].level == Level::high ? 1 : 0);
    const bool last = next_fall >= ma_.size();
    if (last && !at_end) return false;
    const Picoseconds next = last ? end_time_ : ma_[next_fall].time;
    if (!is_long(gap)) {
      const auto before = last ? std::nullopt : read_before_pause(next);
      if (!before) continue;
      emit(*before);
      return true;
    }
    const CycleReading reading = read(0, next, last);
    const bool doubtful = gap <= 4 * period_;
    if (doubtful && repeats(reading)) {
      usual_clocks_ = clocks_between(0, doubt_->edges, *reading.cycle.period);
      emit_before_doubt();
      return true;
    }
    if (emit_before_frame(reading, next, last)) return true;
    if (doubtful && !is_over(reading)) {
      doubt_ = {.edges = scanned_, .reading = reading};
      continue;
    }
    emit(reading);
    return true;
  }
  if (!at_end) return false;
  const CycleReading reading = read(0, end_time_, true);
  if (!emit_before_frame(reading, end_time_, true)) emit(reading);
  return true;
}

// The edges from `begin` to scanned_ as a cycle.
CycleReading Decoder::read(std::size_t begin, Picoseconds next, bool last_of_capture) {
  const auto edges = std::span<const LevelChange>(ma_).first(scanned_).subspan(begin);
  return reader_.read({.ma = edges,
                       .begins_idle = begin != 0 || idle_known_,
                       .limit = std::min(next, shifted(edges.back().time, slo_matters)),
                       .last_of_capture = last_of_capture,
                       .usual_clocks = usual_rises_},
                      slo_);
}

// Whether the gap after scanned_ is the cycle's end, and not a few missing edges.
bool Decoder::is_over(const CycleReading& reading) const {
  if (reading.complete) return true;
  const bool glitch = scanned_ == 2 && 4 * elapsed(ma_[0].time, ma_[1].time) < period_;
  const Picoseconds period = reading.cycle.period.value_or(period_);
  return glitch || (usual_clocks_ != 0 && clocks_between(0, scanned_, period) + 1 >= usual_clocks_);
}

// If no cycle has given the usual length yet, two pieces of equal length are two cycles.
bool Decoder::repeats(const CycleReading& reading) const {
  if (usual_clocks_ != 0 || !reading.cycle.period || !doubt_) return false;
  const std::int64_t before = clocks_between(0, doubt_->edges, *reading.cycle.period);
  const std::int64_t after = clocks_between(doubt_->edges, scanned_, *reading.cycle.period);
  return before >= 2 && std::abs(after - before) <= 1;
}

// Ends the cycle before scanned_ if a frame with a correct checksum follows there.
bool Decoder::emit_before_frame(const CycleReading& reading, Picoseconds next,
                                bool last_of_capture) {
  if (reading.cycle.frame) return false;
  if (frame_after_doubt(next, last_of_capture)) {
    emit_before_doubt();
    return true;
  }
  if (!frame_after_unknown(next, last_of_capture)) return false;
  scanned_ = 2;
  emit(read(0, ma_[scanned_].time, false));
  return true;
}

// The previous cycle must not be shorter: if only the first few edges of a cycle are missing, the
// rest of it still reads well.
bool Decoder::frame_after_doubt(Picoseconds next, bool last_of_capture) {
  if (!doubt_) return false;
  const std::size_t begin = doubt_->edges + (ma_[doubt_->edges].level == Level::high ? 1 : 0);
  return begin < scanned_ &&
         clocks_between(0, doubt_->edges, period_) >= clocks_between(begin, scanned_, period_) &&
         proves_a_cycle(begin, next, last_of_capture);
}

// The capture was switched off while MA was idle, and on again just before a request.
bool Decoder::frame_after_unknown(Picoseconds next, bool last_of_capture) {
  return scanned_ >= 4 && ma_[0].level == Level::unknown && ma_[1].level == Level::high &&
         proves_a_cycle(2, next, last_of_capture);
}

// Whether a frame with a correct checksum begins at this edge.
bool Decoder::proves_a_cycle(std::size_t begin, Picoseconds next, bool last_of_capture) {
  const Cycle cycle = read(begin, next, last_of_capture).cycle;
  return cycle.frame && std::any_of(cycle.crc_ok.begin(), cycle.crc_ok.end(),
                                    [](const auto& crc_ok) { return crc_ok.has_value(); });
}

// The first low of MA is much too short for a clock: a pulse just before a request.
bool Decoder::begins_with_pulse() const {
  return scanned_ == 2 && ma_.size() > 3 && idle_known_ && ma_[0].level == Level::low &&
         pulse_share * elapsed(ma_[0].time, ma_[1].time) < period_ &&
         pulse_share * elapsed(ma_[2].time, ma_[3].time) >= period_;
}

// The cycle before scanned_, if the encoder went idle in the short gap before the next falling edge
// of MA: that edge begins a request.
std::optional<CycleReading> Decoder::read_before_pause(Picoseconds next) {
  const Picoseconds last = ma_[scanned_ - 1].time;
  // A change at the time of the next request belongs to that request.
  const std::size_t end = slo_.from(next);
  const std::size_t change = std::min(slo_.after(ma_[scanned_].time), end);
  if (change == 0 || slo_[change - 1].time <= last) return std::nullopt;
  if (slo_.level_before(change) != Level::high || slo_.level_before(end) != Level::high) {
    return std::nullopt;
  }
  CycleReading reading = read(0, next, false);
  if (!reading.cycle.line_delay) return std::nullopt;
  // A change by the last clock comes a line delay later; a change by the next clock comes after
  // that clock.
  const Picoseconds moved = *reading.cycle.line_delay + *reading.cycle.period / 4 + reading.jitter;
  const Picoseconds rise = slo_[change - 1].time;
  if (rise <= shifted(last, moved) || shifted(rise, reading.jitter) >= ma_[scanned_].time) {
    return std::nullopt;
  }
  return reading;
}

std::int64_t Decoder::clocks_between(std::size_t first, std::size_t end, Picoseconds period) const {
  return elapsed(ma_[first].time, ma_[end - 1].time).count / period.count;
}

// An encoder that takes a pulse of MA for the first clock of a request answers it a clock early. The
// delay of the cycles before shows whether it did.
void Decoder::deliver(const Cycle& cycle) {
  if (is_good(cycle.status)) {
    if (!lacks_stop(cycle)) usual_rises_ = cycle.rising_edges;
    if (cycle.release && cycle.line_delay) {
      const Picoseconds seen = *cycle.release - *cycle.line_delay;
      seen_timeout_ = std::max(seen_timeout_.value_or(seen), seen);
    }
  }
  const bool after_pulse = std::exchange(after_pulse_, cycle.status == CycleStatus::ma_glitch);
  if (!after_pulse || !cycle.line_delay) {
    if (!is_good(cycle.status) || !cycle.line_delay) return hand_on(cycle);
    const Picoseconds off = *cycle.line_delay - usual_delay_.value_or(*cycle.line_delay);
    const auto is_near = [&](Picoseconds time) {
      return std::max(time, -time) <= *cycle.period / usual_delay_share;
    };
    const bool early = is_near(off + *cycle.period);
    const bool late = is_near(off - *cycle.period) && *cycle.line_delay >= *cycle.period;
    if (!std::exchange(steady_delay_, usual_delay_ && is_near(off)) || !(early || late)) {
      usual_delay_ = cycle.line_delay;
      return hand_on(cycle);
    }
    // The encoder has counted a clock more or less than the master before it answered.
    Cycle counted = cycle;
    counted.line_delay = *cycle.line_delay + (early ? *cycle.period : -*cycle.period);
    counted.ack_edge = early ? 0 : 2;
    return hand_on(counted);
  }
  Cycle counted = cycle;
  const Picoseconds one_more = *cycle.line_delay + *cycle.period;
  if (!usual_delay_) {
    counted.line_delay.reset();
  } else if (*cycle.line_delay + one_more < 2 * *usual_delay_) {
    counted.line_delay = one_more;
    counted.ack_edge = 0;
  }
  hand_on(counted);
}

// A cycle whose checksum is in the next cycle waits for it.
void Decoder::hand_on(const Cycle& cycle) {
  if (!reader_.needs_next()) return on_cycle_(cycle);
  hand_on_unjudged(&cycle);
  unjudged_ = cycle;
}

void Decoder::hand_on_unjudged(const Cycle* next) {
  if (!unjudged_) return;
  reader_.judge_by_next(*unjudged_, next);
  on_cycle_(*unjudged_);
  unjudged_.reset();
}

void Decoder::emit_before_doubt() {
  scanned_ = doubt_->edges;
  emit(doubt_->reading);
}

void Decoder::emit(const CycleReading& reading) {
  const Cycle& cycle = reading.cycle;
  if (cycle.period && has_whole_clock(cycle.status)) {
    usual_clocks_ = cycle.pauses != 0 ? std::int64_t{cycle.rising_edges} - 1
                                      : clocks_between(0, scanned_, *cycle.period);
  }
  const Picoseconds last = ma_[scanned_ - 1].time;
  // If MA rises before the next request, it goes back to idle or continues after a pause.
  std::size_t next = scanned_;
  while (next < ma_.size() && ma_[next].level == Level::high) ++next;
  const bool last_of_capture = next == ma_.size();
  const Picoseconds limit = last_of_capture ? std::max(end_time_, last) : ma_[next].time;
  if (is_right(reading)) deliver_held();
  const bool waits =
      !last_of_capture && !is_right(reading) && may_wait(cycle, elapsed(last, limit));
  if (waits || !held_.empty()) {
    held_.push_back({reading, held_edges_.size()});
    held_edges_.insert(held_edges_.end(), ma_.begin(),
                       ma_.begin() + static_cast<std::ptrdiff_t>(next));
    const std::size_t end = held_edges_.size() - next + scanned_;
    if (!emit_joined(end, limit, last_of_capture, waits) && !waits) deliver_held();
  } else {
    deliver(cycle);
  }
  ma_.erase(ma_.begin(), ma_.begin() + static_cast<std::ptrdiff_t>(scanned_));
  const Picoseconds now = ma_.empty() ? last : ma_.front().time;
  slo_.forget_before(held_edges_.empty() ? now : held_edges_.front().time);
  scanned_ = 0;
  idle_known_ = true;
  doubt_.reset();
}

// How long after the last edge of MA the encoder may still be in a request.
Picoseconds Decoder::longest_pause(const Cycle& cycle) const {
  Cycle measured = cycle;
  measured.period = cycle.period.value_or(period_);
  const Picoseconds longest = !reader_.knows_timeout() && seen_timeout_
                                  ? *seen_timeout_
                                  : release_bounds(reader_.timing(), measured).most;
  return longest + release_doubt(measured, longest);
}

// Such a frame is never a part of another one.
bool Decoder::is_right(const CycleReading& reading) const {
  return reading.complete && reader_.checked_payload_bits() && !lacks_stop(reading.cycle) &&
         (reading.cycle.status == CycleStatus::ok ||
          reading.cycle.status == CycleStatus::ack_range);
}

// More clocks could make it a frame.
bool Decoder::may_begin(const Cycle& cycle) const {
  if (usual_rises_ != 0 && cycle.rising_edges >= usual_rises_) return false;
  switch (cycle.status) {
    case CycleStatus::truncated:
    case CycleStatus::no_start:
    case CycleStatus::no_response:
    case CycleStatus::ma_glitch:
    case CycleStatus::ma_clock:
      return true;
    case CycleStatus::unchecked:
      return reader_.knows_timeout();
    case CycleStatus::ok:
      return lacks_stop(cycle);
    default:
      return false;
  }
}

// Whether the cycle may continue with the next request.
bool Decoder::may_wait(const Cycle& cycle, Picoseconds pause) const {
  return (reader_.checked_payload_bits() || reader_.knows_timeout()) &&
         pause <= longest_pause(cycle) && held_edges_.size() + scanned_ < max_cycle_edges &&
         (!held_.empty() || may_begin(cycle));
}

// Delivers the held cycles up to this edge as one, and the cycles before it unchanged.
bool Decoder::emit_joined(std::size_t end, Picoseconds limit, bool last_of_capture, bool waits) {
  const auto edges = std::span<const LevelChange>(held_edges_).first(end);
  const Picoseconds after = elapsed(edges.back().time, limit);
  for (std::size_t k = 0; k + 1 < held_.size(); ++k) {
    const auto span = edges.subspan(held_[k].begin);
    const auto rises = static_cast<std::size_t>(
        std::count_if(span.begin(), span.end(),
                      [](const LevelChange& change) { return change.level == Level::high; }));
    const Cycle& first = held_[k].reading.cycle;
    if (!may_begin(first) || !may_be_request(rises, first)) continue;
    const CycleReading joined =
        reader_.read({.ma = span,
                      .limit = std::min(limit, shifted(edges.back().time, slo_matters)),
                      .last_of_capture = last_of_capture,
                      .usual_clocks = usual_rises_},
                     slo_);
    if (!is_joined(joined, after, waits)) continue;
    held_.resize(k);
    deliver_held();
    usual_clocks_ = static_cast<std::int64_t>(rises) - 1;
    deliver(joined.cycle);
    return true;
  }
  return false;
}

bool Decoder::may_be_request(std::size_t rises, const Cycle& first) const {
  if (usual_rises_ != 0) return rises == usual_rises_;
  const auto payload = reader_.checked_payload_bits();
  if (!payload) return true;
  // LAT, ACK, START, CDS and STOP; a byte of clocks may come after them.
  const std::size_t least = *payload + 5;
  const Picoseconds period = first.period.value_or(period_);
  return rises <= least + 8 + ack_bounds(reader_.timing(), period).max_clocks &&
         (rises >= least || reader_.knows_timeout());
}

bool Decoder::is_joined(const CycleReading& joined, Picoseconds after, bool waits) const {
  const Cycle& cycle = joined.cycle;
  // While no frame shows how many clocks a request has: a pause is shorter than the time between
  // two requests.
  if (is_right(joined)) return usual_rises_ != 0 || 3 * cycle.longest_pause < 2 * after;
  const bool ends = !waits || (reader_.checked_payload_bits() && joined.complete);
  return cycle.pauses != 0 && reader_.knows_timeout() && ends;
}

void Decoder::deliver_held() {
  for (const Held& each : std::exchange(held_, {})) deliver(each.reading.cycle);
  held_edges_.clear();
}

void Decoder::give_up() {
  emit(read(0, ma_[scanned_].time, false));
  last_skipped_ = skipped_mark_ = ma_.back().time;
  skipped_edges_ = 0;
  skipping_ = true;
  ma_.clear();
}

void Decoder::skip(Picoseconds time) {
  skipping_ = !is_long(elapsed(last_skipped_, time));
  last_skipped_ = time;
  if (++skipped_edges_ % faster_clock_edges != 0) return;
  follow_clock(skipped_mark_, time);
  skipped_mark_ = time;
}

// The first edges of a cycle may have been no clock: MA and SLO exchanged, or anything else on MA.
// Measured by them, the gap before the next request would be too short to be seen.
void Decoder::follow_clock(Picoseconds begin, Picoseconds end) {
  const Picoseconds period = elapsed(begin, end) * 2 / std::int64_t{faster_clock_edges};
  if (2 * period >= period_) return;
  period_ = std::max(period, picoseconds(1));
  pause_ = std::min(pause_, period_);
}

}  // namespace biss::decode
