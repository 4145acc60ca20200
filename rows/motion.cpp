#include "rows/motion.hpp"

#include <algorithm>

namespace biss::rows {

namespace {

std::uint64_t usual_step(unsigned position_bits) {
  constexpr unsigned share_bits = 5;
  return std::uint64_t{1} << (std::max(position_bits, share_bits) - share_bits);
}

}  // namespace

Motion::Motion(unsigned position_bits, std::optional<std::uint64_t> max_step, bool unwrap,
               std::optional<Scale> scale)
    : position_bits_(position_bits),
      max_step_(max_step.value_or(usual_step(position_bits))),
      unwrapped_(position_bits, max_step_),
      step_(unwrapped_),
      unwrap_(unwrap),
      scale_(std::move(scale)) {}

MotionValues Motion::take(Picoseconds time, std::optional<std::uint64_t> position) {
  if (!position) {
    ++missed_;
    return {};
  }
  MotionValues values;
  unwrapped_.update(*position, missed_);
  if (!lost()) values.unwrapped = unwrapped_.position();
  if (scale_ && unwrap_ && values.unwrapped) {
    values.scaled = static_cast<double>(*values.unwrapped) * scale_->per_count;
  } else if (scale_ && !unwrap_) {
    values.scaled = static_cast<double>(*position) * scale_->per_count;
  }
  values.velocity = velocity(time, *position);
  last_time_ = time;
  missed_ = 0;
  return values;
}

std::optional<double> Motion::velocity(Picoseconds time, std::uint64_t position) {
  // In the shorter direction: the difference of that many bits, with its sign.
  const unsigned unused_bits = 64U - position_bits_;
  const auto difference =
      static_cast<std::int64_t>((position - step_.count()) << unused_bits) >> unused_bits;
  const bool is_first = step_.state() == TurnState::empty;
  const bool certain = step_.update(position, missed_) == TurnState::tracked && time > last_time_;
  step_.restart();
  step_.update(position);
  if (!certain) {
    if (!is_first) ++uncertain_;
    return std::nullopt;
  }
  const double seconds =
      static_cast<double>((time - last_time_).count) / static_cast<double>(picoseconds_per_second);
  return static_cast<double>(difference) * (scale_ ? scale_->per_count : 1.0) / seconds;
}

}  // namespace biss::rows
