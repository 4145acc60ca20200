#include "sim/ma_replay.hpp"

#include <algorithm>
#include <utility>

namespace biss::sim {

using wire::Edge;
using wire::Level;

MaReplay::MaReplay(const MaReplaySetup& setup, Sample sample, OnAnswer on_answer)
    : line_delay_(setup.line_delay),
      sample_(std::move(sample)),
      on_answer_(std::move(on_answer)),
      registers_(setup.registers),
      slave_(setup.codec, setup.timing, Source{this}) {
  if (registers_) control_.emplace(RegistersAt{&*registers_});
}

// A command may switch the channels for the next request.
void MaReplay::take_cdm(bool bit) {
  control_->cdm(bit);
  slave_.set_channels_active(registers_->channels_active());
}

void MaReplay::push(std::span<const Edge> edges, wire::LineIndex ma, std::vector<Edge>& out) {
  for (const Edge& edge : edges) {
    if (edge.line == ma) put_ma(edge, out);
  }
}

void MaReplay::put_ma(const Edge& edge, std::vector<Edge>& out) {
  run_until(edge.time);
  flush(edge.time, out);
  out.push_back({edge.time, ma_line, edge.level});
  if (!begun_) {
    begun_ = true;
    out.push_back({edge.time, slo_line, Level::high});
  }
  if (edge.level == Level::unknown) return;
  const bool level = edge.level == Level::high;
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
void MaReplay::run_until(Picoseconds time) {
  while (output_.deadline <= time && output_.has_deadline()) step(output_.deadline, ma_);
}

void MaReplay::step(Picoseconds now, bool ma) {
  const SlaveState before = slave_.state();
  const bool slo = output_.level;
  ma_ = ma;
  output_ = slave_.step(now, ma, false);
  if (output_.level != slo) {
    slo_.push_back({now + line_delay_, slo_line, output_.level ? Level::high : Level::low});
  }
  follow(before, now);
}

void MaReplay::follow(SlaveState before, Picoseconds now) {
  const SlaveState state = slave_.state();
  if (state == before) return;
  if (state == SlaveState::requested) begin_answer(now, AnswerKind::cut);
  if (state == SlaveState::stop) answer_.kind = AnswerKind::complete;
  // Recognised at its second edge.
  if (state == SlaveState::early_request) begin_answer(last_edge_, AnswerKind::not_ready);
  if (state == SlaveState::idle) end_answer();
}

void MaReplay::begin_answer(Picoseconds time, AnswerKind kind) {
  end_answer();
  answer_ = Answer{};
  answer_.time = time;
  answer_.kind = kind;
  open_ = true;
}

void MaReplay::end_answer() {
  if (open_ && on_answer_) on_answer_(answer_);
  open_ = false;
}

void MaReplay::flush(Picoseconds time, std::vector<Edge>& out) {
  for (; !slo_.empty() && slo_.front().time <= time; slo_.pop_front()) out.push_back(slo_.front());
}

Picoseconds MaReplay::finish(Picoseconds end, std::vector<Edge>& out) {
  while (output_.has_deadline()) {
    end = std::max(end, output_.deadline + line_delay_);
    step(output_.deadline, ma_);
  }
  if (!slo_.empty()) end = std::max(end, slo_.back().time);
  flush(never, out);
  end_answer();
  return end;
}

}  // namespace biss::sim
