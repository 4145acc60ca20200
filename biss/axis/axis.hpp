// From the result of each cycle to a position that a drive can use: turns, direction and zero,
// limits of movement, what to do without a good frame, and how far the position can be wrong.
//
// docs/axis.md has the tables of states and causes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "biss/axis/cause.hpp"
#include "biss/axis/counters.hpp"
#include "biss/base/bits.hpp"
#include "biss/base/units.hpp"
#include "biss/base/wrapping_time.hpp"
#include "biss/frame/frame.hpp"
#include "biss/turns/turn_counter.hpp"

namespace biss {

/// The reaction to a cycle without a measured position, before too many of them trip.
enum class BadCycleRule : std::uint8_t {
  hold,         ///< keeps the last measured position
  extrapolate,  ///< continues at the last measured speed
  trip,         ///< trips at once, except while the encoder powers up
};

/// The reaction to nW = 0.
enum class WarningRule : std::uint8_t {
  measure,  ///< the position counts; the cause `warning` reports it
  bad,      ///< the cycle is a bad one
  trip,     ///< trips at once
};

/// For AxisSetup::max_step: any step below half of the encoder's range.
inline constexpr std::int64_t no_step_limit = std::numeric_limits<std::int64_t>::max();

/// Positions, offsets and presets are below this number of counts, in both directions.
inline constexpr std::int64_t axis_position_max = std::int64_t{1} << 62U;

/// The longest time from one request to the next.
inline constexpr Picoseconds axis_cycle_max = milliseconds(100'000);

/// The limits of an axis, and its reaction to cycles without a good frame.
struct AxisSetup {
  /// The time from one request to the next. A request may come an eighth of it later. Within an
  /// eighth of it after the last measured position, it is `early`: the times or `cycle` are wrong.
  Picoseconds cycle{};
  /// From the request to the moment whose position is sent: sampling_delay() of the SPI's setup.
  Picoseconds to_sampling{};
  /// The largest movement of the axis in one cycle and that eighth, in counts, in both directions;
  /// below half of the encoder's range. A good frame with a larger step is a bad cycle: in the worst
  /// case a CRC of 6 bits does not detect one in 64 faults.
  std::int64_t max_step = 0;
  BadCycleRule bad_cycles = BadCycleRule::extrapolate;
  WarningRule warnings = WarningRule::measure;
  /// The number of bad cycles in a row that trips, also at the start once power_up is over; 0 counts
  /// as 1. Cycles in which nothing was requested count too.
  std::uint16_t trip_after = 4;
  /// The encoder's time to power up: from the first request on, also after a reset, until the first
  /// measured position. Bad cycles in this time do not trip. An EDS can state up to 254 ms; 0: every
  /// bad cycle counts.
  Picoseconds power_up = milliseconds(1'000);
  /// Counts down when the encoder counts up.
  bool reversed = false;
  /// The position at which the encoder's count is 0.
  std::int64_t offset = 0;

  constexpr bool operator==(const AxisSetup&) const = default;
};

/// A position for the drive. `state` is its quality.
struct AxisPosition {
  /// In counts, with turns, direction and offset. 0 without a position.
  std::int64_t position = 0;
  /// At `moment` the axis is within position ± uncertainty; for a held position also until the
  /// sampling of the last cycle. It is 0 for a measured position, and holds as long as the axis keeps
  /// to max_step. Its largest value means that nothing is known: no_position, tripped.
  std::int64_t uncertainty = std::numeric_limits<std::int64_t>::max();
  /// The speed in counts per cycle, between the last two measured positions.
  std::int64_t step = 0;
  /// The time to which the position belongs; for a held position the time of its measurement.
  Picoseconds moment{};
  /// The number of the request in whose frame the position was measured, from 1; 0: none yet. The
  /// same number again is the same frame.
  std::uint32_t number = 0;
  /// Bad cycles since the last measured position.
  std::uint16_t bad_in_a_row = 0;
  AxisState state = AxisState::no_position;
  /// The result of the last cycle; after a trip, of the cycle that tripped.
  AxisCause cause = AxisCause::ok;

  /// The age of the position: step × age is the error if it is ignored.
  constexpr Picoseconds age(Picoseconds now) const { return wrapping_elapsed(moment, now); }
  /// The position may be used: it was measured, or the setup's rule continues for some cycles.
  constexpr bool usable() const {
    return state != AxisState::no_position && state != AxisState::tripped;
  }
};

/// Why an axis cannot work: the first cause that applies.
enum class AxisError : std::uint8_t {
  reader,    ///< the reader's error() has the cause
  buffer,    ///< the reader needs more than max_bytes
  format,    ///< it does not have one position of 1 to 62 bits for each axis
  cycle,     ///< cycle or to_sampling is not positive, or cycle above axis_cycle_max
  max_step,  ///< it is not positive, or not below half of the encoder's range
  offset,    ///< it is not below axis_position_max
};

/// The name that users see: the enumerator's name.
constexpr std::string_view name_of(AxisError error) {
  constexpr std::string_view names[] = {"reader", "buffer",   "format",
                                        "cycle",  "max_step", "offset"};
  return names[static_cast<std::size_t>(error)];
}

namespace axis_detail {

/// Half of the range of an encoder, in counts.
constexpr std::int64_t half_range(unsigned position_bits) {
  return std::int64_t{1} << (position_bits - 1U);
}

// Whether bits 63 and 62 are equal.
constexpr bool is_in_range(std::int64_t position) {
  const auto bits = static_cast<std::uint64_t>(position);
  return ((bits ^ (bits << 1U)) >> 63U) == 0;
}

constexpr std::int64_t magnitude(std::int64_t value) { return value < 0 ? -value : value; }

// value × cycles, or the largest number if it does not fit. \pre value is not negative
constexpr std::int64_t times(std::int64_t value, std::uint16_t cycles) {
  const std::int64_t high = (value >> 32U) * cycles;
  if ((high >> 30U) != 0) return std::numeric_limits<std::int64_t>::max();
  return (high << 32U) + (value & 0xFFFF'FFFF) * cycles;
}

// The divisions of 64 bits would need 850 bytes of flash on Cortex-M.

// value / divisor, in digits of 16 bits. \pre divisor is not 0
constexpr std::int64_t divide(std::int64_t value, std::uint16_t divisor) {
  const auto dividend = static_cast<std::uint64_t>(magnitude(value));
  std::uint64_t quotient = 0;
  std::uint32_t rest = 0;
  for (unsigned shift = 64; shift != 0;) {
    shift -= 16;
    rest = rest << 16U | static_cast<std::uint16_t>(dividend >> shift);
    quotient = quotient << 16U | rest / divisor;
    rest %= divisor;
  }
  const auto result = static_cast<std::int64_t>(quotient);
  return value < 0 ? -result : result;
}

// value / divisor, or most_cycles if it is larger; fast for a small result.
// \pre divisor is 1 to 2^47, value not negative
inline constexpr std::uint16_t most_cycles = std::numeric_limits<std::uint16_t>::max();
constexpr std::uint16_t whole_cycles(std::int64_t value, std::int64_t divisor) {
  unsigned quotient = 0;
  unsigned bit = 1;
  for (; value >= divisor && bit <= most_cycles / 2U; divisor <<= 1U) bit <<= 1U;
  for (; bit != 0; bit >>= 1U, divisor >>= 1U) {
    if (value < divisor) continue;
    value -= divisor;
    quotient |= bit;
  }
  return static_cast<std::uint16_t>(quotient);
}

}  // namespace axis_detail

/// Returns why an axis cannot work with this setup and an encoder of these bits; nothing if it can.
constexpr std::optional<AxisError> check_axis(const AxisSetup& setup, unsigned position_bits) {
  if (position_bits < 1 || position_bits > 62) return AxisError::format;
  if (setup.cycle.count <= 0 || setup.cycle > axis_cycle_max || setup.to_sampling.count <= 0) {
    return AxisError::cycle;
  }
  const bool limited = setup.max_step != no_step_limit;
  if (setup.max_step <= 0 ||
      (limited && setup.max_step >= axis_detail::half_range(position_bits))) {
    return AxisError::max_step;
  }
  if (!axis_detail::is_in_range(setup.offset)) return AxisError::offset;
  return std::nullopt;
}

/// Judges the cycles of one axis: call good() or bad() once for each.
class Axis {
 public:
  /// \param setup must outlive the axis; may be in flash
  /// \pre check_axis() finds no error
  constexpr Axis(const AxisSetup& setup, unsigned position_bits)
      : limit_(std::min(setup.max_step, axis_detail::half_range(position_bits) - 1)),
        setup_(&setup),
        position_bits_(static_cast<std::uint8_t>(position_bits)) {}
  Axis(const AxisSetup&&, unsigned) = delete;

  /// Reports a good frame.
  /// \param asked when it was requested; the time may wrap around at the limits of its type
  /// \param number the number of its request
  constexpr void good(const Channel& channel, Picoseconds asked, std::uint32_t number) {
    if (!channel.nE) [[unlikely]]
      return bad(AxisCause::error_bit, asked);
    if (state_ == AxisState::tripped) [[unlikely]]
      return counts_.add(AxisCause::tripped);
    if (!channel.nW && setup_->warnings != WarningRule::measure) [[unlikely]] {
      return setup_->warnings == WarningRule::trip ? trip(AxisCause::warning)
                                                   : bad(AxisCause::warning, asked);
    }
    if (state_ == AxisState::no_position) [[unlikely]]
      return start(channel, asked, number);
    if (!is_next(asked)) [[unlikely]] {
      static_cast<void>(good_after(channel, asked, number));
      return;
    }
    const std::int64_t moved = step_to(channel.position);
    if (is_above(moved, limit_)) [[unlikely]]
      return bad(AxisCause::step, asked);
    take(moved, moved, channel, AxisCause::ok, asked, number);
  }

  /// Reports a cycle without a good frame.
  [[gnu::noinline]] constexpr void bad(AxisCause cause, Picoseconds asked) {
    if (state_ == AxisState::tripped) return counts_.add(cause);
    if (bad_in_a_row_ != axis_detail::most_cycles) ++bad_in_a_row_;
    std::uint32_t cycles = bad_in_a_row_;
    if (state_ == AxisState::no_position) {
      if (powers_up(asked)) return enter(AxisEvent::wait, cause);
    } else {
      // The end of a late transfer comes after the bad cycle of a later request.
      cycles_ = std::max(bad_in_a_row_ > 1 ? cycles_ : std::uint16_t{1}, cycles_until(asked));
      cycles = std::max<std::uint32_t>(cycles, cycles_);
    }
    if (cycles >= setup_->trip_after || setup_->bad_cycles == BadCycleRule::trip)
      return trip(cause);
    // Without a position, step_ has a time.
    const bool proceeds = setup_->bad_cycles == BadCycleRule::extrapolate &&
                          start_ == Start::measured && can_extrapolate();
    enter(proceeds ? AxisEvent::proceed : AxisEvent::hold, cause);
  }

  /// Trips for a reason of the caller.
  constexpr void trip() {
    if (state_ != AxisState::tripped) trip(AxisCause::tripped);
  }

  /// Starts again as after construction, also after a trip: no position, turns from 0, and the time
  /// to power up begins with the next request. Call it only after the drive has stopped and the
  /// cause was found: the next position may be whole turns away from the last one, so the axis needs
  /// its reference again. Counts continue.
  constexpr void reset() {
    const CauseCounts<AxisCause, 0> counts = counts_;
    *this = Axis(*setup_, position_bits_);
    counts_ = counts;
  }

  /// Sets the turns at the last measured position, known from a reference or from memory.
  /// \return false: there is no measured position, or it would be out of range; nothing was changed
  constexpr bool set_turns(std::int64_t turns) {
    const std::int64_t most = (axis_position_max >> position_bits_) - 1;
    if (start_ != Start::measured || turns > most || turns < -most) return false;
    const std::int64_t before = last_;
    last_ = static_cast<std::int64_t>(static_cast<std::uint64_t>(turns) << position_bits_) |
            (last_ & static_cast<std::int64_t>(low_mask(position_bits_)));
    if (state_ != AxisState::extrapolated || can_extrapolate()) return true;
    last_ = before;
    return false;
  }
  /// Whole turns of the encoder's range at the last measured position, before direction and offset.
  constexpr std::int64_t turns() const { return last_ >> position_bits_; }

  /// The position for the drive, and what it is.
  constexpr AxisPosition position() const {
    AxisPosition result;
    result.number = number_;
    result.bad_in_a_row = bad_in_a_row_;
    result.state = state_;
    result.cause = cause_;
    if (start_ != Start::measured) return result;
    std::int64_t position = last_;
    result.moment = wrapping_later(since_, setup_->to_sampling);
    if (state_ == AxisState::measured) [[likely]] {
      result.uncertainty = 0;
    } else if (state_ != AxisState::tripped) {
      std::int64_t most = limit_;
      if (state_ == AxisState::extrapolated) {
        position += step_ * cycles_;
        most += axis_detail::magnitude(step_);
        result.moment = wrapping_later(result.moment, setup_->cycle * std::int64_t{cycles_});
      }
      result.uncertainty = axis_detail::times(most, cycles_);
    }
    result.position = setup_->offset + (setup_->reversed ? -position : position);
    result.step = setup_->reversed ? -step_ : step_;
    return result;
  }

  constexpr AxisState state() const { return state_; }
  /// Cycles, by their result.
  constexpr const CauseCounts<AxisCause, 0>& counts() const { return counts_; }
  /// Counts what is not a cycle of this axis: a request that a reset gives up, an unexpected end.
  constexpr void count(AxisCause cause) { counts_.add(cause); }
  constexpr const AxisSetup& setup() const { return *setup_; }

 private:
  // How far it came to a first position.
  enum class Start : std::uint8_t { none, requested, sampled, measured };

  constexpr void enter(AxisEvent event, AxisCause cause) {
    counts_.add(cause);
    cause_ = cause;
    state_ = axis_states[static_cast<std::size_t>(state_)][static_cast<std::size_t>(event)];
  }
  constexpr void trip(AxisCause cause) { enter(AxisEvent::trip, cause); }

  // From the last sample, in the shorter direction.
  constexpr std::int64_t step_to(std::uint64_t count) const {
    return signed_step(static_cast<std::uint64_t>(last_), count, position_bits_);
  }

  // \pre limit is 0 to 2^61
  static constexpr bool is_above(std::int64_t moved, std::int64_t limit) {
    return static_cast<std::uint64_t>(moved + limit) > static_cast<std::uint64_t>(limit) * 2U;
  }

  // Two good frames that agree are the first position.
  [[gnu::noinline]] constexpr void start(const Channel& channel, Picoseconds asked,
                                         std::uint32_t number) {
    const bool sampled = start_ == Start::sampled;
    if (sampled && good_after(channel, asked, number)) {
      start_ = Start::measured;
      return;
    }
    if (!sampled) {
      static_cast<void>(powers_up(asked));
      enter(AxisEvent::wait, AxisCause::first);
    }
    last_ = static_cast<std::int64_t>(channel.position);
    since_ = asked;
    start_ = Start::sampled;
  }

  constexpr bool knows_turns_after(std::uint16_t cycles) const {
    // most_cycles may be more of them.
    return cycles != axis_detail::most_cycles &&
           axis_detail::times(limit_, cycles) < axis_detail::half_range(position_bits_);
  }

  // Whether the position is taken; if not, it is a bad cycle.
  [[gnu::noinline]] constexpr bool good_after(const Channel& channel, Picoseconds asked,
                                              std::uint32_t number) {
    const std::uint16_t cycles = cycles_until(asked);
    const bool known = knows_turns_after(cycles);
    const std::int64_t moved = step_to(channel.position);
    if (!known || is_above(moved, limit_ * cycles)) {
      bad(known ? AxisCause::step : AxisCause::turns, asked);
      return false;
    }
    const bool early = cycles == 1 && !is_next(asked);
    take(moved, axis_detail::divide(moved, cycles), channel,
         early ? AxisCause::early : AxisCause::ok, asked, number);
    return state_ == AxisState::measured;
  }

  // \param cause unless nW is 0
  constexpr void take(std::int64_t moved, std::int64_t step, const Channel& channel,
                      AxisCause cause, Picoseconds asked, std::uint32_t number) {
    const std::int64_t position = last_ + moved;
    if (!axis_detail::is_in_range(position)) [[unlikely]]
      return bad(AxisCause::turns, asked);
    last_ = position;
    step_ = step;
    since_ = asked;
    number_ = number;
    bad_in_a_row_ = 0;
    enter(AxisEvent::good, channel.nW ? cause : AxisCause::warning);
  }

  // Until the first measured position, step_ is the time of the first request.
  constexpr bool powers_up(Picoseconds asked) {
    if (start_ == Start::none) {
      step_ = asked.count;
      start_ = Start::requested;
    }
    // Negative for the end of a first transfer that was late.
    const Picoseconds waited = wrapping_elapsed(Picoseconds{step_}, asked);
    return waited < setup_->power_up && waited > Picoseconds{} - setup_->power_up;
  }

  // Whether the last measured position is more than a cycle old, and an eighth.
  constexpr bool has_gap(Picoseconds asked) const {
    const Picoseconds elapsed = wrapping_elapsed(since_, asked);
    // A negative time is one of more than 106 days.
    return elapsed < Picoseconds{} || elapsed > one_cycle();
  }
  // Whether one cycle has passed since the last measured position, ± 7 eighths, + 1 eighth: neither
  // early nor with a gap. One comparison for both, because each cycle makes it.
  constexpr bool is_next(Picoseconds asked) const {
    const Picoseconds eighth{setup_->cycle.count >> 3U};
    const Picoseconds later = wrapping_elapsed(eighth, wrapping_elapsed(since_, asked));
    return static_cast<std::uint64_t>(later.count) <=
           static_cast<std::uint64_t>(setup_->cycle.count);
  }
  constexpr Picoseconds one_cycle() const {
    return setup_->cycle + Picoseconds{setup_->cycle.count >> 3U};
  }
  // Cycles since the last measured position, 1 or more.
  constexpr std::uint16_t cycles_until(Picoseconds asked) const {
    if (!has_gap(asked)) return 1;
    const Picoseconds elapsed = wrapping_elapsed(since_, asked);
    if (elapsed < Picoseconds{}) return axis_detail::most_cycles;
    const std::int64_t further = (elapsed - one_cycle()).count - 1;
    const unsigned cycles = 2U + axis_detail::whole_cycles(further, setup_->cycle.count);
    return static_cast<std::uint16_t>(std::min<unsigned>(cycles, axis_detail::most_cycles));
  }

  constexpr bool can_extrapolate() const {
    return axis_detail::times(axis_detail::magnitude(step_), cycles_) <
           axis_position_max - axis_detail::magnitude(last_);
  }

  // The last measured position, before direction and offset; while there is none, the last sample.
  std::int64_t last_ = 0;
  std::int64_t step_ = 0;  // the last measured speed
  std::int64_t limit_;
  Picoseconds since_{};  // the request of last_
  const AxisSetup* setup_;
  std::uint32_t number_ = 0;
  CauseCounts<AxisCause, 0> counts_{};
  std::uint16_t bad_in_a_row_ = 0;
  // From since_ to the last bad cycle.
  std::uint16_t cycles_ = 1;
  AxisState state_ = AxisState::no_position;
  AxisCause cause_ = AxisCause::ok;
  std::uint8_t position_bits_;
  Start start_ = Start::none;
};

}  // namespace biss
