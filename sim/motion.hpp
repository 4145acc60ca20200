// The position of an encoder at any time.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "biss/base/units.hpp"
#include "biss/frame/format.hpp"
#include "sim/random.hpp"

namespace biss::sim {

enum class MotionKind : std::uint8_t {
  constant,  ///< always the same position
  ramp,      ///< constant speed, the whole range in about 1000 requests
  sine,      ///< half the range around zero, 500 requests per period
  random,    ///< a random walk: up to an eighth of the range in each direction per sample
  max,       ///< nearly half a turn per request, 250 requests forwards, 250 back across zero
};

inline constexpr std::array<std::string_view, 5> motion_names{"constant", "ramp", "sine", "random",
                                                              "max"};

/// Positions of one channel. The same seed gives the same positions on every machine.
class Motion {
 public:
  /// \param channel the channel with this position; a turn is its singleturn part, or all of it
  /// without such a part
  /// \param interval from one request to the next; positive
  Motion(MotionKind kind, const ChannelFormat& channel, Picoseconds interval, std::uint64_t seed);

  /// Stops the motion from now on. \param position not wider than position_bits()
  void hold(std::uint64_t position) {
    kind_ = MotionKind::constant;
    start_ = position_bits_ == 0 ? 0 : position << (64U - position_bits_);
  }

  /// The position at this time. A random walk makes one step for each call.
  std::uint64_t sample(Picoseconds time);
  /// The same without a step.
  std::uint64_t at(Picoseconds time) const;
  unsigned position_bits() const { return position_bits_; }

 private:
  MotionKind kind_;
  unsigned position_bits_;
  Picoseconds interval_;
  Random random_;
  // In units of 2^-64 of the range, so that a passage through zero is an overflow.
  std::uint64_t start_;
  std::uint64_t speed_;  // per picosecond; for a sine, the speed of its phase
};

}  // namespace biss::sim
