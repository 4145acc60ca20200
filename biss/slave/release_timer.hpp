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
    if (timing.timeout.rule == TimeoutRule::cycle) wait_ = release_wait(timing.timeout);
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
  // As release_time(), from the 1.5 periods that were measured: half a period is a third of them. A
  // microcontroller would call a division of 64 bits; this is exact up to 2 ms.
  constexpr Picoseconds release_wait(const Timeout& timeout) const {
    const Picoseconds half{(reference_.count * 0x5555'5556) >> 32U};
    return reference_ + half * (timeout.release_half_periods - std::int64_t{3});
  }

  Picoseconds floor_{};
  Picoseconds wait_{};
  Picoseconds floor_begin_{};
  Picoseconds reference_{};
};

}  // namespace biss::slave_detail
