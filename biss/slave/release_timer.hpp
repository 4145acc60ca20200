// When a frame is over: the three rules for the timeout as one, "not before `floor`, and not sooner
// after the last edge of MA than `wait`".
#pragma once

#include <algorithm>
#include <cstdint>

#include "biss/base/units.hpp"
#include "biss/slave/slave_timing.hpp"

namespace biss::slave_detail {

class ReleaseTimer {
 public:
  /// A request begins: MA's period is not known yet.
  constexpr void begin(const SlaveTiming& timing, Picoseconds now) {
    restart(timing, now);
    wait_ = Picoseconds{};
    if (timing.timeout.rule == TimeoutRule::fixed) wait_ = timing.timeout.time;
    if (timing.timeout.rule == TimeoutRule::adaptive) wait_ = timing.static_timeout;
  }

  /// The second rising edge of MA, 1.5 periods after the begin.
  constexpr void measure(const SlaveTiming& timing, Picoseconds now) {
    reference_ = std::min(now - floor_begin_, timing.static_timeout);
    // Renishaw's sheet does not say what comes behind a frame that is longer than the cycle; STOP
    // must be seen there, too.
    if (timing.timeout.rule == TimeoutRule::cycle) wait_ = reference_;
    if (timing.timeout.rule == TimeoutRule::adaptive) {
      wait_ = std::min(reference_ + timing.timeout.time, timing.static_timeout);
    }
  }

  /// The time of a cycle counts from here.
  constexpr void restart(const SlaveTiming& timing, Picoseconds now) {
    floor_begin_ = now;
    floor_ = timing.timeout.rule == TimeoutRule::cycle ? now + timing.timeout.time : now;
  }

  /// The end of the frame when no edge follows this one.
  constexpr Picoseconds after(Picoseconds edge) const { return std::max(floor_, edge + wait_); }
  /// The same, where the end without this edge is known.
  constexpr void extend(Picoseconds& end, Picoseconds edge) const {
    const std::int64_t extended = edge.count + wait_.count;
    if (extended > end.count) [[unlikely]]
      end.count = extended;
  }
  /// 1.5 periods of MA.
  constexpr Picoseconds reference() const { return reference_; }

 private:
  Picoseconds floor_{};
  Picoseconds wait_{};
  Picoseconds floor_begin_{};
  Picoseconds reference_{};
};

}  // namespace biss::slave_detail
