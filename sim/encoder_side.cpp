#include "sim/encoder_side.hpp"

#include <algorithm>

#include "biss/timing/device_timing.hpp"

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
  if (schedule_.empty()) return;
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

Picoseconds EncoderSide::next_event() const {
  Picoseconds next = std::min({schedule_.next(), ma_pipe_.front(), filter_due_});
  for (const Node& node : nodes_) next = std::min({next, node.due, node.slo.front()});
  return next;
}

// The edge that arrives now, if there is one.
bool EncoderSide::take(Pipe& pipe, bool& level) const {
  if (pipe.front() > now_) return false;
  pipe.pop();
  level = !level;
  return true;
}

bool EncoderSide::step() {
  const bool slo_before = slo_;
  if (schedule_.next() <= now_) act();
  if (take(ma_pipe_, ma_raw_)) filter_due_ = ma_raw_ == ma_slave_ ? never : now_ + ma_filter_;
  const bool ma_changed = filter_due_ <= now_;
  if (ma_changed) {
    filter_due_ = never;
    ma_slave_ = ma_raw_;
    if (setup_.record_at_slave) record(ma_at_slave_line, ma_slave_);
  }
  for (std::size_t k = 0; k < nodes_.size() && !foreign_level_; ++k) {
    const bool sli_changed = k != 0 && take(nodes_[k - 1U].slo, nodes_[k].sli);
    if (ma_changed || sli_changed || nodes_[k].due <= now_) step_node(k, ma_changed);
  }
  if (take(nodes_.back().slo, slo_arrived_)) put_slo();
  return slo_ != slo_before;
}

void EncoderSide::step_node(std::size_t k, bool ma_changed) {
  Node& node = nodes_[k];
  if (k == 0 && start_ && ma_changed && !ma_slave_) apply_start();
  waiting_ = false;
  const SlaveState before = node.slave.state();
  const StepOutput out = node.slave.step(now_, ma_slave_, node.sli);
  node.due = out.deadline;
  const SlaveState after = node.slave.state();
  node.slave.source().follow(after);
  // A bit of the payload follows each rising edge of MA.
  if (k + 1U == nodes_.size() && ma_changed && ma_slave_ && after >= SlaveState::data &&
      after <= SlaveState::stop) {
    payload_bit_ = before == SlaveState::start ? 0U - 1U : payload_bit_ + 1U;
  }
  put_node(k, out.level);
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

void EncoderSide::put_ma() {
  const bool wire = disturbance_.level(Place::ma_master, ma_);
  if (wire != ma_wire_) {
    ma_wire_ = wire;
    record(ma_line, wire);
  }
  const bool level = disturbance_.level(Place::ma_slave, wire);
  if (level == ma_sent_) return;
  ma_sent_ = level;
  ma_pipe_.send(now_, setup_.ma_delay, setup_.ma_jitter, random_);
}

void EncoderSide::put_node(std::size_t k, bool level) {
  Node& node = nodes_[k];
  const bool last = k + 1U == nodes_.size();
  if (last && disturbance_.active() != 0) {
    const SlaveState state = node.slave.state();
    const bool sends = state == SlaveState::data || state == SlaveState::stop;
    level = disturbance_.level(Place::slo_slave,
                               level != (sends && disturbance_.inverts(payload_bit_)));
  }
  if (level == node.level) return;
  node.level = level;
  if (!last) return node.slo.send(now_, setup_.internal_delay, {}, random_);
  if (setup_.record_at_slave) record(slo_at_slave_line, level);
  node.slo.send(now_, setup_.internal_delay + slo_delay_, setup_.slo_jitter, random_);
}

void EncoderSide::put_slo() {
  const bool level = disturbance_.level(Place::slo_master, slo_arrived_);
  if (level == slo_) return;
  slo_ = level;
  record(slo_line, level);
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
    action.begins ? begin_fault(action.kind) : end_fault(action.kind);
  }
  put_flags();
  put_ma();
  Node& last = nodes_.back();
  bool level = foreign_level_.value_or(true);
  if (!foreign_level_ && !waiting_) level = last.slave.step(now_, ma_slave_, last.sli).level;
  put_node(nodes_.size() - 1U, level);
  put_slo();
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
