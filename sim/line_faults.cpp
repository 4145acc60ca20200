// What each fault does beside the levels that Disturbance changes.
#include <algorithm>

#include "sim/line.hpp"

namespace biss::sim {

void Line::begin_fault(FaultKind kind) {
  disturbance_.begin(kind);
  if (kind == FaultKind::flip || kind == FaultKind::burst) set_pattern(kind);
  if (kind == FaultKind::brown_out) restart();
  if (kind != FaultKind::delay_step) return;
  // A quarter of a period to one and a quarter.
  const auto parts = static_cast<std::int64_t>(schedule_.detail(kind) % 1024U);
  slo_delay_ = setup_.slo_delay + period_ / 4 + period_ * parts / 1024;
}

void Line::end_fault(FaultKind kind) {
  disturbance_.end(kind);
  if (kind == FaultKind::burst) disturbance_.set_burst(0, 0);
  if (kind == FaultKind::brown_out) restart();
  if (kind == FaultKind::delay_step) slo_delay_ = setup_.slo_delay;
}

void Line::set_pattern(FaultKind kind) {
  Random random(schedule_.detail(kind));
  const unsigned bits = setup_.format.payload_bits();
  if (kind == FaultKind::flip) {
    return disturbance_.set_flip(static_cast<unsigned>(random.below(bits)));
  }
  constexpr unsigned longest = 16;
  const auto length = static_cast<unsigned>(2 + random.below(std::min(longest, bits) - 1U));
  const auto first = static_cast<unsigned>(random.below(bits - length + 1U));
  const std::uint64_t ends = (std::uint64_t{1} << (length - 1U)) | 1U;
  disturbance_.set_burst(first, (random.next() & low_mask(length)) | ends);
}

// Only an encoder at rest can be told; one that is not keeps its ways, and the cycle is marked.
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
  if (slave.timing() == timing) return;
  if (slave.state() == SlaveState::idle) return slave.set_timing(timing);
  cycle_.faults |= set_of(FaultKind::late_start);
}

// Without its supply an encoder forgets all but where it stands.
void Line::restart() {
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    Node& node = nodes_[k];
    node.slave = Encoding(node.slave.codec(), node.slave.timing(), node.slave.source());
    node.due = never;
  }
}

}  // namespace biss::sim
