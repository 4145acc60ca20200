// Times of a clock that wraps around at the limits of its type: a clock that runs for more than 106
// days, the range of Picoseconds.
#pragma once

#include <cstdint>

#include "biss/base/units.hpp"

namespace biss {

/// The time from `from` to `to`, which are less than 106 days apart. Negative if `to` is before
/// `from`.
constexpr Picoseconds wrapping_elapsed(Picoseconds from, Picoseconds to) {
  const auto apart = static_cast<std::uint64_t>(to.count) - static_cast<std::uint64_t>(from.count);
  return Picoseconds{static_cast<std::int64_t>(apart)};
}

/// The time that is `by` after `from`.
constexpr Picoseconds wrapping_later(Picoseconds from, Picoseconds by) {
  const auto sum = static_cast<std::uint64_t>(from.count) + static_cast<std::uint64_t>(by.count);
  return Picoseconds{static_cast<std::int64_t>(sum)};
}

}  // namespace biss
