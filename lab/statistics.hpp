// Confidence limits of a share that was counted, and how far a count is from the expected one.
#pragma once

#include <cstdint>

namespace biss::lab {

/// 95 % of the normal distribution lie within this many standard deviations on either side.
inline constexpr long double two_sided_95 = 1.959963985L;

struct ShareLimits {
  long double low = 0;
  long double high = 1;
};

/// Returns Wilson's interval with a confidence of 95 %. It is valid for few events and for none.
/// \param share events divided by trials \param trials above 0
ShareLimits wilson_limits(long double share, long double trials);

/// Returns by how many standard deviations `count` is above `expected`: exact by Poisson's
/// distribution up to 1000 expected events, else by the normal distribution.
/// \pre expected is above 0
/// \param variance of the count
double deviation_of(std::uint64_t count, long double expected, long double variance);

}  // namespace biss::lab
