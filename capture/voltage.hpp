// Voltage as a type.
#pragma once

#include <compare>
#include <cstdint>

namespace biss::capture {

/// A voltage in nanovolts.
struct Nanovolts {
  std::int64_t count = 0;

  constexpr auto operator<=>(const Nanovolts&) const = default;
};

constexpr Nanovolts millivolts(std::int64_t n) { return {n * 1'000'000}; }

}  // namespace biss::capture
