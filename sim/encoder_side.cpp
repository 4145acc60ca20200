#include "sim/encoder_side.hpp"

#include <algorithm>

#include "biss/timing/device_timing.hpp"
#include "sim/encoder_side_steps.hpp"

namespace biss::sim {

namespace {

// The channels of slave k, counted from the far end.
FrameFormat part_of(const FrameFormat& format, std::size_t slaves, std::size_t k) {
  FrameFormat part;
  part.cds0 = format.cds0;
  const std::size_t first = slaves - 1U - k;
  const std::size_t count = k == 0 ? format.channel_count - first : 1;
  part.channel_count = static_cast<std::uint8_t>(count);
  for (std::size_t i = 0; i < count; ++i) part.channel_list[i] = format.channel_list[first + i];
  return part;
}

}  // namespace

EncoderSide::EncoderSide(const LineSetup& setup, NominalCycle nominal)
    : setup_(setup),
      schedule_(setup.faults, setup.seed),
      random_(setup.seed),
      slo_delay_(setup.slo_delay) {
  nominal.interval = std::max(setup.interval, nominal.interval);
  schedule_.set_nominal(nominal);
  if (!setup.registers.empty()) setup_.registers.resize(setup.slaves);
  registers_ = setup_.registers;
  nodes_.reserve(setup.slaves);
  for (std::size_t k = 0; k < setup.slaves; ++k) {
    const FrameFormat format = part_of(setup.format, setup.slaves, k);
    Motion motion(setup.motion, position_word(format), nominal.interval, setup.seed + k);
    if (setup.position) motion.hold(*setup.position);
    SignOfLife life = setup.life;
    // The start values are by channel of the whole frame.
    const std::size_t first = setup.slaves - 1U - k;
    std::copy(setup.life.starts.begin() + static_cast<std::ptrdiff_t>(first),
              setup.life.starts.end(), life.starts.begin());
    nodes_.push_back({.slave = Encoding(Codec(format), node_timing(k),
                                        Encoder(format, motion, life, setup.drift))});
    if (!registers_.empty()) nodes_[k].slave.source().set_registers(registers_[k]);
  }
}

SlaveTiming EncoderSide::node_timing(std::size_t k) const {
  SlaveTiming timing = slave_timing(setup_.timing, setup_.processing);
  timing.chained = k != 0;
  // Only the encoder at the far end has the fixed ACK of the device.
  if (timing.chained) timing.ack_clocks = 0;
  return timing;
}

void EncoderSide::begin_cycle(std::uint64_t number, Picoseconds begin) {
  begin_ = begin;
  faults_ = 0;
  injected_.clear();
  lateness_ = {};
  pause_begins_ = restarted_ = start_refused_ = false;
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    nodes_[k].slave.source().begin_cycle(sampling_shift(setup_.timing, setup_.seed + k, number));
  }
  schedule_.begin_cycle(number, begin);
  if (schedule_.empty() && disturbance_.active() == 0) return;
  act();
  faults_ |= disturbance_.active();
}

void EncoderSide::set_start(const SlaveTiming& timing) {
  start_ = timing;
  if (!disturbance_.active(FaultKind::late_start)) return;
  // 1 to 8 clocks later than the limit of the type.
  const auto clocks = static_cast<std::int64_t>(1 + schedule_.detail(FaultKind::late_start) % 8U);
  start_->ready = setup_.timing.ack_max + clocks * nominal().period;
  if (timing.ack_clocks == 0) return;
  start_->ack_clocks = static_cast<std::uint16_t>(timing.ack_clocks + clocks);
}

// Switches the data channels as commanded.
void EncoderSide::switch_channels() {
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    nodes_[k].slave.set_channels_active(registers_.empty() || registers_[k].channels_active());
  }
}

