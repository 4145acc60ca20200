// The encoder of this project answers a recorded master: MA as recorded, SLO simulated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "biss/frame/codec.hpp"
#include "biss/slave/slave.hpp"
#include "sim/encoder_registers.hpp"
#include "sim/line.hpp"
#include "wire/edge.hpp"

namespace biss::sim {

/// The largest time of an edge that a replay accepts, positive or negative: ten days, so that no sum
/// leaves the range of times.
inline constexpr Picoseconds replay_time_max = milliseconds(864'000'000);

/// The outcome of a recorded request.
enum class AnswerKind : std::uint8_t {
  complete,   ///< answered up to STOP
  cut,        ///< MA stopped before
  not_ready,  ///< it came before the encoder's timeout ended, and is not answered
};

struct Answer {
  Picoseconds time{};  ///< the first falling edge of MA
  AnswerKind kind = AnswerKind::cut;
  /// The frame that the encoder sampled; without channels if it sampled nothing.
  Frame sent;
};

struct MaReplaySetup {
  /// The codec of a format with at least one channel.
  FrameCodec<> codec;
  SlaveTiming timing;
  /// From an edge of MA to the change of SLO that it causes, both at the place of the recording; not
  /// negative.
  Picoseconds line_delay{};
  /// Empty: the encoder is unidirectional.
  std::optional<EncoderRegisters> registers{};
};

/// Answers the edges of MA in their order. The encoder is idle when the capture begins, so that a
/// cycle that the capture cuts at its beginning is answered as if it began there.
///
/// Levels of MA that are neither 0 nor 1 are copied to the output; the encoder ignores them.
class MaReplay {
 public:
  using Sample = std::function<Frame(Picoseconds moment)>;
  using OnAnswer = std::function<void(const Answer&)>;

  /// \param sample the channels' values as of that moment
  /// \param on_answer called at the end of each request; may be empty
  MaReplay(const MaReplaySetup& setup, Sample sample, OnAnswer on_answer);
  MaReplay(const MaReplay&) = delete;
  MaReplay& operator=(const MaReplay&) = delete;

  /// Appends to `out` the changes that are known so far: ma_line and slo_line in time order. Edges
  /// of other lines than `ma` are skipped.
  /// \pre times do not decrease, and are within replay_time_max
  void push(std::span<const wire::Edge> edges, wire::LineIndex ma, std::vector<wire::Edge>& out);

  /// Ends the capture at this time, not before its last edge; an answer in progress is completed. \return the end of the replay
  Picoseconds finish(Picoseconds end, std::vector<wire::Edge>& out);

  /// The registers as they are now. \pre the encoder has registers
  EncoderRegisters& registers() { return *registers_; }

 private:
  // The source of the slave: calls `sample` and keeps its result.
  struct Source {
    MaReplay* replay;
    const Frame& sample(Picoseconds moment) const {
      return replay->answer_.sent = replay->sample_(moment);
    }
    bool cds(bool predecessor) const {
      return replay->control_ && replay->control_->cds(predecessor);
    }
    void cdm(bool bit) const {
      if (replay->control_) replay->take_cdm(bit);
    }
  };

  void take_cdm(bool bit);
  void put_ma(const wire::Edge& edge, std::vector<wire::Edge>& out);
  void run_until(Picoseconds time);
  void step(Picoseconds now, bool ma);
  void follow(SlaveState before, Picoseconds now);
  void begin_answer(Picoseconds time, AnswerKind kind);
  void end_answer();
  void flush(Picoseconds time, std::vector<wire::Edge>& out);

  Picoseconds line_delay_;
  Sample sample_;
  OnAnswer on_answer_;
  std::optional<EncoderRegisters> registers_;
  std::optional<EncoderControl> control_;
  Slave<FrameCodec<>, Source> slave_;
  StepOutput output_;
  std::deque<wire::Edge> slo_;  // not yet at the master
  Answer answer_;
  bool open_ = false;  // a request is in progress
  bool begun_ = false;
  bool ma_ = true;
  Picoseconds last_edge_{};
  Picoseconds half_period_{};  // between the two last edges
};

}  // namespace biss::sim
