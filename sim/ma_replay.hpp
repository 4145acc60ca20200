// The encoder of this project behind a recorded master: MA as it was, SLO as our encoder answers.
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

/// A replay takes captures whose edges lie so far from time 0 at most, either way: ten days, so
/// that nothing it adds up leaves the range of times.
inline constexpr Picoseconds replay_time_max = milliseconds(864'000'000);

/// What became of a recorded request.
enum class AnswerKind : std::uint8_t {
  complete,   ///< answered up to STOP
  cut,        ///< MA stopped before
  not_ready,  ///< it came before the encoder's timeout was over, and is not answered
};

struct Answer {
  Picoseconds time{};  ///< the first falling edge of MA
  AnswerKind kind = AnswerKind::cut;
  /// What the encoder sampled; without channels where it did not come to that.
  Frame sent;
};

struct MaReplaySetup {
  /// Of a format with a channel.
  FrameCodec<> codec;
  SlaveTiming timing;
  /// From an edge of MA to the change of SLO it makes, both where MA was recorded; not negative.
  Picoseconds line_delay{};
  /// Nothing: the encoder is unidirectional.
  std::optional<EncoderRegisters> registers{};
};

/// Answers the edges of MA in the order they come. The encoder is idle when the capture begins, so
/// that a cycle which is cut there is answered as if it began there.
///
/// Levels of MA that are neither 0 nor 1 are recorded and change nothing for the encoder.
class MaReplay {
 public:
  using Sample = std::function<Frame(Picoseconds moment)>;
  using OnAnswer = std::function<void(const Answer&)>;

  /// \param sample the channels' values as of that moment
  /// \param on_answer told when a request is over; may be empty
  MaReplay(const MaReplaySetup& setup, Sample sample, OnAnswer on_answer);
  MaReplay(const MaReplay&) = delete;
  MaReplay& operator=(const MaReplay&) = delete;

  /// Appends to `out` what is known so far: ma_line and slo_line in time order. Edges of other
  /// lines than `ma` are passed over.
  /// \pre times do not fall, and lie within replay_time_max
  void push(std::span<const wire::Edge> edges, wire::LineIndex ma, std::vector<wire::Edge>& out);

  /// The capture ends at this time, not before its last edge; the answer under way goes on to its
  /// end. \return the end of the replay
  Picoseconds finish(Picoseconds end, std::vector<wire::Edge>& out);

  /// What is in the registers now. \pre the encoder has some
  EncoderRegisters& registers() { return *registers_; }
  /// Levels of MA that were neither 0 nor 1.
  std::uint64_t unknown_levels() const { return unknown_levels_; }

 private:
  // The slave's owner: asks `sample` and remembers what it said.
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
  std::deque<wire::Edge> slo_;  // on their way
  Answer answer_;
  bool open_ = false;  // a request is under way
  bool begun_ = false;
  bool ma_ = true;
  Picoseconds last_edge_{};
  Picoseconds half_period_{};  // between the two last edges
  std::uint64_t unknown_levels_ = 0;
};

}  // namespace biss::sim
