// Values that `biss decode` computes from the positions of channel 1: the position continued over
// the rollover, in a unit, and the velocity.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "biss/base/units.hpp"
#include "biss/turns/turn_counter.hpp"

namespace biss::rows {

/// The size of a count.
struct Scale {
  double per_count = 1;
  /// `deg` or `mm`.
  std::string unit;
};

/// Which columns a table has.
struct MotionColumns {
  bool unwrap = false;
  /// `deg` or `mm` for a scaled position.
  std::string unit;
  bool velocity = false;

  bool any() const { return unwrap || !unit.empty() || velocity; }
};

/// The values of a row; absent if there is no position, or if the distance since the last one is
/// not certain.
struct MotionValues {
  std::optional<std::int64_t> unwrapped;
  std::optional<double> scaled;
  std::optional<double> velocity;
};

class Motion {
 public:
  /// \param max_step as for TurnCounter; nullopt: a 32nd of the range
  /// \param scale without one, velocity is in counts a second
  /// \pre position_bits is 1…64, max_step is 1 or more
  Motion(unsigned position_bits, std::optional<std::uint64_t> max_step, bool unwrap,
         std::optional<Scale> scale);

  /// Takes the next row.
  MotionValues take(Picoseconds time, std::optional<std::uint64_t> position);

  /// Whether the distance to one of the positions was not certain.
  bool lost() const { return unwrapped_.state() == TurnState::ambiguous; }
  /// The number of positions whose distance was not certain; they have no velocity.
  std::uint64_t uncertain() const { return uncertain_; }
  /// The largest step from one row to the next that is certain.
  std::uint64_t max_step() const { return max_step_; }
  const std::optional<Scale>& scale() const { return scale_; }

 private:
  std::optional<double> velocity(Picoseconds time, std::uint64_t position);

  unsigned position_bits_;
  std::uint64_t max_step_;
  TurnCounter unwrapped_;
  // From the last position to this one alone.
  TurnCounter step_;
  bool unwrap_;
  std::optional<Scale> scale_;
  // Rows without a position since the last one.
  std::uint64_t missed_ = 0;
  std::uint64_t uncertain_ = 0;
  Picoseconds last_time_{};
};

}  // namespace biss::rows
