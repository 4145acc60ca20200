// Where the encoder stands, at any time.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "biss/base/units.hpp"
#include "biss/frame/format.hpp"
#include "sim/random.hpp"

namespace biss::sim {

enum class MotionKind : std::uint8_t {
  constant,  ///< the same position for ever
  ramp,      ///< a steady speed, round and round, the whole range in about 1000 requests
  sine,      ///< half the range, zero in its middle, 500 requests to and fro
  random,    ///< a random walk: up to an eighth of the range, either way, from sample to sample
  max,       ///< just less than half a turn a request, 250 requests forwards, 250 back across zero
};

inline constexpr std::array<std::string_view, 5> motion_names{"constant", "ramp", "sine", "random",
                                                              "max"};

/// Positions of one channel. The same seed gives the same positions on every machine.
class Motion {
 public:
  /// \param channel  whose position it is; a turn is its singleturn, or all of it
  /// \param interval from one request to the next; positive
  Motion(MotionKind kind, const ChannelFormat& channel, Picoseconds interval, std::uint64_t seed);

  /// The position at this time. A random walk goes a step; its time does not matter.
  std::uint64_t sample(Picoseconds time);
  /// The same without a step.
  std::uint64_t at(Picoseconds time) const;
  unsigned position_bits() const { return position_bits_; }

 private:
  MotionKind kind_;
  unsigned position_bits_;
  Picoseconds interval_;
  Random random_;
  // Shares of the range in parts of 2^64, so that a passage through zero is an overflow.
  std::uint64_t start_;
  std::uint64_t speed_;  // a picosecond; of a sine its phase
};

}  // namespace biss::sim
