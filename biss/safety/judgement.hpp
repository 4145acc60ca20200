// What an evaluation finds in one frame, and what the monitor makes of it.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <optional>

#include "biss/base/units.hpp"
#include "biss/safety/verdict.hpp"

namespace biss {

namespace safety_detail {

// Time on a clock that wraps around.
constexpr Picoseconds elapsed(Picoseconds from, Picoseconds to) {
  const auto apart = static_cast<std::uint64_t>(to.count) - static_cast<std::uint64_t>(from.count);
  return {static_cast<std::int64_t>(apart)};
}
constexpr Picoseconds later(Picoseconds from, Picoseconds by) {
  const auto sum = static_cast<std::uint64_t>(from.count) + static_cast<std::uint64_t>(by.count);
  return {static_cast<std::int64_t>(sum)};
}

}  // namespace safety_detail

/// One evaluation of one frame, without regard to the frames before. Two of the same bits have to
/// be equal. No padding, so that two are compared in one go.
struct SafetyFinding {
  /// The CPW's. This and what follows up to `cause` is 0 (nW: true) unless both CRCs are good.
  std::uint64_t position = 0;
  /// CPW less SPW in counts of the lowest bit compared, the short way round; held at the limits of
  /// its type.
  std::int32_t difference_lsb = 0;
  std::uint8_t life_counter = 0;
  bool cpw_nW = true;
  bool spw_nW = true;
  /// no_frame … comparison, or safe.
  SafetyVerdict cause = SafetyVerdict::no_frame;

  constexpr bool operator==(const SafetyFinding& other) const {
    using Words = std::array<std::uint64_t, 2>;
    return std::bit_cast<Words>(*this) == std::bit_cast<Words>(other);
  }
};

enum class SafetyState : std::uint8_t {
  untested,  ///< self_test() has not run or has failed
  starting,  ///< fewer good frames in a row than are asked for
  safe,
  latched,  ///< after a fault, until acknowledge()
};

/// What the monitor says of one frame.
struct SafetyJudgement {
  SafetyVerdict verdict = SafetyVerdict::self_test;
  /// After this frame.
  SafetyState state = SafetyState::untested;
  /// The fault is within the budget: no position this time, but the state is still safe.
  bool tolerated = false;
  /// Low-active, told and no fault: the scale or the window needs cleaning. True where the frame
  /// gave no good words.
  bool cpw_nW = true;
  bool spw_nW = true;
  /// Of a frame with good CRCs, else 0.
  std::uint8_t life_counter = 0;
  /// CPW less SPW in counts of the lowest bit compared; the margin is the tolerance less its
  /// magnitude. 0 without good CRCs.
  std::int32_t difference_lsb = 0;
  /// The CPW's, where the verdict is safe and the judgement is a frame's; none otherwise.
  std::optional<std::uint64_t> position{};
};

}  // namespace biss
