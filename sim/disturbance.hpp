// The effect of faults on the levels of the lines.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sim/fault.hpp"

namespace biss::sim {

/// The places where a level can be changed.
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

  void begin(FaultKind kind);
  void end(FaultKind kind);
  bool active(FaultKind kind) const { return (active_ & set_of(kind)) != 0; }
  FaultSet active() const { return active_; }

  /// Whether bit `index` of the payload is inverted.
  bool inverts(unsigned index) const {
    const bool in_burst =
        index - burst_begin_ < 64U && ((burst_ >> (index - burst_begin_)) & 1U) != 0;
    const bool in_noise =
        index - noise_begin_ < 64U && ((noise_ >> (index - noise_begin_)) & 1U) != 0;
    return (in_burst != in_noise) != (active(FaultKind::flip) && index == flip_);
  }
  /// The bit that `flip` inverts.
  void set_flip(unsigned bit) { flip_ = bit; }
  /// The bits that `burst` inverts: those that are 1, the lowest is bit `begin` of the payload.
  void set_burst(unsigned begin, std::uint64_t bits) {
    burst_begin_ = begin;
    burst_ = bits;
  }
  /// The bits that `masquerade` inverts, in the same way.
  void set_noise(unsigned begin, std::uint64_t bits) {
    noise_begin_ = begin;
    noise_ = bits;
  }

 private:
  struct Spot {
    std::uint8_t low = 0;
    std::uint8_t high = 0;
    std::uint8_t inverted = 0;  // 0 or 1
  };
  enum class Effect : std::uint8_t { low, high, invert };

  void change(Place place, Effect effect, bool begins);
  void change(FaultKind kind, bool begins);

  std::array<Spot, 4> spots_{};
  FaultSet active_ = 0;
  unsigned flip_ = 0;
  unsigned burst_begin_ = 0;
  std::uint64_t burst_ = 0;
  unsigned noise_begin_ = 0;
  std::uint64_t noise_ = 0;
};

}  // namespace biss::sim
