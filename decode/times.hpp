// Sums and differences of times that saturate at the limits of 64 bits.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "biss/base/units.hpp"

namespace biss::decode {

/// From `from` to `to`, at most an hour: no caller needs the exact value of a longer time.
/// \pre from <= to
constexpr Picoseconds elapsed(Picoseconds from, Picoseconds to) {
  constexpr std::uint64_t hour = std::uint64_t{3600} * picoseconds_per_second;
  const auto gap = static_cast<std::uint64_t>(to.count) - static_cast<std::uint64_t>(from.count);
  return Picoseconds{static_cast<std::int64_t>(std::min(gap, hour))};
}

/// `time + by`, or the end of the range if the sum lies beyond it.
constexpr Picoseconds shifted(Picoseconds time, Picoseconds by) {
  using Limits = std::numeric_limits<std::int64_t>;
  if (by.count > 0 && time.count > Limits::max() - by.count) return Picoseconds{Limits::max()};
  if (by.count < 0 && time.count < Limits::min() - by.count) return Picoseconds{Limits::min()};
  return time + by;
}

/// How many periods a time has, to the nearest whole number. \pre the period is not 0
constexpr std::int64_t periods_in(Picoseconds time, Picoseconds period) {
  return (time.count + period.count / 2) / period.count;
}

}  // namespace biss::decode
