// The limits of a device for its clock, the time between requests and its timeout. A row of `decode`
// names each limit that its cycle exceeds, whatever the status of the cycle.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "biss/base/units.hpp"
#include "biss/timing/device_timing.hpp"
#include "decode/cycle.hpp"
#include "decode/rules.hpp"

namespace biss::decode {

/// The oscillators of the master and of the analyser are off by less than a time divided by this.
inline constexpr std::int64_t oscillator_divisor = 1000;

/// Users and scripts see the names; docs/decode.md explains each.
enum class Limit : std::uint8_t {
  clock_max,     ///< the highest clock: DeviceTiming::clock_max
  clock_min,     ///< the lowest clock: DeviceTiming::clock_min
  clock_change,  ///< the largest change of a period within a request: DeviceTiming::clock_constant
  cycle_min,     ///< the shortest time between requests: DeviceTiming::cycle_min
  release,       ///< when SLO rises after the frame, too early or too late: DeviceTiming::timeout
};

inline constexpr std::size_t limit_count = static_cast<std::size_t>(Limit::release) + 1;

/// The name of its rule; `release` has two rules and therefore a separate name.
std::string_view name_of(Limit limit);

/// A set of limits: bit k is the limit of that number.
using LimitSet = std::uint8_t;
static_assert(limit_count <= 8);

constexpr LimitSet set_of(Limit limit) {
  return static_cast<LimitSet>(1U << static_cast<unsigned>(limit));
}

/// Returns the names, separated by `;`.
std::string text_of(LimitSet limits);

/// A measured time and the limit of a rule.
struct Comparison {
  Rule rule{};
  Picoseconds value{};
  Picoseconds bound{};
  /// `bound` is the longest time, not the shortest.
  bool bound_is_maximum = false;
  /// The uncertainty of the comparison: a value beyond the bound by at most this does not certainly
  /// exceed the limit.
  Picoseconds doubt{};

  bool exceeded() const { return (bound_is_maximum ? value - bound : bound - value) > doubt; }
};

/// The shortest and the longest time from the last edge of MA to the rise of SLO at the encoder, by
/// its timeout rule. A default DeviceTiming::timeout means that the rule is unknown: the times are
/// then the bounds of the fixed and of the adaptive rule together.
struct ReleaseBounds {
  Picoseconds least{};
  Picoseconds most{};
};
/// \pre the cycle has a period
ReleaseBounds release_bounds(const DeviceTiming& timing, const Cycle& cycle);
/// How uncertain Cycle::release is in a comparison with this bound: a quarter of a period, by which
/// the line delay may vary within a frame (D2, characteristics, row 8), plus the uncertainty of the
/// measurement.
/// \pre the cycle has a period
Picoseconds release_doubt(const Cycle& cycle, Picoseconds bound);

/// Compares the cycles of a capture with the limits of a device. Each cycle is passed once, in their
/// order, to compare() or to judge().
class LimitWatch {
 public:
  /// \param resolution as MarginSetup::resolution
  explicit LimitWatch(const DeviceTiming& timing, Picoseconds resolution = {})
      : timing_(timing), resolution_(resolution) {}

  /// The device has this limit. True for clock_max and clock_min.
  bool knows(Limit limit) const;

  /// Compares the next cycle with the limits for which it has a time. The comparisons are valid until
  /// the next call.
  std::span<const Comparison> compare(const Cycle& cycle);
  /// The limits that the next cycle certainly exceeds.
  LimitSet judge(const Cycle& cycle);

 private:
  void compare_clock(const Cycle& cycle);
  void compare_interval(const Cycle& cycle);
  void compare_release(const Cycle& cycle);
  void add(const Comparison& comparison) { comparisons_[count_++] = comparison; }

  DeviceTiming timing_;
  Picoseconds resolution_;
  // `count_` of the last cycle. Two are of `release`: SLO may rise too early and too late.
  std::array<Comparison, limit_count + 1> comparisons_{};
  std::size_t count_ = 0;
  // The time of the previous request; absent if it is not certain.
  std::optional<Picoseconds> last_time_;
  Picoseconds last_uncertainty_{};
};

}  // namespace biss::decode
