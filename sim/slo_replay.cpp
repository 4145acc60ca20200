#include "sim/slo_replay.hpp"

#include <algorithm>
#include <utility>

namespace biss::sim {

using wire::Edge;
using wire::Level;

namespace {

// The slowest clock.
constexpr Picoseconds longest_period = period_of(biss_clock_min);

// Ten times the fastest clock. Shorter periods are noise, not a clock for a request.
constexpr Picoseconds shortest_period = period_of(hertz(10 * biss_clock_max.count));

Level level_of(bool high) { return high ? Level::high : Level::low; }

}  // namespace

SloReplay::SloReplay(const SloReplaySetup& setup, OnReading on_reading)
    : setup_(setup), on_reading_(std::move(on_reading)) {
  setup_.master.timing.cycle_min = {};
  idle_min_ = longest_period * 5 / 4;
}

void SloReplay::push(std::span<const Edge> edges, wire::LineIndex ma, wire::LineIndex slo,
                     std::vector<Edge>& out) {
  for (const Edge& edge : edges) {
    if (edge.line == ma) put_ma(edge, out);
    if (edge.line == slo) put_slo(edge, out);
  }
}

bool SloReplay::is_idle(Picoseconds now) const { return now - last_ma_ > idle_min_; }

void SloReplay::put_ma(const Edge& edge, std::vector<Edge>& out) {
  if (edge.level == Level::unknown) return;
  const bool level = edge.level == Level::high;
  if (!std::exchange(begun_, true)) {
    out.push_back({edge.time, ma_line, Level::high});
    recorded_ma_ = level;
    last_ma_ = edge.time;
    return;
  }
  if (level == recorded_ma_) return;
  settle(edge.time, out);
  recorded_ma_ = level;
  const bool was_idle = is_idle(edge.time);
  last_ma_ = edge.time;
  if (collecting_) {
    ma_edges_.push_back(edge.time);
    if (ma_edges_.size() == 3) idle_min_ = (ma_edges_[2] - ma_edges_[0]) * 5 / 4;
    if (ma_edges_.size() > edges_max) pass_on_kept(out);
    return;
  }
  if (was_idle) passing_ = false;
  if (level || passing_) return;
  passing_ = true;
  run_until(edge.time, out);
  if (master_) return missed_.push_back(edge.time);
  collecting_ = true;
  ma_edges_.assign(1, edge.time);
  idle_min_ = longest_period * 5 / 4;
}

void SloReplay::put_slo(const Edge& edge, std::vector<Edge>& out) {
  settle(edge.time, out);
  if (collecting_) {
    if (slo_edges_.size() < edges_max) slo_edges_.push_back(edge);
    return;
  }
  change_slo(edge, out);
}

void SloReplay::change_slo(const Edge& edge, std::vector<Edge>& out) {
  run_until(edge.time, out);
  out.push_back({edge.time, slo_line, edge.level});
  if (edge.level == Level::unknown) return;
  slo_ = edge.level == Level::high;
  if (master_) take(master_->step(edge.time, slo_), edge.time, out);
}

// After the recorded request has ended, its clock is known; our request then begins at the time at
// which the recorded one began.
void SloReplay::settle(Picoseconds now, std::vector<Edge>& out) {
  if (collecting_ && is_idle(now)) begin(out);
}

MasterSetup SloReplay::setup_of_request() const {
  MasterSetup setup = setup_.master;
  // The recording is read with any format and clock.
  setup.no_error_flag = setup.unchecked = true;
  setup.timing.clock_max = hertz_max;
  if (setup.period.count == 0) {
    // Measured between rising edges, which are one bit period apart.
    const std::size_t rises = ma_edges_.size() / 2;
    const Picoseconds first_rise = ma_edges_[1];
    setup.period = (ma_edges_[2 * rises - 1] - first_rise) / static_cast<std::int64_t>(rises - 1);
    setup.low_time = std::min(first_rise - ma_edges_[0], setup.period - picoseconds(1));
  }
  setup.reset_time = 2 * setup.period;
  setup.idle_min = picoseconds(1);
  return setup;
}

void SloReplay::begin(std::vector<Edge>& out) {
  if (ma_edges_.size() >= 4) {
    const MasterSetup setup = setup_of_request();
    if (setup_.master.period.count != 0 || setup.period >= shortest_period) {
      master_.emplace(setup_.codec, setup);
      take(master_->begin(ma_edges_[0], slo_), ma_edges_[0], out);
    }
  }
  pass_on_kept(out);
}

void SloReplay::pass_on_kept(std::vector<Edge>& out) {
  collecting_ = false;
  for (const Edge& edge : slo_edges_) change_slo(edge, out);
  slo_edges_.clear();
}

void SloReplay::run_until(Picoseconds time, std::vector<Edge>& out) {
  while (master_ && output_.deadline <= time) {
    const Picoseconds now = output_.deadline;
    take(master_->step(now, slo_), now, out);
  }
}

void SloReplay::take(const StepOutput& output, Picoseconds now, std::vector<Edge>& out) {
  const bool before = std::exchange(output_, output).level;
  if (output.level != before) out.push_back({now, ma_line, level_of(output.level)});
  if (master_->done()) report();
}

void SloReplay::report() {
  ReplayReading reading{master_->reading(), master_->setup().period};
  // No result yet: the capture ends within the request.
  if (!master_->done() && reading.reading.clocks == 0) {
    reading.reading.frame = failure(FrameFault{FrameError::truncated});
  }
  if (reading.reading.refusal != Refusal::none) reading.period = {};
  master_.reset();
  output_.deadline = never;
  if (on_reading_) on_reading_(reading);
  for (const Picoseconds time : missed_) miss(time);
  missed_.clear();
}

// A recorded request during one of ours.
void SloReplay::miss(Picoseconds time) {
  ReplayReading reading;
  reading.reading.frame = failure(FrameFault{FrameError::not_ready});
  reading.reading.refusal = Refusal::slo_low;
  reading.reading.begin = time;
  if (on_reading_) on_reading_(reading);
}

void SloReplay::finish(Picoseconds end, std::vector<Edge>& out) {
  if (collecting_) begin(out);
  run_until(end, out);
  if (master_) report();
}

}  // namespace biss::sim
