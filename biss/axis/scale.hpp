// From counts to the unit of a machine, without floating point.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "biss/base/language.hpp"

namespace biss {

/// counts × numerator / denominator, rounded to the nearest number, halves up.
///
///   constexpr AxisScale microdegrees{360'000'000, 1 << 26};  // an encoder of 26 bits per turn
///   const auto angle = microdegrees(axis.position().position);
struct AxisScale {
  /// Both are positive.
  std::int32_t numerator = 1;
  std::int32_t denominator = 1;

  /// \return nothing if the result does not fit, or if the scale is not positive
  constexpr std::optional<std::int64_t> operator()(std::int64_t counts) const {
    if (numerator <= 0 || denominator <= 0) return std::nullopt;
    std::int64_t whole = counts / denominator;
    std::int64_t rest = counts % denominator;
    if (rest < 0) {
      rest += denominator;
      --whole;
    }
    // Below 2^31: the rest is below the denominator.
    const std::int64_t part = (rest * numerator + denominator / 2) / denominator;
    constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
    if (whole > (most - part) / numerator || whole < -(most / numerator)) return std::nullopt;
    return whole * numerator + part;
  }
};

}  // namespace biss
