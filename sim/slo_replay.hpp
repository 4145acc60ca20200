// The master of this project reads a recorded encoder: SLO as recorded, MA simulated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
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
  SloReplay(const SloReplaySetup& setup, OnReading on_reading);

  /// Appends to `out` the changes that are known so far: our MA and the recorded SLO in time order.
  /// Edges of other lines are skipped.
  /// \pre times do not decrease, and are within replay_time_max
  void push(std::span<const wire::Edge> edges, wire::LineIndex ma, wire::LineIndex slo,
            std::vector<wire::Edge>& out);

  /// Ends the capture at this time, not before its last edge. A request that it cuts is `truncated`.
  void finish(Picoseconds end, std::vector<wire::Edge>& out);

 private:
  using Master = RequestCycle<FrameCodec<>>;

  // The longest frame has fewer edges; more edges do not count as a request, and further changes of
  // SLO are dropped.
  static constexpr std::size_t edges_max = 4096;

  void put_ma(const wire::Edge& edge, std::vector<wire::Edge>& out);
  void put_slo(const wire::Edge& edge, std::vector<wire::Edge>& out);
  void change_slo(const wire::Edge& edge, std::vector<wire::Edge>& out);
  bool is_idle(Picoseconds now) const;
  void settle(Picoseconds now, std::vector<wire::Edge>& out);
  MasterSetup setup_of_request() const;
  void begin(std::vector<wire::Edge>& out);
  void pass_on_kept(std::vector<wire::Edge>& out);
  void run_until(Picoseconds time, std::vector<wire::Edge>& out);
  void take(const StepOutput& output, Picoseconds now, std::vector<wire::Edge>& out);
  void report();
  void miss(Picoseconds time);

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
