// The sign-of-life counters of an encoder.
#pragma once

#include <array>
#include <cstdint>

#include "biss/base/bits.hpp"
#include "biss/frame/format.hpp"

namespace biss::sim {

/// How the counters count. The documents leave range and start open; 1…63 is the default.
struct SignOfLife {
  /// The lowest value: 1 (63 is followed by 1, 0 never comes) or 0.
  std::uint8_t first = 1;
  /// The value of each channel's first frame after power-up, `first` to 63.
  std::array<std::uint8_t, max_channels> starts = all_from(1);

  static constexpr std::array<std::uint8_t, max_channels> all_from(std::uint8_t value) {
    std::array<std::uint8_t, max_channels> starts{};
    starts.fill(value);
    return starts;
  }
  constexpr unsigned period() const { return 64U - first; }

  /// \param frames since power-up, without this one
  /// \param bits of the counter; fewer than 6 show its lower bits
  constexpr std::uint32_t value(std::size_t channel, std::uint64_t frames, unsigned bits) const {
    const std::uint64_t steps = (starts[channel] - first + frames) % period();
    return static_cast<std::uint32_t>((first + steps) & low_mask(bits));
  }

  constexpr bool operator==(const SignOfLife&) const = default;
};

}  // namespace biss::sim
