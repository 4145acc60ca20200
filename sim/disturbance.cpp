#include "sim/disturbance.hpp"

namespace biss::sim {

void Disturbance::begin(FaultKind kind) {
  active_ |= set_of(kind);
  change(kind, true);
}

void Disturbance::end(FaultKind kind) {
  active_ &= ~set_of(kind);
  change(kind, false);
}

void Disturbance::change(Place place, Effect effect, bool begins) {
  Spot& spot = spots_[static_cast<std::size_t>(place)];
  const auto changed = [begins](std::uint8_t count) {
    return static_cast<std::uint8_t>(begins ? count + 1U : count - 1U);
  };
  if (effect == Effect::low) spot.low = changed(spot.low);
  if (effect == Effect::high) spot.high = changed(spot.high);
  if (effect == Effect::invert) spot.inverted ^= 1U;
}

void Disturbance::change(FaultKind kind, bool begins) {
  switch (kind) {
    case FaultKind::glitch_ma:
    case FaultKind::glitch_ma_idle:
      return change(Place::ma_master, Effect::invert, begins);
    case FaultKind::glitch_slo:
    case FaultKind::glitch_slo_idle:
    case FaultKind::swap_slo:
      return change(Place::slo_master, Effect::invert, begins);
    case FaultKind::double_clock:
    case FaultKind::extra_clock:
    case FaultKind::swap_ma:
      return change(Place::ma_slave, Effect::invert, begins);
    case FaultKind::lost_clock:
    case FaultKind::no_answer:
      return change(Place::ma_slave, Effect::high, begins);
    case FaultKind::ma_low:
      return change(Place::ma_master, Effect::low, begins);
    case FaultKind::ma_high:
      return change(Place::ma_master, Effect::high, begins);
    case FaultKind::slo_low:
      return change(Place::slo_master, Effect::low, begins);
    case FaultKind::slo_high:
      return change(Place::slo_master, Effect::high, begins);
    case FaultKind::cut:
    case FaultKind::exchange:  // the drivers are connected to each other, both inputs are open An
                               // undriven receiver reads 1.
      change(Place::ma_slave, Effect::high, begins);
      return change(Place::slo_master, Effect::high, begins);
    case FaultKind::brown_out:
      change(Place::ma_slave, Effect::high, begins);
      return change(Place::slo_slave, Effect::high, begins);
    default:
      return;  // not a fault of levels
  }
}

}  // namespace biss::sim
