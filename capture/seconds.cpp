#include "capture/seconds.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace biss::capture {
namespace {

__extension__ using Wide = unsigned __int128;

// A second is 2^12 times this in picoseconds.
constexpr std::uint64_t five_to_12 = 244'140'625;

}  // namespace

Result<Picoseconds, CaptureCause> picoseconds_of(double seconds) {
  if (!std::isfinite(seconds)) return failure(CaptureCause::malformed);
  // |seconds| = mantissa * 2^exponent, with a mantissa of 53 bits.
  int exponent = 0;
  const double fraction = std::frexp(std::fabs(seconds), &exponent);
  const auto mantissa = static_cast<std::uint64_t>(std::ldexp(fraction, 53));
  if (mantissa == 0) return Picoseconds{};
  const int shift = 53 - 12 - exponent;
  if (shift <= 0) return failure(CaptureCause::time_out_of_range);
  if (shift > 127) return Picoseconds{};
  const Wide product = static_cast<Wide>(mantissa) * five_to_12;
  const Wide rounded = (product + (static_cast<Wide>(1) << (shift - 1))) >> shift;
  if (rounded > static_cast<Wide>(std::numeric_limits<std::int64_t>::max())) {
    return failure(CaptureCause::time_out_of_range);
  }
  const auto count = static_cast<std::int64_t>(rounded);
  return Picoseconds{std::signbit(seconds) ? -count : count};
}

Picoseconds period_of_rate(double rate) {
  const auto longest = static_cast<double>(picoseconds_per_second);
  return Picoseconds{static_cast<std::int64_t>(std::ceil(std::min(longest / rate, longest)))};
}

Hertz whole_rate(double rate) {
  const bool whole = rate >= 1 && rate <= hertz_max.count && std::floor(rate) == rate;
  return whole ? Hertz{static_cast<std::uint32_t>(rate)} : Hertz{};
}

double seconds_of(Picoseconds time) {
  // Both numbers are exact in a long double, so that only the division and the result round.
  return static_cast<double>(static_cast<long double>(time.count) /
                             static_cast<long double>(picoseconds_per_second));
}

}  // namespace biss::capture
