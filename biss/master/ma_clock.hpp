// MA of one request: falls at once, or rises first where CDM was held low; runs until it is told
// where to stop; rests as CDM says.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "biss/base/units.hpp"
#include "biss/timing/step.hpp"

namespace biss {

/// The edges of MA, one at a time. Each is counted from the one before it, so that an edge made
/// late moves all that follow and no clock is ever cut short.
class MaClock {
 public:
  /// \pre low_time is above 0 and below period
  constexpr MaClock(Picoseconds period, Picoseconds low_time)
      : low_(low_time), high_(period - low_time) {}

  constexpr bool level() const { return level_; }
  /// When edge() is due; never: MA rests.
  constexpr Picoseconds next() const { return next_; }
  constexpr bool running() const { return next_ != never; }
  constexpr Picoseconds last_edge() const { return last_edge_; }
  /// Rising edges since begin(), without release().
  constexpr std::uint32_t rises() const { return rises_; }

  /// MA falls; where it is low it rises, and falls `rest` later. \pre not running()
  constexpr void begin(Picoseconds now, bool cdm, Picoseconds rest) {
    const bool held = !level_;
    release(now);
    cdm_ = cdm;
    rises_ = 0;
    last_rise_ = std::numeric_limits<std::uint32_t>::max();
    next_ = now + rest;
    if (!held) edge(now);
  }

  /// The edge that is due. \pre running()
  constexpr void edge(Picoseconds now) {
    level_ = !level_;
    last_edge_ = now;
    if (level_) {
      ++rises_;
      next_ = rises_ < last_rise_ || cdm_ ? now + high_ : never;
    } else {
      next_ = rises_ < last_rise_ ? now + low_ : never;
    }
  }

  /// MA stops with that rising edge, or as soon as it can when it is past it; for CDM 1 it falls
  /// once more.
  constexpr void stop_at(std::uint32_t rise) {
    last_rise_ = rise;
    if (rises_ >= rise && level_ && !cdm_) next_ = never;
  }

  /// As stop_at(), but no sooner than set_cdm() needs: a quarter of a period.
  constexpr void stop_in_time(std::uint32_t rise, Picoseconds now) {
    const bool soon = !level_ && next_ - now < low_ / 2;
    stop_at(std::max(rise, rises_ + (soon ? 2U : 1U)));
  }

  /// The level MA shall rest at, as long as it has not stopped.
  constexpr void set_cdm(bool cdm) { cdm_ = cdm; }

  /// MA stops as soon as it can, high.
  constexpr void abandon(Picoseconds now) {
    cdm_ = false;
    stop_at(0);
    if (!running()) release(now);
  }

  /// MA high, where CDM kept it low; no clock. \pre not running()
  constexpr void release(Picoseconds now) {
    if (level_) return;
    level_ = true;
    last_edge_ = now;
  }

 private:
  Picoseconds low_;
  Picoseconds high_;
  Picoseconds next_ = never;
  Picoseconds last_edge_{};
  std::uint32_t rises_ = 0;
  std::uint32_t last_rise_ = 0;
  bool level_ = true;
  bool cdm_ = false;
};

}  // namespace biss
