// The moments at which a sampled capture looks at its lines.
#pragma once

#include <cstdint>
#include <limits>

#include "biss/base/units.hpp"

namespace biss::capture {

/// Sample `i` is taken `i / rate` seconds after the first, rounded to the nearest picosecond. Each
/// time is computed from the index, so that rates whose period is no whole number of picoseconds
/// (3 MHz, 48 MHz) do not drift.
class SampleClock {
 public:
  /// \pre rate is not 0 Hz
  constexpr explicit SampleClock(Hertz rate)
      : rate_(rate.count), step_(second % rate.count == 0 ? second / rate.count : 0) {}

  constexpr Hertz rate() const { return {static_cast<std::uint32_t>(rate_)}; }

  /// \pre index <= last_index()
  constexpr Picoseconds time_of(std::uint64_t index) const {
    return {static_cast<std::int64_t>(count_of(index))};
  }

  /// The first sample that sees what happens at `time`: its own time is `time` or later.
  /// \pre time is not negative
  constexpr std::uint64_t first_at_or_after(Picoseconds time) const {
    const auto wanted = static_cast<std::uint64_t>(time.count);
    std::uint64_t index = whole_periods(wanted);
    // Rounding moves a sample by half a picosecond at most.
    while (index > 0 && count_of(index - 1) >= wanted) --index;
    while (count_of(index) < wanted) ++index;
    return index;
  }

  /// The last sample whose time can be told.
  constexpr std::uint64_t last_index() const {
    return whole_periods(std::numeric_limits<std::int64_t>::max());
  }

 private:
  static constexpr std::uint64_t second = picoseconds_per_second;
  // A second is a million times a million: two steps of long division need no more than 64 bits.
  static constexpr std::uint64_t million = 1'000'000;

  constexpr std::uint64_t count_of(std::uint64_t index) const {
    if (step_ != 0) return index * step_;
    const std::uint64_t scaled = index % rate_ * million;
    const std::uint64_t rest = (scaled % rate_ * million + rate_ / 2) / rate_;
    return index / rate_ * second + scaled / rate_ * million + rest;
  }

  // How often the exact period fits into that many picoseconds.
  constexpr std::uint64_t whole_periods(std::uint64_t count) const {
    const std::uint64_t rest = count % second;
    const std::uint64_t scaled = rest / million * rate_;
    const std::uint64_t below = (scaled % million * million + rest % million * rate_) / second;
    return count / second * rate_ + scaled / million + below;
  }

  std::uint64_t rate_;
  std::uint64_t step_;  // the period where it is a whole number of picoseconds, else 0
};

}  // namespace biss::capture
