// Counts by cause.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "biss/base/language.hpp"

namespace biss {

/// A counter for each cause of an enumeration: FrameError, SafetyVerdict. The index is a cause and
/// not a number, because the values of SafetyVerdict are not 0, 1, 2, …
///
/// index_of() of the enumeration numbers the causes, and returns their number for a value that is
/// not a cause. All such values share one further counter, or the last one without it: `further`
/// is 1 or 0.
template <class Cause, std::size_t further = 1>
class CauseCounts {
 public:
  /// The number of causes.
  static constexpr std::size_t size =
      index_of(static_cast<Cause>(std::numeric_limits<std::underlying_type_t<Cause>>::max()));

  /// A counter stops at its largest value.
  constexpr void add(Cause cause) {
    std::uint32_t& count = counts_[place_of(cause)];
    if (count != std::numeric_limits<std::uint32_t>::max()) ++count;
  }
  constexpr std::uint32_t operator[](Cause cause) const { return counts_[place_of(cause)]; }

 private:
  static constexpr std::size_t places = size + further;

  static constexpr std::size_t place_of(Cause cause) {
    return std::min(index_of(cause), places - 1);
  }

  std::array<std::uint32_t, places> counts_{};
};

}  // namespace biss