// The pending step comes first: at the highest rate an encoder becomes idle with the request.
void EncoderSide::apply_start() {
  Node& far = nodes_.front();
  far.slave.step(now_, true, far.sli);
  if (far.slave.state() == SlaveState::idle) {
    far.slave.set_timing(*start_);
  } else {
    start_refused_ = far.slave.timing() != *start_;
  }
  start_.reset();
}

void EncoderSide::put_flags() {
  for (Node& node : nodes_) {
    node.slave.source().set_flags(
        nE_ && !disturbance_.active(FaultKind::nE), nW_ && !disturbance_.active(FaultKind::nW),
        disturbance_.active(FaultKind::frozen), disturbance_.active(FaultKind::late_turns));
  }
}

void EncoderSide::act() {
  while (schedule_.next() <= now_) {
    const FaultAction action = schedule_.take();
    // A fault that ends with the begin of this cycle concerns only earlier cycles.
    if (action.begins || action.time > begin_) faults_ |= set_of(action.kind);
    if (action.begins) {
      begin_fault(action.kind);
    } else if ((held_ & set_of(action.kind)) == 0) {
      end_fault(action.kind);
    }
  }
  put_levels();
}

void EncoderSide::put_levels() {
  put_flags();
  put_ma<true>();
  Node& last = nodes_.back();
  bool level = foreign_level_.value_or(true);
  if (!foreign_level_ && !waiting_) level = last.slave.step(now_, ma_slave_, last.sli).level;
  put_node<true>(nodes_.size() - 1U, level);
  put_slo<true>();
}

void EncoderSide::hold_fault(FaultKind kind) {
  if ((held_ & set_of(kind)) != 0) return;
  held_ |= set_of(kind);
  if (!disturbance_.active(kind)) begin_fault(kind);
  faults_ |= set_of(kind);
  put_levels();
}

void EncoderSide::release_fault(FaultKind kind) {
  if ((held_ & set_of(kind)) == 0) return;
  held_ &= ~set_of(kind);
  end_fault(kind);
  put_levels();
}

void EncoderSide::begin_fault(FaultKind kind) {
  const std::uint64_t detail = schedule_.detail(kind);
  const Picoseconds period = nominal().period;
  // Whole periods are separate, because a cycle may last 1000 s and more.
  const Picoseconds since = now_ - begin_;
  const std::int64_t thousandths =
      since.count / period.count * 1000 + since.count % period.count * 1000 / period.count;
  const FaultPlace place{PlaceUnit::clock, static_cast<std::uint64_t>(thousandths)};
  disturbance_.begin(kind, schedule_, setup_.format, place, injected_);
  for (Node& node : nodes_) node.slave.source().begin_fault(kind, detail);
  if (kind == FaultKind::brown_out) restart();
  if (kind == FaultKind::ma_pause) pause_begins_ = true;
  if (kind == FaultKind::delay) {
    lateness_ = nominal().interval * static_cast<std::int64_t>(1 + detail % 3U);
  }
  if (kind == FaultKind::delay_step) {
    const auto parts = static_cast<std::int64_t>(detail % 1024U);
    slo_delay_ = setup_.slo_delay + period / 4 + period * parts / 1024;
  }
}

void EncoderSide::end_fault(FaultKind kind) {
  disturbance_.end(kind);
  for (Node& node : nodes_) node.slave.source().end_fault(kind);
  if (kind == FaultKind::brown_out) restart();
  if (kind == FaultKind::delay_step) slo_delay_ = setup_.slo_delay;
}

// Without supply an encoder loses everything but its position.
void EncoderSide::restart() {
  restarted_ = true;
  waiting_ = waits_for_edge_;
  registers_ = setup_.registers;
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    Node& node = nodes_[k];
    node.slave = Encoding(node.slave.codec(), node.slave.timing(), node.slave.source());
    node.slave.source().restart();
    if (!registers_.empty()) node.slave.source().set_registers(registers_[k]);
    node.due = never;
  }
}

}  // namespace biss::sim
