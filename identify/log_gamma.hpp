// The logarithm of the gamma function. That of the C++ library writes a global variable for the sign, so
// that two threads race.
#pragma once

#include <math.h>

namespace biss::identify {

inline double log_gamma(double x) {
  int sign = 0;
  return ::lgamma_r(x, &sign);
}

}  // namespace biss::identify
