// Counts by cause.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "biss/base/language.hpp"
#include "biss/frame/frame.hpp"

namespace biss {

/// A counter for each cause of an enumeration: FrameError, SafetyVerdict. The index is a cause and
/// not a number, because the values of SafetyVerdict are not 0, 1, 2, …
///
/// index_of() of the enumeration numbers the causes, and returns their number for a value that is
/// not a cause. All such values share one further counter.
template <class Cause>
class CauseCounts {
 public:
  /// The number of causes.
  static constexpr std::size_t size =
      index_of(static_cast<Cause>(std::numeric_limits<std::underlying_type_t<Cause>>::max()));

  /// A counter stops at its largest value.
  constexpr void add(Cause cause) {
    std::uint32_t& count = counts_[index_of(cause)];
    if (count != std::numeric_limits<std::uint32_t>::max()) ++count;
  }
  constexpr std::uint32_t operator[](Cause cause) const { return counts_[index_of(cause)]; }

 private:
  std::array<std::uint32_t, size + 1> counts_{};
};

/// The results of one encoder's cycles, counted.
struct CycleCounts {
  /// Cycles with an answer or a cause.
  std::uint32_t cycles = 0;
  /// Cycles with a frame.
  std::uint32_t good = 0;
  /// Requests that were not made, because the previous transfer had not ended.
  std::uint32_t late = 0;
  /// Requests whose transfer never reported its end.
  std::uint32_t unanswered = 0;
  /// Reported ends of transfers without a waiting request. They are ignored.
  std::uint32_t unexpected = 0;
  CauseCounts<FrameError> causes{};
};

}  // namespace biss
