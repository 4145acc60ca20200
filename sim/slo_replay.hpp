// The master of this project before a recorded encoder: SLO as it was, MA as our master clocks.
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
  /// Of a format with a channel.
  FrameCodec<> codec;
  /// `period` 0: that of each recorded request, with its duty. Reset time, shortest cycle and rest
  /// are not looked at: when to ask is the recorded master's choice.
  MasterSetup master;
};

/// What our master read where the recorded one made a request.
struct ReplayReading {
  BasicReading<Frame> reading;
  /// Of our MA; 0 where no request was made.
  Picoseconds period{};
};

/// Makes a request wherever the recorded MA begins one, and reads the recorded answer. It was meant
/// for another master, so it is whole where ours sends the same clocks, and the reading has its
/// cause where it does not.
///
/// A request begins with the first falling edge after MA was still for more than 1.25 periods;
/// fewer than two clocks are none, nor are those of more than 100 MHz. Levels of SLO that are
/// neither 0 nor 1 are recorded, and our master goes on seeing the level before.
class SloReplay {
 public:
  using OnReading = std::function<void(const ReplayReading&)>;

  /// \param on_reading told of one request after the other; may be empty
  /// \pre setup.master keeps what MasterSetup asks or its period is 0
  SloReplay(const SloReplaySetup& setup, OnReading on_reading);

  /// Appends to `out` what is known so far: our MA and the recorded SLO in time order. Edges of
  /// other lines are passed over.
  /// \pre times do not fall, and lie within replay_time_max
  void push(std::span<const wire::Edge> edges, wire::LineIndex ma, wire::LineIndex slo,
            std::vector<wire::Edge>& out);

  /// The capture ends at this time, not before its last edge. A request that it cuts is
  /// `truncated`.
  void finish(Picoseconds end, std::vector<wire::Edge>& out);

 private:
  using Master = RequestCycle<FrameCodec<>>;

  // More edges than the longest frame has are no request; nor more changes of SLO worth keeping.
  static constexpr std::size_t edges_max = 4096;

  void put_ma(const wire::Edge& edge, std::vector<wire::Edge>& out);
  void put_slo(const wire::Edge& edge, std::vector<wire::Edge>& out);
  void change_slo(const wire::Edge& edge, std::vector<wire::Edge>& out);
  bool is_still(Picoseconds now) const;
  void settle(Picoseconds now, std::vector<wire::Edge>& out);
  MasterSetup setup_of_request() const;
  void begin(std::vector<wire::Edge>& out);
  void tell_kept(std::vector<wire::Edge>& out);
  void run_until(Picoseconds time, std::vector<wire::Edge>& out);
  void take(const StepOutput& output, Picoseconds now, std::vector<wire::Edge>& out);
  void report();
  void miss(Picoseconds time);

  SloReplaySetup setup_;
  OnReading on_reading_;
  std::optional<Master> master_;  // while a request runs
  StepOutput output_;
  std::vector<Picoseconds> ma_edges_;  // of the recorded request, the first one falling
  std::vector<Picoseconds> missed_;    // requests that began while ours runs
  std::vector<wire::Edge> slo_edges_;  // since it began, not yet told
  bool collecting_ = false;            // a recorded request whose clock is not known yet
  bool passing_ = false;               // one that is not read
  bool slo_ = true;
  bool begun_ = false;
  bool recorded_ma_ = true;
  Picoseconds last_ma_{};
  Picoseconds still_{};  // longer than that MA is still
};

}  // namespace biss::sim
