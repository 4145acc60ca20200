// Effects of faults other than the levels that Disturbance changes.
#include <algorithm>

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
  if (kind == FaultKind::masquerade) set_noise();
  if (kind == FaultKind::delay) {
    lateness_ = interval_ * static_cast<std::int64_t>(1 + schedule_.detail(kind) % 3U);
  }
  if (kind != FaultKind::delay_step) return;
  // A quarter of a period to one and a quarter.
  const auto parts = static_cast<std::int64_t>(schedule_.detail(kind) % 1024U);
  slo_delay_ = setup_.slo_delay + period_ / 4 + period_ * parts / 1024;
}

void Line::end_fault(FaultKind kind) {
  disturbance_.end(kind);
  for (Node& node : nodes_) node.slave.source().end_fault(kind);
  if (kind == FaultKind::burst) disturbance_.set_burst(0, 0);
  if (kind == FaultKind::masquerade) disturbance_.set_noise(0, 0);
  if (kind == FaultKind::brown_out) restart();
  if (kind == FaultKind::delay_step) slo_delay_ = setup_.slo_delay;
}

void Line::set_pattern(FaultKind kind) {
  Random random(schedule_.detail(kind));
  const std::optional<FaultPlace> place = schedule_.place(kind);
  const unsigned bits = setup_.format.payload_bits();
  const auto note = [&](unsigned bit) {
    cycle_.injected.push_back({kind, {PlaceUnit::bit, std::uint64_t{bit} * 1000U}});
  };
  if (kind == FaultKind::flip) {
    const auto drawn = static_cast<unsigned>(random.below(bits));
    const unsigned bit = place ? static_cast<unsigned>(place->whole()) : drawn;
    note(bit);
    return disturbance_.set_flip(bit);
  }
  constexpr unsigned longest = 16;
  const auto given = static_cast<unsigned>(place ? place->whole() : 0U);
  const unsigned room = std::min(longest, bits - given);
  const auto length = static_cast<unsigned>(2 + random.below(room - 1U));
  const auto drawn = static_cast<unsigned>(random.below(bits - length + 1U));
  const unsigned first = place ? given : drawn;
  const std::uint64_t ends = (std::uint64_t{1} << (length - 1U)) | 1U;
  note(first);
  disturbance_.set_burst(first, (random.next() & low_mask(length)) | ends);
}

// Random bits of the last word and its checksum, at most 64, the first one always inverted.
void Line::set_noise() {
  const unsigned all = setup_.format.payload_bits();
  const unsigned word = setup_.format.channel_list[setup_.format.channel_count - 1U].total_bits();
  const unsigned bits = std::min({all, word, 64U});
  const std::uint64_t noise = scrambled(schedule_.detail(FaultKind::masquerade));
  disturbance_.set_noise(all - bits, (noise & low_mask(bits)) | 1U);
}

void Line::note_injected(FaultKind kind) {
  // Thousandths of a period. Whole periods are separate, because a cycle may last 1000 s and more.
  const std::int64_t since = (now_ - begin_).count;
  const std::int64_t part = since % period_.count * 1000 / period_.count;
  const auto clock = static_cast<std::uint64_t>(since / period_.count * 1000 + part);
  cycle_.injected.push_back(
      {kind, schedule_.place(kind).value_or(FaultPlace{PlaceUnit::clock, clock})});
}

// The timing of an idle encoder changes now, of another one when the request reaches it
// (apply_start()).
void Line::set_start(bool late) {
  Encoding& slave = nodes_.front().slave;
  SlaveTiming timing = node_timing(0);
  if (late) {
    const auto clocks = static_cast<std::int64_t>(1 + schedule_.detail(FaultKind::late_start) % 8U);
    timing.ready = setup_.timing.ack_max + clocks * period_;
    if (timing.ack_clocks != 0) {
      timing.ack_clocks = static_cast<std::uint16_t>(timing.ack_clocks + clocks);
    }
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
