#include "sim/far_end.hpp"

#include <algorithm>

#include "sim/encoder_side_steps.hpp"
#include "sim/line.hpp"

namespace biss::sim {

FarEnd::FarEnd(const FarEndSetup& setup)
    : EncoderSide(setup.line, nominal_of(setup)),
      processing_max_(setup.processing_max),
      fall_period_(nominal().period) {
  ma_filter_ = setup.ma_filter;
  waits_for_edge_ = true;
  if (setup.foreign_encoder) foreign_level_ = true;
}

// The longest ACK and the delay of the filter belong to an undisturbed cycle.
NominalCycle FarEnd::nominal_of(const FarEndSetup& setup) {
  LineSetup line = setup.line;
  line.processing = setup.processing_max;
  line.internal_delay += setup.ma_filter;
  return Line(line).nominal();
}

FarEndOutput FarEnd::step(Picoseconds now, bool ma, bool foreign_slo) {
  edges_.clear();
  run(now - picoseconds(1));
  now_ = now;
  if (ma != ma_) {
    ma ? take_rise() : take_fall();
    ma_ = ma;
    put_ma<true>();
  }
  if (foreign_level_) {
    foreign_level_ = foreign_slo;
    put_node<true>(0, foreign_slo);
  }
  run(now);
  put_cycle();
  return {slo_, ma_slave_, next_event<true>()};
}

void FarEnd::put_cycle() {
  if (encoder().sampled() != cycle_.sampled) {
    cycle_.sampled = encoder().sampled();
    if (cycle_.sampled) cycle_.sent = encoder().sent();
  }
  cycle_.faults = faults_;
  cycle_.injected = injected_;
  cycle_.lateness = lateness_;
}

void FarEnd::set_lasting(FaultKind kind, bool lasts, Picoseconds now) {
  edges_.clear();
  run(now);
  now_ = now;
  lasts ? hold_fault(kind) : release_fault(kind);
  put_cycle();
}

// Without delays, one event makes the next at the same time.
void FarEnd::run(Picoseconds end) {
  for (Picoseconds next = next_event<true>(); next <= end; next = next_event<true>()) {
    now_ = std::max(now_, next);
    EncoderSide::step<true>();
  }
}

// The first clock of a request shows the clock of the master: at first its low time, half a period.
void FarEnd::take_rise() {
  last_rise_ = now_;
  if (requests_ == 0 || rises_ == 2) return;
  ++rises_;
  const Picoseconds since = now_ - begin_;
  reference_ = rises_ == 1 ? since * 3 : since;
  if (rises_ == 1) fall_period_ = std::max(fall_period_, since * 2);
}

void FarEnd::take_fall() {
  if (begins_request()) {
    begin_request();
  } else {
    fall_period_ = now_ - last_fall_;
  }
  last_fall_ = now_;
}

// MA falls. It has rested, at 1 or at a CDM of 1, as long as the encoder's timeout; or the encoder
// has become idle earlier. A shorter rest is a gap between the bytes of an SPI master, for example.
bool FarEnd::begins_request() {
  if (requests_ == 0) return true;
  if (now_ - last_fall_ <= fall_period_ + fall_period_ / 4) return false;
  if (foreign_level_) return true;
  if (std::max(last_rise_ - last_fall_, now_ - last_rise_) >= timeout()) return true;
  const bool answered = encoder().sampled() || restarted_;
  return !is_on_its_way() && answered && state() == SlaveState::idle;
}

// The rest of MA that ends a frame. With the rule `cycle` a frame may last longer; a request in it
// is one that the encoder ignores.
Picoseconds FarEnd::timeout() const {
  const Timeout& timeout = nodes_[0].slave.timing().timeout;
  const Picoseconds static_timeout = nodes_[0].slave.timing().static_timeout;
  const Picoseconds reference = std::min(reference_, static_timeout);
  switch (timeout.rule) {
    case TimeoutRule::fixed:
      return timeout.time;
    case TimeoutRule::cycle:
      return reference * timeout.release_half_periods / 3;
    case TimeoutRule::adaptive:
      break;
  }
  return std::min(reference + timeout.time, static_timeout);
}

void FarEnd::begin_request() {
  put_cycle();
  std::swap(previous_, cycle_);
  cycle_ = FarEndCycle{};
  cycle_.number = requests_++;
  cycle_.begin = now_;
  rises_ = 0;
  switch_channels();
  begin_cycle(cycle_.number, now_);
  const Picoseconds more = processing_max_ - setup_.processing;
  const std::uint64_t drawn =
      Random(~setup_.seed ^ scrambled(cycle_.number)).below(time_parts + 1U);
  set_start(slave_timing(setup_.timing, setup_.processing + part_of(more, drawn)));
}

bool needs_encoder(FaultKind kind) {
  switch (kind) {
    case FaultKind::flip:
    case FaultKind::burst:
    case FaultKind::late_start:
    case FaultKind::nE:
    case FaultKind::nW:
    case FaultKind::frozen:
      return true;
    case FaultKind::delay:
      return false;
    default:
      return static_cast<std::size_t>(kind) >= line_fault_kind_count;
  }
}

}  // namespace biss::sim
