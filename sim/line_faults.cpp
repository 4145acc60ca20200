// Effects of faults other than the levels that Disturbance changes.
#include <algorithm>

#include "sim/fault_details.hpp"
#include "sim/line.hpp"

namespace biss::sim {

void Line::begin_fault(FaultKind kind) {
  disturbance_.begin(kind);
  if (kind == FaultKind::flip || kind == FaultKind::burst) {
    set_pattern(kind);
  } else if (has_place(kind)) {
    note_injected(kind);
  }
  for (Node& node : nodes_) node.slave.source().begin_fault(kind, schedule_.detail(kind));
  if (kind == FaultKind::brown_out) restart();
  if (kind == FaultKind::ma_pause) pause_begins_ = true;
  if (kind == FaultKind::masquerade) {
    disturbance_.set(kind, noise_of(schedule_.detail(kind), setup_.format));
  }
  if (kind == FaultKind::delay) {
    lateness_ = interval_ * late_cycles(schedule_.detail(kind));
  }
  if (kind != FaultKind::delay_step) return;
  slo_delay_ = setup_.slo_delay + delay_step(schedule_.detail(kind), period_);
}

void Line::end_fault(FaultKind kind) {
  disturbance_.end(kind);
  for (Node& node : nodes_) node.slave.source().end_fault(kind);
  disturbance_.set(kind, {});
  if (kind == FaultKind::brown_out) restart();
  if (kind == FaultKind::delay_step) slo_delay_ = setup_.slo_delay;
}

void Line::set_pattern(FaultKind kind) {
  const BitPattern pattern =
      pattern_of(kind, schedule_.detail(kind), schedule_.place(kind), setup_.format.payload_bits());
  cycle_.injected.push_back({kind, {PlaceUnit::bit, std::uint64_t{pattern.first} * 1000U}});
  disturbance_.set(kind, pattern);
}

void Line::note_injected(FaultKind kind) {
  cycle_.injected.push_back(
      {kind, schedule_.place(kind).value_or(place_after(now_ - begin_, period_))});
}

// The timing of an idle encoder changes now, the timing of any other one when the request reaches
// it (apply_start()).
void Line::set_start(bool late) {
  Encoding& slave = nodes_.front().slave;
  SlaveTiming timing = node_timing(0);
  if (late) {
    timing = late_timing(timing, setup_.timing, schedule_.detail(FaultKind::late_start), period_);
  }
  start_.reset();
  if (slave.timing() == timing) return;
  if (slave.state() == SlaveState::idle) return slave.set_timing(timing);
  start_ = timing;
}

// The pending step comes first: at the highest rate an encoder becomes idle with the request. An
// encoder that is still not idle keeps its timing, and the cycle is marked.
void Line::apply_start() {
  Node& far = nodes_.front();
  far.slave.step(now_, true, far.sli);
  if (far.slave.state() == SlaveState::idle) {
    far.slave.set_timing(*start_);
  } else {
    cycle_.faults |= set_of(FaultKind::late_start);
  }
  start_.reset();
}

// Without supply an encoder loses everything but its position.
void Line::restart() {
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    Node& node = nodes_[k];
    node.slave = Encoding(node.slave.codec(), node.slave.timing(), node.slave.source());
    node.slave.source().restart();
    if (!registers_.empty()) {
      registers_[k] = k < setup_.registers.size() ? setup_.registers[k] : EncoderRegisters();
      node.slave.source().set_registers(registers_[k]);
    }
    node.due = never;
  }
}

}  // namespace biss::sim
