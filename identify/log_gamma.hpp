// The logarithm of the gamma function. The function of the C++ library writes the sign to a global
// variable, a race between two threads.
#pragma once

#include <math.h>

namespace biss::identify {

inline double log_gamma(double x) {
  int sign = 0;
  return ::lgamma_r(x, &sign);
}

}  // namespace biss::identify
