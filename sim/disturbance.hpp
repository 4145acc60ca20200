// The effect of faults on the levels of the lines.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/fault.hpp"
#include "sim/fault_details.hpp"
#include "sim/fault_schedule.hpp"

namespace biss::sim {

/// The places at which a level can be changed.
enum class Place : std::uint8_t {
  ma_master,   ///< on the line at the master: recorded, and passed on to the encoder
  ma_slave,    ///< only at the input of the encoder
  slo_slave,   ///< at the output of the encoder
  slo_master,  ///< at the input of the master: recorded
};

/// All active faults.
class Disturbance {
 public:
  /// The level that results at a place.
  bool level(Place place, bool level) const {
    const Spot& spot = spots_[static_cast<std::size_t>(place)];
    if (spot.low != 0) return false;
    return spot.high != 0 || level != (spot.inverted != 0);
  }

  /// \param now the place in the cycle, for faults whose place the schedule does not give
  /// \param injected gets the fault, if it has a place
  void begin(FaultKind kind, const FaultSchedule& schedule, const FrameFormat& format,
             FaultPlace now, std::vector<InjectedFault>& injected) {
    active_ |= set_of(kind);
    change(kind, true);
    const std::uint64_t detail = schedule.detail(kind);
    const auto place = schedule.place(kind);
    if (kind == FaultKind::flip || kind == FaultKind::burst) {
      const BitPattern pattern = pattern_of(kind, detail, place, format.payload_bits());
      injected.push_back({kind, {PlaceUnit::bit, std::uint64_t{pattern.first} * 1000U}});
      set(kind, pattern);
    } else if (has_place(kind)) {
      injected.push_back({kind, place.value_or(now)});
    }
    if (kind == FaultKind::masquerade) set(kind, noise_of(detail, format));
  }

  void end(FaultKind kind) {
    active_ &= ~set_of(kind);
    change(kind, false);
    set(kind, {});
  }

  bool active(FaultKind kind) const { return (active_ & set_of(kind)) != 0; }
  FaultSet active() const { return active_; }

  /// Whether bit `index` of the payload is inverted.
  bool inverts(unsigned index) const {
    const auto is_in = [index](const BitPattern& pattern) {
      return index - pattern.first < 64U && ((pattern.bits >> (index - pattern.first)) & 1U) != 0;
    };
    return (is_in(burst_) != is_in(noise_)) != (active(FaultKind::flip) && index == flip_);
  }

 private:
  enum class Effect : std::uint8_t { low, high, invert };

  struct LevelFault {
    FaultKind kind;
    Place place;
    Effect effect;
  };

  using F = FaultKind;

  static constexpr LevelFault level_faults[] = {
      {F::glitch_ma, Place::ma_master, Effect::invert},
      {F::glitch_ma_idle, Place::ma_master, Effect::invert},
      {F::glitch_slo, Place::slo_master, Effect::invert},
      {F::glitch_slo_idle, Place::slo_master, Effect::invert},
      {F::swap_slo, Place::slo_master, Effect::invert},
      {F::double_clock, Place::ma_slave, Effect::invert},
      {F::extra_clock, Place::ma_slave, Effect::invert},
      {F::swap_ma, Place::ma_slave, Effect::invert},
      {F::lost_clock, Place::ma_slave, Effect::high},
      {F::no_answer, Place::ma_slave, Effect::high},
      {F::ma_low, Place::ma_master, Effect::low},
      {F::ma_high, Place::ma_master, Effect::high},
      {F::slo_low, Place::slo_master, Effect::low},
      {F::slo_high, Place::slo_master, Effect::high},
      // An undriven receiver reads 1. If pairs are exchanged, the drivers are connected to each other,
      // and both inputs are open.
      {F::cut, Place::ma_slave, Effect::high},
      {F::cut, Place::slo_master, Effect::high},
      {F::exchange, Place::ma_slave, Effect::high},
      {F::exchange, Place::slo_master, Effect::high},
      {F::brown_out, Place::ma_slave, Effect::high},
      {F::brown_out, Place::slo_slave, Effect::high},
  };

  struct Spot {
    std::uint8_t low = 0;
    std::uint8_t high = 0;
    std::uint8_t inverted = 0;  // 0 or 1
  };

  void change(FaultKind kind, bool begins) {
    for (const auto& [of, place, effect] : level_faults) {
      if (of != kind) continue;
      Spot& spot = spots_[static_cast<std::size_t>(place)];
      std::uint8_t& count = effect == Effect::low ? spot.low : spot.high;
      if (effect == Effect::invert) {
        spot.inverted ^= 1U;
      } else {
        count = static_cast<std::uint8_t>(begins ? count + 1U : count - 1U);
      }
    }
  }

  // The bits that `flip`, `burst` or `masquerade` inverts; other kinds have none.
  void set(FaultKind kind, const BitPattern& pattern) {
    if (kind == FaultKind::flip) flip_ = pattern.first;
    if (kind == FaultKind::burst) burst_ = pattern;
    if (kind == FaultKind::masquerade) noise_ = pattern;
  }

  std::array<Spot, 4> spots_{};
  FaultSet active_ = 0;
  unsigned flip_ = 0;
  BitPattern burst_;
  BitPattern noise_;
};

}  // namespace biss::sim
