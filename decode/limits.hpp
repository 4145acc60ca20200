// The rules that a row of `decode` names if its cycle breaks them, for any status: the clock, the
// time between requests, the timeout.
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

/// The oscillators of the master and of the analyser are off by less than this share of a time.
inline constexpr std::int64_t oscillator_share = 1000;

/// Users and scripts see the names; docs/decode.md explains each.
enum class Limit : std::uint8_t {
  clock_max,     ///< DeviceTiming::clock_max
  clock_min,     ///< DeviceTiming::clock_min
  clock_change,  ///< DeviceTiming::clock_constant
  cycle_min,     ///< DeviceTiming::cycle_min
  release,       ///< DeviceTiming::timeout
};

inline constexpr std::size_t limit_count = 5;

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
struct LimitCase {
  Rule rule{};
  Picoseconds value{};
  Picoseconds bound{};
  /// `bound` is the longest time, not the shortest.
  bool is_longest = false;
  /// Beyond the bound by at most this, the limit is not certainly exceeded.
  Picoseconds doubt{};

  constexpr bool exceeded() const { return (is_longest ? bound - value : value - bound) < -doubt; }
};

/// The time from the last edge of MA to the rise of SLO at the encoder, by its timeout rule. With
/// the default timeout the rule is unknown: both rules are then accepted.
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

/// Compares the cycles of a capture, in their order, with the limits of a device.
class LimitWatch {
 public:
  /// \param resolution as MarginSetup::resolution
  explicit LimitWatch(const DeviceTiming& timing, Picoseconds resolution = {})
      : timing_(timing), resolution_(resolution) {}

  /// Whether the device has this limit. Clocks are always limited.
  bool knows(Limit limit) const;

  /// The limits that the next cycle can be compared with. Valid until the next call.
  std::span<const LimitCase> compare(const Cycle& cycle);
  /// Compares the next cycle. \return the limits that it certainly exceeds
  LimitSet judge(const Cycle& cycle);

 private:
  void compare_clock(const Cycle& cycle);
  void compare_interval(const Cycle& cycle);
  void compare_release(const Cycle& cycle);
  void add(const LimitCase& each) { cases_[count_++] = each; }

  DeviceTiming timing_;
  Picoseconds resolution_;
  // SLO may be released too early and too late.
  std::array<LimitCase, limit_count + 1> cases_{};
  std::size_t count_ = 0;
  // The time of the previous request.
  std::optional<Picoseconds> last_time_;
  Picoseconds last_uncertainty_{};
};

}  // namespace biss::decode
