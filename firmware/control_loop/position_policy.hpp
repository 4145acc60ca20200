// The reaction of a controller to cycles without a good position: hold, extrapolate, trip.
#pragma once

#include <cstdint>
#include <limits>

#include "biss/base/units.hpp"

namespace control_loop {

/// The reaction to one bad cycle.
enum class BadFrameRule : std::uint8_t {
  hold,         ///< keeps the last measured position
  extrapolate,  ///< continues at the last measured speed; holds until a speed is known, and if the
                ///< position would leave the range of PositionPolicy
  trip,         ///< trips at the first bad cycle
};

/// The quality of a position.
enum class Quality : std::uint8_t {
  none,          ///< no measurement yet, the position is undefined
  measured,      ///< from a good frame of this cycle
  held,          ///< the last measured one
  extrapolated,  ///< the last measured one moved on at the last measured speed
  tripped,       ///< too many bad cycles: stop the drive. The position is the last measured one
};

/// For PolicyLimits::max_step: any step is good.
inline constexpr std::int64_t no_step_limit = std::numeric_limits<std::int64_t>::max();

struct PolicyLimits {
  BadFrameRule rule = BadFrameRule::extrapolate;
  /// The number of bad cycles in a row that trips, also at the start once power_up is over; 0 counts
  /// as 1.
  std::uint16_t trip_after = 4;
  /// The encoder's time to power up: from the first request on, also after a reset, until the first
  /// measured position. Bad cycles in this time do not trip. An EDS can state up to 254 ms; 0: every
  /// bad cycle counts.
  biss::Picoseconds power_up = biss::milliseconds(1'000);
  /// The largest movement of the axis in one cycle, in counts. A good frame with a larger step
  /// counts as a bad cycle: in the worst case a CRC of 6 bits does not detect one in 64 faults.
  std::int64_t max_step = 0;
};

struct PolicyOutput {
  /// The position in counts, including turns.
  std::int64_t position = 0;
  Quality quality = Quality::none;
  /// Bad cycles since the last measured position.
  std::uint16_t bad_in_a_row = 0;
};

/// Judges each cycle: call good() or bad() once per cycle. It uses no clock. Positions must stay
/// below 2^62 counts in either direction.
class PositionPolicy {
 public:
  /// \pre limits.max_step is positive
  constexpr explicit PositionPolicy(const PolicyLimits& limits) : limits_(limits) {}

  /// Reports a good frame. \return measured; the result of bad() if the step is too large; tripped
  /// if the policy has tripped
  constexpr PolicyOutput good(std::int64_t position) {
    if (out_.quality == Quality::tripped) return out_;
    const std::int64_t cycles = std::int64_t{out_.bad_in_a_row} + 1;
    if (measured_before_) {
      const std::int64_t moved = position - last_;
      if (is_too_far(moved, cycles)) return bad();
      step_ = moved / cycles;
      step_known_ = true;
    }
    measured_before_ = true;
    last_ = position;
    return out_ = {.position = position, .quality = Quality::measured, .bad_in_a_row = 0};
  }

  /// Reports a missing or damaged frame, or one with nE = 0. \return none, held or extrapolated by
  /// the rule; tripped at the limit and from then on
  constexpr PolicyOutput bad() {
    if (out_.quality == Quality::tripped) return out_;
    if (out_.bad_in_a_row != std::numeric_limits<std::uint16_t>::max()) ++out_.bad_in_a_row;
    const bool enough =
        out_.bad_in_a_row >= limits_.trip_after || limits_.rule == BadFrameRule::trip;
    if (enough) return trip();
    out_.position = last_;
    out_.quality = measured_before_ ? Quality::held : Quality::none;
    if (limits_.rule == BadFrameRule::extrapolate && can_extrapolate()) {
      out_.position += step_ * out_.bad_in_a_row;
      out_.quality = Quality::extrapolated;
    }
    return out_;
  }

  /// Reports a bad cycle while the encoder powers up: the same as bad(), but before the first
  /// measured position it does not trip. \return none; the result of bad() after that position
  constexpr PolicyOutput wait() {
    if (measured_before_ || out_.quality == Quality::tripped) return bad();
    if (out_.bad_in_a_row != std::numeric_limits<std::uint16_t>::max()) ++out_.bad_in_a_row;
    return out_;
  }

  /// Trips for a reason of the caller, such as unknown turns.
  constexpr PolicyOutput trip() {
    out_.position = last_;
    out_.quality = Quality::tripped;
    return out_;
  }

  /// Resets the policy to its initial state and clears the trip. Call it after the cause was found.
  constexpr void reset() { *this = PositionPolicy(limits_); }

  constexpr const PolicyLimits& limits() const { return limits_; }
  constexpr const PolicyOutput& output() const { return out_; }

 private:
  static constexpr std::int64_t farthest = (std::int64_t{1} << 62U) - 1;

  static constexpr std::int64_t magnitude(std::int64_t value) { return value < 0 ? -value : value; }

  // Divisions, because products of 64-bit numbers do not fit.
  constexpr bool is_too_far(std::int64_t moved, std::int64_t cycles) const {
    return moved != 0 && (magnitude(moved) - 1) / cycles >= limits_.max_step;
  }
  constexpr bool can_extrapolate() const {
    const std::int64_t room = step_ < 0 ? farthest + last_ : farthest - last_;
    return step_known_ && magnitude(step_) <= room / out_.bad_in_a_row;
  }

  PolicyLimits limits_;
  PolicyOutput out_{};
  std::int64_t last_ = 0;
  std::int64_t step_ = 0;
  bool measured_before_ = false;
  bool step_known_ = false;
};

}  // namespace control_loop
