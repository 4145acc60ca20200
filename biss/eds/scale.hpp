// What one step of a time in the common part is worth. The document was not available: all but
// TMA's are hypotheses, kept in this one table so that they can be put right in one place.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "biss/base/units.hpp"

namespace biss {

struct EdsScale {
  std::string_view symbol{};
  /// One step.
  Picoseconds step{};
  /// No source could be read that says so.
  bool hypothesis = true;
};

/// TMA: a comment in NXP's driver (100 is 10 MHz); in these units a byte cannot name a device
/// slower than 3.9 MHz. BUSY_S is in clocks (NXP, D2) and therefore not here.
inline constexpr std::array<EdsScale, 10> eds_scales{{
    {"TMA", nanoseconds(1), false},
    {"TO_MIN", nanoseconds(250), true},
    {"TO_MAX", nanoseconds(250), true},
    {"TOS_MIN", nanoseconds(25), true},
    {"TOS_MAX", nanoseconds(25), true},
    {"TCLK_MIN", nanoseconds(1), true},
    {"TCLK_MAX", nanoseconds(1), true},
    {"TCYC", nanoseconds(250), true},
    {"TBUSY_MAX", nanoseconds(250), true},
    {"PON_DLY", milliseconds(1), true},
}};

/// The scale of a field of the common part; null where it has none.
constexpr const EdsScale* find_scale(std::string_view symbol) {
  for (const EdsScale& scale : eds_scales) {
    if (scale.symbol == symbol) return &scale;
  }
  return nullptr;
}

/// A time out of the common part: what is stored, and what that is by the table above.
struct EdsTime {
  std::uint32_t raw = 0;
  Picoseconds time{};
  bool hypothesis = true;

  constexpr bool operator==(const EdsTime&) const = default;
};

/// \pre find_scale(symbol) is not null
constexpr EdsTime eds_time(std::string_view symbol, std::uint32_t raw) {
  const EdsScale& scale = *find_scale(symbol);
  return {raw, scale.step * std::int64_t{raw}, scale.hypothesis};
}

}  // namespace biss
