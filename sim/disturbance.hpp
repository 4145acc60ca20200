// What faults do to a level on its way.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sim/fault.hpp"

namespace biss::sim {

/// Where a level can be changed.
enum class Place : std::uint8_t {
  ma_master,   ///< on the line at the master: what is recorded, and goes on to the encoder
  ma_slave,    ///< only what the encoder gets
  slo_slave,   ///< what leaves the encoder
  slo_master,  ///< what the master gets, and is recorded
};

/// All faults that are under way.
class Disturbance {
 public:
  /// The level that goes on from there.
  bool level(Place place, bool level) const {
    const Spot& spot = spots_[static_cast<std::size_t>(place)];
    if (spot.low != 0) return false;
    return spot.high != 0 || level != (spot.inverted != 0);
  }

  void begin(FaultKind kind);
  void end(FaultKind kind);
  bool active(FaultKind kind) const { return (active_ & set_of(kind)) != 0; }
  FaultSet active() const { return active_; }

  /// Whether bit `index` of the payload leaves the encoder turned over.
  bool turns(unsigned index) const {
    const bool in_burst =
        index - burst_begin_ < 64U && ((burst_ >> (index - burst_begin_)) & 1U) != 0;
    const bool in_noise =
        index - noise_begin_ < 64U && ((noise_ >> (index - noise_begin_)) & 1U) != 0;
    return (in_burst != in_noise) != (active(FaultKind::flip) && index == flip_);
  }
  /// Which bit `flip` turns over.
  void set_flip(unsigned bit) { flip_ = bit; }
  /// What `burst` turns over: the bits that are 1, the lowest being bit `begin`; 0: nothing.
  void set_burst(unsigned begin, std::uint64_t bits) {
    burst_begin_ = begin;
    burst_ = bits;
  }
  /// What `masquerade` turns over, in the same way.
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
