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
             FaultPlace now, std::vector<InjectedFault>& injected);
  void end(FaultKind kind);
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
  struct Spot {
    std::uint8_t low = 0;
    std::uint8_t high = 0;
    std::uint8_t inverted = 0;  // 0 or 1
  };
  void change(FaultKind kind, bool begins);
  void set(FaultKind kind, const BitPattern& pattern);

  std::array<Spot, 4> spots_{};
  FaultSet active_ = 0;
  unsigned flip_ = 0;
  BitPattern burst_;
  BitPattern noise_;
};

}  // namespace biss::sim
