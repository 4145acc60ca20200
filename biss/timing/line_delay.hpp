// Measures the line delay: from the master's second rising edge of MA to the first falling edge of
// SLO that it receives.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/base/result.hpp"
#include "biss/base/units.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

/// Why there is no line delay.
enum class LineDelayError : std::uint8_t {
  before_request,  ///< SLO fell before the second rising edge of MA: it was not idle, or wires are
                   ///< swapped
  too_long,        ///< more than the 40 µs that BiSS C allows (D2, row 7)
  too_few,         ///< fewer measurements than requested
  jitter,          ///< a measurement is more than a quarter of a period from the mean (D2, row 8)
};

inline constexpr std::size_t line_delay_error_count = 4;

/// The name that users see: the enumerator's name.
constexpr std::string_view name_of(LineDelayError error) {
  constexpr std::array<std::string_view, line_delay_error_count> names{"before_request", "too_long",
                                                                       "too_few", "jitter"};
  return names[static_cast<std::size_t>(error)];
}

/// One measurement, 0 to 40 µs. The two times may be any.
/// \param second_rising_ma  as sent by the master
/// \param first_falling_slo as received by the master
/// \return the delay, before_request, or too_long
constexpr Result<Picoseconds, LineDelayError> measure_line_delay(Picoseconds second_rising_ma,
                                                                 Picoseconds first_falling_slo) {
  if (first_falling_slo < second_rising_ma) return failure(LineDelayError::before_request);
  // The signed difference of two times at the ends of their range does not fit.
  const std::uint64_t delay = static_cast<std::uint64_t>(first_falling_slo.count) -
                              static_cast<std::uint64_t>(second_rising_ma.count);
  if (delay > static_cast<std::uint64_t>(biss_line_delay_max.count)) {
    return failure(LineDelayError::too_long);
  }
  return picoseconds(static_cast<std::int64_t>(delay));
}

/// A line delay from several measurements.
struct LineDelay {
  Picoseconds mean{};  ///< rounded to the nearest picosecond
  Picoseconds min{};
  Picoseconds max{};
  std::uint16_t measurements = 0;

  constexpr bool operator==(const LineDelay&) const = default;
  constexpr Picoseconds spread() const { return max - min; }
};

/// Averages line delays. Texas Instruments' firmware uses 8.
class LineDelayMeter {
 public:
  static constexpr std::uint16_t usual_measurements = 8;

  /// \pre wanted is not 0
  constexpr explicit LineDelayMeter(std::uint16_t wanted = usual_measurements) : wanted_(wanted) {}

  /// Adds a result of measure_line_delay(); ignored when complete().
  /// \pre delay is 0 to 40 µs
  constexpr void add(Picoseconds delay) {
    if (complete()) return;
    min_ = count_ == 0 ? delay : std::min(min_, delay);
    max_ = count_ == 0 ? delay : std::max(max_, delay);
    sum_ += delay;
    ++count_;
  }

  constexpr bool complete() const { return count_ == wanted_; }

  /// \param period of MA, positive
  /// \return the delay, too_few, or jitter
  constexpr Result<LineDelay, LineDelayError> result(Picoseconds period) const {
    if (!complete()) return failure(LineDelayError::too_few);
    const Picoseconds mean = (sum_ + picoseconds(count_ / 2)) / count_;
    if (4 * (max_ - mean) > period || 4 * (mean - min_) > period) {
      return failure(LineDelayError::jitter);
    }
    return LineDelay{mean, min_, max_, count_};
  }

  constexpr void reset() { *this = LineDelayMeter(wanted_); }

 private:
  std::uint16_t wanted_;
  std::uint16_t count_ = 0;
  Picoseconds sum_{};
  Picoseconds min_{};
  Picoseconds max_{};
};

/// When to sample: `whole_clocks` periods and `rest` (less than a period) after the rising edge of
/// MA that produced the bit.
struct SamplingPoint {
  std::int64_t whole_clocks = 0;
  Picoseconds rest{};

  constexpr bool operator==(const SamplingPoint&) const = default;
};

/// The middle of a bit that arrives after `delay`: half a period later.
/// \pre delay is not negative, period is positive
constexpr SamplingPoint sampling_point(Picoseconds delay, Picoseconds period) {
  const std::int64_t after = delay.count + period.count / 2;
  return {after / period.count, picoseconds(after % period.count)};
}

}  // namespace biss
