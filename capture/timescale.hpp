// Ticks of a simulator's file to picoseconds.
#pragma once

#include <cstdint>
#include <limits>

#include "biss/base/units.hpp"

namespace biss::capture {

/// A tick in picoseconds: a whole factor, or for femtoseconds and less a divisor.
struct Timescale {
  std::uint64_t factor = 0;  ///< picoseconds a tick; 0 while no time scale is known
  std::uint64_t divisor = 1;

  bool known() const { return factor != 0; }
  /// The last tick that picoseconds can hold.
  std::uint64_t last_tick() const {
    if (divisor != 1) return std::numeric_limits<std::uint64_t>::max();
    return static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()) / factor;
  }
  /// \pre ticks <= last_tick(). Halves are rounded up.
  Picoseconds time_of(std::uint64_t ticks) const {
    if (divisor == 1) return Picoseconds{static_cast<std::int64_t>(ticks * factor)};
    const std::uint64_t round_up = ticks % divisor >= divisor / 2 ? 1 : 0;
    return Picoseconds{static_cast<std::int64_t>(ticks / divisor + round_up)};
  }

  bool operator==(const Timescale&) const = default;
};

}  // namespace biss::capture
