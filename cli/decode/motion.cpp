#include "cli/decode/motion.hpp"

#include <algorithm>

namespace biss::cli {

namespace {

std::uint64_t usual_step(unsigned position_bits) {
  constexpr unsigned share_bits = 5;
  return std::uint64_t{1} << (std::max(position_bits, share_bits) - share_bits);
}

}  // namespace

Motion::Motion(unsigned position_bits, std::optional<std::uint64_t> max_step, bool unwrap,
               std::optional<Scale> scale)
    : unwrapped_(position_bits, max_step.value_or(usual_step(position_bits))),
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
  // Whole turns are left out, so that two positions are all that matters.
  const auto before = static_cast<std::int64_t>(step_.count());
  const TurnState state = step_.update(position, missed_);
  const auto after = step_.position();
  const bool certain = state == TurnState::tracked && after && time > last_time_;
  const auto steps = certain ? static_cast<std::int64_t>(static_cast<std::uint64_t>(*after) -
                                                         static_cast<std::uint64_t>(before))
                             : 0;
  step_.restart();
  step_.update(position);
  if (!certain) return std::nullopt;
  const double seconds =
      static_cast<double>((time - last_time_).count) / static_cast<double>(picoseconds_per_second);
  return static_cast<double>(steps) * (scale_ ? scale_->per_count : 1.0) / seconds;
}

}  // namespace biss::cli
