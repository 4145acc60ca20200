// The master of this project reads a recorded encoder: SLO as recorded, MA simulated.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "biss/frame/codec.hpp"
#include "biss/master/request.hpp"
#include "sim/ma_replay.hpp"
#include "wire/edge.hpp"

namespace biss::sim {

struct SloReplaySetup {
  /// The codec of a format with at least one channel.
  FrameCodec<> codec;
  /// `period` 0: the period of each recorded request, with its duty cycle. Reset time, shortest cycle
  /// and idle time are ignored: the recorded master determines when requests come.
  MasterSetup master;
};

/// The reading of our master at a request of the recorded master.
struct ReplayReading {
  BasicReading<Frame> reading;
  /// The period of our MA; 0 if no request was made.
  Picoseconds period{};
};

/// Makes a request whenever the recorded MA begins one, and reads the recorded answer. The answer
/// was made for another master: it is complete if our master sends the same clocks; otherwise the
/// reading has a cause.
///
/// A request begins with the first falling edge after MA was idle for more than 1.25 periods. Fewer
/// than two clocks, or clocks above 100 MHz, do not count as a request. Levels of SLO that are
/// neither 0 nor 1 are copied to the output; our master still sees the level before.
class SloReplay {
 public:
  using OnReading = std::function<void(const ReplayReading&)>;

  /// \param on_reading called for each request; may be empty
  /// \pre setup.master meets the conditions of MasterSetup, or its period is 0
  SloReplay(const SloReplaySetup& setup, OnReading on_reading)
      : setup_(setup), on_reading_(std::move(on_reading)) {
    setup_.master.timing.cycle_min = {};
    idle_min_ = longest_period * 5 / 4;
  }

  /// Appends to `out` the changes that are known so far: our MA and the recorded SLO in time order.
  /// Edges of other lines are skipped.
  /// \pre times do not decrease, and are within replay_time_max
  void push(std::span<const wire::Edge> edges, wire::LineIndex ma, wire::LineIndex slo,
            std::vector<wire::Edge>& out) {
    for (const wire::Edge& edge : edges) {
      if (edge.line == ma) put_ma(edge, out);
      if (edge.line == slo) put_slo(edge, out);
    }
  }

  /// Ends the capture at this time, not before its last edge. A request that it cuts is `truncated`.
  void finish(Picoseconds end, std::vector<wire::Edge>& out) {
    if (collecting_) begin(out);
    run_until(end, out);
    if (master_) report();
  }

 private:
  // The slowest clock.
  static constexpr Picoseconds longest_period = period_of(biss_clock_min);
  // Ten times the fastest clock. Shorter periods are noise, not a clock for a request.
  static constexpr Picoseconds shortest_period = period_of(hertz(10 * biss_clock_max.count));

  using Master = RequestCycle<FrameCodec<>>;

  // The longest frame has fewer edges; more edges do not count as a request, and further changes of
  // SLO are dropped.
  static constexpr std::size_t edges_max = 4096;

  void put_ma(const wire::Edge& edge, std::vector<wire::Edge>& out) {
    if (edge.level == wire::Level::unknown) return;
    const bool level = edge.level == wire::Level::high;
    if (!std::exchange(begun_, true)) {
      out.push_back({edge.time, ma_line, wire::Level::high});
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

  void put_slo(const wire::Edge& edge, std::vector<wire::Edge>& out) {
    settle(edge.time, out);
    if (collecting_) {
      if (slo_edges_.size() < edges_max) slo_edges_.push_back(edge);
      return;
    }
    change_slo(edge, out);
  }

  void change_slo(const wire::Edge& edge, std::vector<wire::Edge>& out) {
    run_until(edge.time, out);
    out.push_back({edge.time, slo_line, edge.level});
    if (edge.level == wire::Level::unknown) return;
    slo_ = edge.level == wire::Level::high;
    if (master_) take(master_->step(edge.time, slo_), edge.time, out);
  }

  bool is_idle(Picoseconds now) const { return now - last_ma_ > idle_min_; }

  // After the recorded request has ended, its clock is known; our request then begins at the time at
  // which the recorded one began.
  void settle(Picoseconds now, std::vector<wire::Edge>& out) {
    if (collecting_ && is_idle(now)) begin(out);
  }

  MasterSetup setup_of_request() const {
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

  void begin(std::vector<wire::Edge>& out) {
    if (ma_edges_.size() >= 4) {
      const MasterSetup setup = setup_of_request();
      if (setup_.master.period.count != 0 || setup.period >= shortest_period) {
        master_.emplace(setup_.codec, setup);
        take(master_->begin(ma_edges_[0], slo_), ma_edges_[0], out);
      }
    }
    pass_on_kept(out);
  }

  void pass_on_kept(std::vector<wire::Edge>& out) {
    collecting_ = false;
    for (const wire::Edge& edge : slo_edges_) change_slo(edge, out);
    slo_edges_.clear();
  }

  void run_until(Picoseconds time, std::vector<wire::Edge>& out) {
    while (master_ && output_.deadline <= time) {
      const Picoseconds now = output_.deadline;
      take(master_->step(now, slo_), now, out);
    }
  }

  void take(const StepOutput& output, Picoseconds now, std::vector<wire::Edge>& out) {
    const bool before = std::exchange(output_, output).level;
    if (output.level != before)
      out.push_back({now, ma_line, output.level ? wire::Level::high : wire::Level::low});
    if (master_->done()) report();
  }

  void report() {
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
  void miss(Picoseconds time) {
    ReplayReading reading;
    reading.reading.frame = failure(FrameFault{FrameError::not_ready});
    reading.reading.refusal = Refusal::slo_low;
    reading.reading.begin = time;
    if (on_reading_) on_reading_(reading);
  }

  SloReplaySetup setup_;
  OnReading on_reading_;
  std::optional<Master> master_;  // while a request runs
  StepOutput output_;
  std::vector<Picoseconds> ma_edges_;  // of the recorded request, the first one falling
  std::vector<Picoseconds> missed_;    // requests that began during ours
  std::vector<wire::Edge> slo_edges_;  // since its begin, not yet passed on
  bool collecting_ = false;            // a recorded request with a clock that is still unknown
  bool passing_ = false;               // a recorded request that is not read
  bool slo_ = true;
  bool begun_ = false;
  bool recorded_ma_ = true;
  Picoseconds last_ma_{};
  Picoseconds idle_min_{};  // MA is idle after this time without an edge
};

}  // namespace biss::sim
