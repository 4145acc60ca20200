#include "lab/statistics.hpp"

#include <algorithm>
#include <boost/math/special_functions/erf.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>

namespace biss::lab {

ShareLimits wilson_limits(long double share, long double trials) {
  const long double z2 = two_sided_95 * two_sided_95;
  const long double middle = (share + z2 / (2 * trials)) / (1 + z2 / trials);
  const long double half = two_sided_95 / (1 + z2 / trials) *
                           std::sqrt(share * (1 - share) / trials + z2 / (4 * trials * trials));
  return {share == 0 ? 0 : std::max(0.0L, middle - half), std::min(1.0L, middle + half)};
}

double deviation_of(std::uint64_t count, long double expected, long double variance) {
  constexpr long double many = 1000;
  constexpr long double largest_deviation = 38;
  const auto events = static_cast<long double>(count);
  if (expected > many) return static_cast<double>((events - expected) / std::sqrt(variance));
  // The probability of this count or of one further away.
  const bool above = events >= expected;
  const long double tail =
      above ? boost::math::gamma_p(events, expected) : boost::math::gamma_q(events + 1, expected);
  const long double deviation =
      tail == 0 ? largest_deviation
                : std::min(largest_deviation,
                           std::sqrt(2.0L) * boost::math::erfc_inv(std::min(1.0L, 2 * tail)));
  return static_cast<double>(above ? deviation : -deviation);
}

}  // namespace biss::lab
