// Turns from single-turn counts, with the right sign across zero in both directions and at the
// first sample, and a state that shows when the turns are unknown.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "biss/base/bits.hpp"

namespace biss {

/// The step from one count to the next of an encoder that repeats after 2^width_bits counts, in the
/// shorter direction; half a turn is negative. Bits above the width are ignored.
/// \pre width_bits is 1…64
constexpr std::int64_t signed_step(std::uint64_t from, std::uint64_t to, unsigned width_bits) {
  if (width_bits <= 32) {  // shorter on a processor of 32 bits
    const unsigned above = 32U - width_bits;
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(to - from) << above) >> above;
  }
  const unsigned above = 64U - width_bits;
  return static_cast<std::int64_t>((to - from) << above) >> above;
}

/// How far the number of turns can be trusted.
enum class TurnState : std::uint8_t {
  empty,      ///< no sample yet
  first,      ///< one sample: turns are 0 or the value set, no step was counted
  tracked,    ///< every step since is known
  ambiguous,  ///< a step may have been either way, or whole turns passed unseen; it stays so until
              ///< resynchronise() or restart()
};

/// Counts the turns of an encoder that repeats after 2^width counts.
///
/// A step is taken in the shorter direction, so the encoder must move less than half a turn between
/// two samples; exactly half a turn is ambiguous. If samples are missing, the encoder may have
/// moved by the largest step in each interval; half a turn of that is ambiguous.
///
/// With a width of 1, every change is half a turn: the turns show only standstill or motion.
class TurnCounter {
 public:
  /// The largest step that is just below half a turn.
  static constexpr std::uint64_t widest_step(unsigned width_bits) {
    const std::uint64_t half = std::uint64_t{1} << (width_bits - 1U);
    return half > 1 ? half - 1 : 1;
  }

  /// \pre width_bits is 1…64
  constexpr explicit TurnCounter(unsigned width_bits)
      : TurnCounter(width_bits, widest_step(width_bits)) {}

  /// \param max_step the most counts the encoder can move from one sample to the next: its highest
  ///                 speed divided by the sample rate. A larger step makes the turns ambiguous. If
  ///                 it is above widest_step(), every step is ambiguous: it may have been in the
  ///                 other direction.
  /// \pre width_bits is 1…64, max_step is 1 or more
  constexpr TurnCounter(unsigned width_bits, std::uint64_t max_step)
      : half_(std::uint64_t{1} << (width_bits - 1U)),
        max_step_(max_step),
        width_bits_(width_bits),
        too_fast_(max_step > widest_step(width_bits)) {}

  /// Takes a sample.
  /// \param count single-turn counts; bits above the width are dropped
  /// \param missed missing or bad samples since the previous good one
  constexpr TurnState update(std::uint64_t count, std::uint64_t missed = 0) {
    count &= mask();
    if (state_ == TurnState::empty) {
      count_ = count;
      return state_ = TurnState::first;
    }
    const std::uint64_t ahead = (count - count_) & mask();
    const bool forward = ahead < half_;
    const std::uint64_t step = forward ? ahead : mask() - ahead + 1;
    if (forward && count < count_ && turns_ != most) ++turns_;
    if (!forward && count > count_ && turns_ != least) --turns_;
    count_ = count;
    if (state_ == TurnState::ambiguous || !is_certain(step, missed)) {
      return state_ = TurnState::ambiguous;
    }
    return state_ = TurnState::tracked;
  }

  /// Sets the turns at the last sample, known from elsewhere (a multiturn encoder, a reference).
  /// \return tracked, or empty when there was no sample yet: the turns then count for the first one
  constexpr TurnState resynchronise(std::int64_t turns) {
    turns_ = turns;
    if (state_ != TurnState::empty) state_ = TurnState::tracked;
    return state_;
  }

  /// Returns to the first state; width and largest step stay.
  constexpr void restart() { *this = TurnCounter(width_bits_, max_step_); }

  constexpr TurnState state() const { return state_; }
  /// Whole turns, negative below the start; an estimate when ambiguous. Limited to the range of its
  /// type.
  constexpr std::int64_t turns() const { return turns_; }
  /// The last sample.
  constexpr std::uint64_t count() const { return count_; }

  /// turns() × 2^width + count(); empty if that does not fit.
  constexpr std::optional<std::int64_t> position() const {
    if (width_bits_ == 64) {
      // The upper half of turn -1 and the lower half of turn 0 fill 64 bits.
      const auto value = static_cast<std::int64_t>(count_);
      if (turns_ != (value < 0 ? -1 : 0)) return std::nullopt;
      return value;
    }
    const unsigned left_bits = 64U - width_bits_;
    const std::int64_t limit = std::int64_t{1} << (left_bits - 1U);
    if (turns_ < -limit || turns_ >= limit) return std::nullopt;
    return static_cast<std::int64_t>((static_cast<std::uint64_t>(turns_) << width_bits_) | count_);
  }

 private:
  static constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
  static constexpr std::int64_t least = std::numeric_limits<std::int64_t>::min();

  constexpr std::uint64_t mask() const { return low_mask(width_bits_); }

  // Divisions, because products of 64-bit numbers do not fit.
  constexpr bool is_certain(std::uint64_t step, std::uint64_t missed) const {
    if (step == half_ || too_fast_) return false;
    if (step != 0 && (step - 1) / max_step_ > missed) return false;
    return missed == 0 || missed < (half_ - 1) / max_step_;
  }

  std::uint64_t half_;
  std::uint64_t max_step_;
  std::uint64_t count_ = 0;
  std::int64_t turns_ = 0;
  unsigned width_bits_;
  bool too_fast_;
  TurnState state_ = TurnState::empty;
};

}  // namespace biss
