// How an encoder and its master behave in time, as a capture shows it.
#pragma once

#include <optional>

#include "biss/timing/device_timing.hpp"
#include "decode/cycle.hpp"
#include "decode/distribution.hpp"

namespace biss::verbs {

/// The rule by which the encoder releases SLO after a frame: the one that fits best. If the clock
/// and the length of the frames do not change, several rules fit.
class ReleaseRule {
 public:
  void add(const decode::Cycle& cycle) {
    if (!cycle.release || !cycle.line_delay || !cycle.period) return;
    const Picoseconds after_clock = *cycle.release - *cycle.line_delay;
    if (after_clock.count < 0) return;
    after_clock_.add(after_clock.count);
    in_periods_.add(after_clock.count * 1000 / cycle.period->count);
    after_begin_.add((cycle.clocked + after_clock).count);
  }

  /// From the last edge of MA to SLO, at the encoder.
  const decode::Distribution& after_clock() const { return after_clock_; }

  /// The rule, if only one of the three fits.
  std::optional<Timeout> rule() const {
    if (after_clock_.count() < least_frames) return std::nullopt;
    const bool fixed = is_constant(after_clock_);
    const bool cycle = is_constant(after_begin_);
    // 1.5 periods, and up to three clocks of the encoder.
    const bool adaptive =
        is_constant(in_periods_) && in_periods_.median() >= 1400 && in_periods_.median() <= 3000;
    if (int{fixed} + int{cycle} + int{adaptive} != 1) return std::nullopt;
    if (adaptive) return Timeout{TimeoutRule::adaptive, {}};
    if (fixed) return Timeout{TimeoutRule::fixed, picoseconds(after_clock_.median())};
    return Timeout{TimeoutRule::cycle, picoseconds(after_begin_.median())};
  }

 private:
  static constexpr std::uint64_t least_frames = 8;

  static bool is_constant(const decode::Distribution& values) {
    return 50 * (values.max() - values.min()) <= values.median();
  }

  decode::Distribution after_clock_;
  // Thousandths of a period.
  decode::Distribution in_periods_;
  decode::Distribution after_begin_;
};

}  // namespace biss::verbs
