// Distances of clock edges: the usual one, and irregular ones.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "biss/base/units.hpp"

namespace biss::decode {

// A distance of rising edges outside these shares of the usual one means that there is an edge too
// few or too many: a lost edge doubles it, an extra one leaves at most half. The range between them
// is the jitter of a capture with only two samples per period.
inline constexpr std::int64_t irregular_above_percent = 160;
inline constexpr std::int64_t irregular_below_percent = 55;

constexpr bool irregular(Picoseconds interval, Picoseconds usual) {
  // 12 hours: longer distances are treated as equal, and the products below fit.
  constexpr std::int64_t longest = std::numeric_limits<std::int64_t>::max() / 200;
  const std::int64_t count = std::min(interval.count, longest);
  const std::int64_t expected = std::min(usual.count, longest);
  return count * 100 > expected * irregular_above_percent ||
         count * 100 < expected * irregular_below_percent;
}

inline Picoseconds median(std::vector<Picoseconds>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace biss::decode
