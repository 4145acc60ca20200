// How sure a share is that was counted.
#pragma once

#include <algorithm>
#include <cmath>

namespace biss::lab {

/// Of the normal distribution: 95 % lie within so many standard deviations, either way.
inline constexpr long double two_sided_95 = 1.959963985L;

struct ShareLimits {
  long double low = 0;
  long double high = 1;
};

/// Wilson's interval: limits that hold with 95 %, for no events and few as well.
/// \param share events by trials \param trials above 0
inline ShareLimits wilson_limits(long double share, long double trials) {
  const long double z2 = two_sided_95 * two_sided_95;
  const long double middle = (share + z2 / (2 * trials)) / (1 + z2 / trials);
  const long double half = two_sided_95 / (1 + z2 / trials) *
                           std::sqrt(share * (1 - share) / trials + z2 / (4 * trials * trials));
  return {share == 0 ? 0 : std::max(0.0L, middle - half), std::min(1.0L, middle + half)};
}

}  // namespace biss::lab
