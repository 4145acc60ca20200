// The encoder of this project answers a recorded master: MA as recorded, SLO simulated.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <utility>
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
  MaReplay(const MaReplaySetup& setup, Sample sample, OnAnswer on_answer)
      : line_delay_(setup.line_delay),
        sample_(std::move(sample)),
        on_answer_(std::move(on_answer)),
        registers_(setup.registers),
        slave_(setup.codec, setup.timing, Source{this}) {
    if (registers_) control_.emplace(RegistersAt{&*registers_});
  }

  MaReplay(const MaReplay&) = delete;
  MaReplay& operator=(const MaReplay&) = delete;

  /// Appends to `out` the changes that are known so far: ma_line and slo_line in time order. Edges
  /// of other lines than `ma` are skipped.
  /// \pre times do not decrease, and are within replay_time_max
  void push(std::span<const wire::Edge> edges, wire::LineIndex ma, std::vector<wire::Edge>& out) {
    for (const wire::Edge& edge : edges) {
      if (edge.line == ma) put_ma(edge, out);
    }
  }

  /// Ends the capture at this time, not before its last edge; an answer in progress is completed. \return the end of the replay
  Picoseconds finish(Picoseconds end, std::vector<wire::Edge>& out) {
    while (output_.has_deadline()) {
      end = std::max(end, output_.deadline + line_delay_);
      step(output_.deadline, ma_);
    }
    if (!slo_.empty()) end = std::max(end, slo_.back().time);
    flush(never, out);
    end_answer();
    return end;
  }

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

  // A command may switch the channels for the next request.
  void take_cdm(bool bit) {
    control_->cdm(bit);
    slave_.set_channels_active(registers_->channels_active());
  }

  void put_ma(const wire::Edge& edge, std::vector<wire::Edge>& out) {
    run_until(edge.time);
    flush(edge.time, out);
    out.push_back({edge.time, ma_line, edge.level});
    if (!begun_) {
      begun_ = true;
      out.push_back({edge.time, slo_line, wire::Level::high});
    }
    if (edge.level == wire::Level::unknown) return;
    const bool level = edge.level == wire::Level::high;
    if (level == ma_) return;
    const Picoseconds idle = edge.time - last_edge_;
    // A request that is not answered ends when MA is idle for longer than in a frame.
    if (!level && slave_.state() == SlaveState::early_request && idle > 3 * half_period_) {
      begin_answer(edge.time, AnswerKind::not_ready);
    }
    step(edge.time, level);
    half_period_ = idle;
    last_edge_ = edge.time;
  }

  // Runs the encoder up to this time, this time included.
  void run_until(Picoseconds time) {
    while (output_.deadline <= time && output_.has_deadline()) step(output_.deadline, ma_);
  }

  void step(Picoseconds now, bool ma) {
    const SlaveState before = slave_.state();
    const bool slo = output_.level;
    ma_ = ma;
    output_ = slave_.step(now, ma, false);
    if (output_.level != slo) {
      slo_.push_back(
          {now + line_delay_, slo_line, output_.level ? wire::Level::high : wire::Level::low});
    }
    follow(before, now);
  }

  void follow(SlaveState before, Picoseconds now) {
    const SlaveState state = slave_.state();
    if (state == before) return;
    if (state == SlaveState::requested) begin_answer(now, AnswerKind::cut);
    if (state == SlaveState::stop) answer_.kind = AnswerKind::complete;
    // Recognised at its second edge.
    if (state == SlaveState::early_request) begin_answer(last_edge_, AnswerKind::not_ready);
    if (state == SlaveState::idle) end_answer();
  }

  void begin_answer(Picoseconds time, AnswerKind kind) {
    end_answer();
    answer_ = Answer{};
    answer_.time = time;
    answer_.kind = kind;
    open_ = true;
  }

  void end_answer() {
    if (open_ && on_answer_) on_answer_(answer_);
    open_ = false;
  }

  void flush(Picoseconds time, std::vector<wire::Edge>& out) {
    for (; !slo_.empty() && slo_.front().time <= time; slo_.pop_front())
      out.push_back(slo_.front());
  }

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
