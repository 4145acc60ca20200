#include "lab/statistics.hpp"

#include <math.h>

#include <algorithm>
#include <cmath>

namespace biss::lab {
namespace {

constexpr double largest_deviation = 38;

// The normal deviate that is exceeded with this probability.
double deviate(long double probability) {
  double low = 0;
  double high = largest_deviation;
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    const long double above = std::erfc(static_cast<long double>(middle) / std::sqrt(2.0L)) / 2;
    (above > probability ? low : high) = middle;
  }
  return low;
}

// std::lgamma() writes a global variable, which two threads must not.
long double log_factorial(std::uint64_t n) {
  int sign = 0;
  return ::lgammal_r(static_cast<long double>(n) + 1, &sign);
}

// P(at least `count`) by Poisson's distribution.
long double at_least(std::uint64_t count, long double mean) {
  long double term =
      std::exp(static_cast<long double>(count) * std::log(mean) - mean - log_factorial(count));
  long double sum = 0;
  for (std::uint64_t n = count; term > sum * 1e-20L; ++n) {
    sum += term;
    term *= mean / static_cast<long double>(n + 1);
  }
  return std::min(1.0L, sum);
}

long double at_most(std::uint64_t count, long double mean) {
  long double term = std::exp(-mean);
  long double sum = term;
  for (std::uint64_t n = 1; n <= count; ++n) {
    term *= mean / static_cast<long double>(n);
    sum += term;
  }
  return std::min(1.0L, sum);
}

}  // namespace

ShareLimits wilson_limits(long double share, long double trials) {
  const long double z2 = two_sided_95 * two_sided_95;
  const long double middle = (share + z2 / (2 * trials)) / (1 + z2 / trials);
  const long double half = two_sided_95 / (1 + z2 / trials) *
                           std::sqrt(share * (1 - share) / trials + z2 / (4 * trials * trials));
  return {share == 0 ? 0 : std::max(0.0L, middle - half), std::min(1.0L, middle + half)};
}

double deviation_of(std::uint64_t count, long double expected, long double variance) {
  constexpr long double many = 1000;
  if (expected > many) {
    return static_cast<double>((static_cast<long double>(count) - expected) / std::sqrt(variance));
  }
  if (static_cast<long double>(count) >= expected) return deviate(at_least(count, expected));
  return -deviate(at_most(count, expected));
}

}  // namespace biss::lab
