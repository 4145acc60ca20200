#include "decode/decoder.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <utility>

#include "decode/times.hpp"

namespace biss::decode {

namespace {

using wire::Level;

// The slowest legal clock, and a little more.
constexpr Picoseconds longest_period = microseconds(16);
constexpr Picoseconds period_when_unknown = period_of(biss_clock_min);

// SLO is of no interest for longer than this behind the last edge of a cycle: the line delay and a
// period are over by then.
constexpr Picoseconds slo_matters = milliseconds(1);

// Whether such a cycle tells how long the next one will be.
bool is_usual(CycleStatus status) {
  return status != CycleStatus::cut_start && status != CycleStatus::cut_end &&
         status != CycleStatus::ma_glitch && status != CycleStatus::ma_clock &&
         status != CycleStatus::unknown_level;
}

}  // namespace

void Decoder::push_ma(LevelChange change) {
  if (change.level == ma_level_) return;
  const bool initial = ma_level_ == Level::unknown && ma_.empty() && !idle_known_;
  ma_level_ = change.level;
  if (initial) {
    begin_time_ = change.time;
    return;
  }
  if (passing_over_) {
    pass_over(change.time);
    if (passing_over_) return;
  }
  ma_.push_back(change);
  // Nearly every edge is just the next one of the cycle under way.
  const bool next_clock = scanned_ + 1 == ma_.size() && scanned_ != 0 &&
                          scanned_ < max_cycle_edges && scanned_ % faster_clock_step != 0 &&
                          !is_long_still(elapsed(ma_[scanned_ - 1].time, change.time));
  if (next_clock) {
    ++scanned_;
  } else {
    drain(false);
  }
}

void Decoder::push_slo(LevelChange change) {
  // Without a request under way only the level counts.
  if (ma_.empty()) slo_.forget_before(change.time);
  slo_.push(change);
}

void Decoder::push(std::span<const wire::Edge> edges, const Lines& lines) {
  for (const wire::Edge& edge : edges) {
    if (edge.line == lines.ma) {
      push_ma({edge.time, edge.level});
    } else if (edge.line == lines.slo) {
      push_slo({edge.time, edge.level});
    }
  }
}

void Decoder::finish(Picoseconds end_time) {
  end_time_ = end_time;
  drain(true);
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
  if (!idle_known_ && 2 * elapsed(begin_time_, ma_.front().time) >= 3 * period_) {
    // The capture begins with a stillness: the first edge is a beginning, not the middle.
    idle_known_ = true;
    drop_return_to_idle();
    if (ma_.empty()) return false;
  }
  scanned_ = 1;
  return true;
}

// A rising edge behind a cycle's end is MA going back to idle (CDM = 1), not a clock.
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

// Emits the cycle at the front when its end is in sight. False: more edges are needed.
bool Decoder::take_cycle(bool at_end) {
  for (; scanned_ < ma_.size(); ++scanned_) {
    if (scanned_ == max_cycle_edges) {
      give_up();
      return false;
    }
    if (scanned_ >= faster_clock_edges && scanned_ % faster_clock_step == 0) {
      follow_clock(ma_[scanned_ - faster_clock_edges].time, ma_[scanned_].time);
    }
    const Picoseconds still = elapsed(ma_[scanned_ - 1].time, ma_[scanned_].time);
    if (!is_long_still(still)) continue;
    const std::size_t next_fall = scanned_ + (ma_[scanned_].level == Level::high ? 1 : 0);
    const bool last = next_fall >= ma_.size();
    if (last && !at_end) return false;
    const Picoseconds next = last ? end_time_ : ma_[next_fall].time;
    CycleReading reading = read_front(next, last);
    const bool doubtful = still <= 4 * period_;
    if (doubtful && repeats(reading)) return take_cycle(at_end);
    if (!reading.cycle.frame && frame_behind_doubt(next, last)) {
      reading = read_front(ma_[scanned_].time, false);
    } else if (doubtful && !is_over(reading)) {
      doubt_ = scanned_;
      continue;
    }
    emit(reading);
    return true;
  }
  if (!at_end) return false;
  CycleReading reading = read_front(end_time_, true);
  if (!reading.cycle.frame && frame_behind_doubt(end_time_, true)) {
    reading = read_front(ma_[scanned_].time, false);
  }
  emit(reading);
  return true;
}

CycleReading Decoder::read_front(Picoseconds next, bool last_of_capture) {
  return read(0, next, last_of_capture);
}

// The edges from `begin` to scanned_ as a cycle.
CycleReading Decoder::read(std::size_t begin, Picoseconds next, bool last_of_capture) {
  const auto edges = std::span<const LevelChange>(ma_).first(scanned_).subspan(begin);
  return reader_.read({.ma = edges,
                       .begins_idle = begin != 0 || idle_known_,
                       .limit = std::min(next, shifted(edges.back().time, slo_matters)),
                       .last_of_capture = last_of_capture},
                      slo_);
}

// Whether the stillness behind scanned_ is the cycle's end, and not a few missing edges.
bool Decoder::is_over(const CycleReading& reading) const {
  if (reading.complete) return true;
  const bool glitch = scanned_ == 2 && 4 * elapsed(ma_[0].time, ma_[1].time) < period_;
  const Picoseconds period = reading.cycle.period.value_or(period_);
  return glitch || (usual_clocks_ != 0 && clocks_between(0, scanned_, period) + 1 >= usual_clocks_);
}

// Where no cycle before tells how long one is: two pieces of one length are two cycles. Then goes
// back to the end of the first.
bool Decoder::repeats(const CycleReading& reading) {
  if (usual_clocks_ != 0 || !reading.cycle.period || !is_doubted()) return false;
  const std::int64_t before = clocks_between(0, doubt_, *reading.cycle.period);
  const std::int64_t behind = clocks_between(doubt_, scanned_, *reading.cycle.period);
  if (before < 2 || std::abs(behind - before) > 1) return false;
  usual_clocks_ = before;
  scanned_ = doubt_;
  return true;
}

// What stands behind the last doubtful stillness proves by itself that it is a cycle. Then goes
// back to the end of the one before, which must not be shorter: where a few of the first edges of a
// cycle are missing, the rest of it reads well too.
bool Decoder::frame_behind_doubt(Picoseconds next, bool last_of_capture) {
  if (!is_doubted()) return false;
  const std::size_t begin = doubt_ + (ma_[doubt_].level == Level::high ? 1 : 0);
  if (begin >= scanned_) return false;
  if (clocks_between(0, doubt_, period_) < clocks_between(begin, scanned_, period_)) return false;
  const CycleReading behind = read(begin, next, last_of_capture);
  const auto& checks = behind.cycle.crc_ok;
  const bool checked = std::any_of(checks.begin(), checks.end(),
                                   [](const auto& crc_ok) { return crc_ok.has_value(); });
  if (!behind.cycle.frame || !checked) return false;
  scanned_ = doubt_;
  return true;
}

std::int64_t Decoder::clocks_between(std::size_t first, std::size_t end, Picoseconds period) const {
  return elapsed(ma_[first].time, ma_[end - 1].time).count / period.count;
}

void Decoder::emit(const CycleReading& reading) {
  const Cycle& cycle = reading.cycle;
  if (cycle.period && is_usual(cycle.status)) {
    usual_clocks_ = clocks_between(0, scanned_, *cycle.period);
  }
  const Picoseconds last = ma_[scanned_ - 1].time;
  ma_.erase(ma_.begin(), ma_.begin() + static_cast<std::ptrdiff_t>(scanned_));
  slo_.forget_before(ma_.empty() ? last : ma_.front().time);
  scanned_ = 0;
  doubt_ = 0;
  idle_known_ = true;
  on_cycle_(cycle);
}

void Decoder::give_up() {
  emit(read_front(ma_[scanned_].time, false));
  passed_over_ = passed_mark_ = ma_.back().time;
  passed_edges_ = 0;
  passing_over_ = true;
  ma_.clear();
}

void Decoder::pass_over(Picoseconds time) {
  passing_over_ = !is_long_still(elapsed(passed_over_, time));
  passed_over_ = time;
  if (++passed_edges_ % faster_clock_edges != 0) return;
  follow_clock(passed_mark_, time);
  passed_mark_ = time;
}

// What a cycle began with may have been no clock: MA and SLO exchanged, or anything else on MA.
// Measured by that, the stillness between the requests that follow would be none.
void Decoder::follow_clock(Picoseconds begin, Picoseconds end) {
  const Picoseconds period = elapsed(begin, end) * 2 / std::int64_t{faster_clock_edges};
  if (2 * period < period_) period_ = std::max(period, picoseconds(1));
}

}  // namespace biss::decode
