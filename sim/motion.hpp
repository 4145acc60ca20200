// The position of an encoder at any time.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

#include "biss/base/bits.hpp"
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

inline constexpr std::int64_t requests_a_ramp = 1009;
inline constexpr std::int64_t requests_a_sine = 500;
inline constexpr std::int64_t requests_one_way = 250;

// The sine, in units of 2^-30, of a phase in units of 2^-32 turns. Integers give the same result
// with every compiler and library. Taylor series within a quarter turn; the error is below 10^-6.
inline std::int64_t sine(std::uint32_t phase) {
  constexpr std::int64_t one = std::int64_t{1} << 30U;
  constexpr std::int64_t half_pi = 1'686'629'713;  // in parts of 2^30
  const bool negative = phase >= 0x8000'0000U;
  std::uint32_t half = phase & 0x7FFF'FFFFU;
  if (half > 0x4000'0000U) half = 0x8000'0000U - half;
  const std::int64_t x = (half_pi * std::int64_t{half}) >> 30U;
  const std::int64_t square = (x * x) >> 30U;
  std::int64_t sum = one;
  for (const int n : {10, 8, 6, 4, 2}) sum = one - ((square * sum) >> 30U) / (n * (n + 1));
  const std::int64_t value = std::min((x * sum) >> 30U, one);
  return negative ? -value : value;
}

/// Positions of one channel. The same seed gives the same positions on every machine.
class Motion {
 public:
  /// \param channel the channel with this position; a turn is its singleturn part, or all of it
  /// without such a part
  /// \param interval from one request to the next; positive
  Motion(MotionKind kind, const ChannelFormat& channel, Picoseconds interval, std::uint64_t seed)
      : kind_(kind),
        position_bits_(channel.position_bits()),
        interval_(interval),
        random_(seed),
        start_(random_.next()),
        speed_(speed_of(kind, channel, interval)) {}

  /// Stops the motion from now on. \param position not wider than position_bits()
  void hold(std::uint64_t position) {
    kind_ = MotionKind::constant;
    start_ = position_bits_ == 0 ? 0 : position << (64U - position_bits_);
  }

  /// The position at this time. A random walk makes one step for each call.
  std::uint64_t sample(Picoseconds time) {
    if (kind_ == MotionKind::random) {
      constexpr std::uint64_t eighth = std::uint64_t{1} << 61U;
      start_ += (random_.next() >> 2U) - eighth;
    }
    return at(time);
  }

  /// The same without a step.
  std::uint64_t at(Picoseconds time) const {
    if (position_bits_ == 0) return 0;
    std::uint64_t place = start_;
    if (kind_ == MotionKind::ramp) {
      place += speed_ * static_cast<std::uint64_t>(time.count);
    } else if (kind_ == MotionKind::sine) {
      const std::uint64_t phase = speed_ * static_cast<std::uint64_t>(time.count);
      const auto coarse = static_cast<std::uint32_t>(phase >> 32U);
      const std::int64_t from = sine(coarse);
      place = static_cast<std::uint64_t>(from) << 32U;
      // Finer than sine() is: a straight line to the next one.
      if (position_bits_ > 32) {
        const auto rest = static_cast<std::int64_t>(phase & 0xFFFF'FFFFU);
        place += static_cast<std::uint64_t>((sine(coarse + 1) - from) * rest);
      }
    } else if (kind_ == MotionKind::max) {
      const std::int64_t way = requests_one_way * interval_.count;
      const std::int64_t within = time.count % (2 * way);
      const std::int64_t ahead = within < way ? within : 2 * way - within;
      // A quarter of the way before zero, the rest after it.
      place = speed_ * static_cast<std::uint64_t>(ahead - way / 4);
    }
    return place >> (64U - position_bits_);
  }

  unsigned position_bits() const { return position_bits_; }

 private:
  static std::uint64_t speed_of(MotionKind kind, const ChannelFormat& channel,
                                Picoseconds interval) {
    const auto ps = static_cast<std::uint64_t>(interval.count);
    if (kind == MotionKind::ramp) return UINT64_MAX / requests_a_ramp / ps;
    if (kind == MotionKind::sine) return UINT64_MAX / requests_a_sine / ps;
    if (kind != MotionKind::max) return 0;
    // A sixteenth less than half a turn, because samples may come a little late.
    const Field& turn = channel.singleturn;
    const unsigned turn_shift = turn.present() ? channel.position_bits() - turn.bits : 0;
    const std::uint64_t half_turn = (UINT64_MAX >> turn_shift) / 2;
    return half_turn / 16 * 15 / ps;
  }

  MotionKind kind_;
  unsigned position_bits_;
  Picoseconds interval_;
  Random random_;
  // In units of 2^-64 of the range, so that a passage through zero is an overflow.
  std::uint64_t start_;
  std::uint64_t speed_;  // per picosecond; for a sine, the speed of its phase
};

}  // namespace biss::sim
