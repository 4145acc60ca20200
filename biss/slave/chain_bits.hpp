// What a chained slave has heard from its predecessor and not yet passed on.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "biss/frame/format.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

/// Enough for CDS and the widest payload of all others, behind a START that had to wait as long as
/// BiSS C allows. A power of two.
inline constexpr std::size_t slave_chain_bits = 1024;
static_assert(slave_chain_bits >= 1 + (max_channels - 1) * max_channel_bits + biss_ack_max_clocks);

namespace slave_detail {

/// From START on first in, first out; a full one drops what comes, an empty one gives 0, as a line
/// after STOP.
template <std::size_t CapacityBits>
class ChainBits {
  static_assert(CapacityBits % 32 == 0);

 public:
  constexpr void clear() {
    first_ = size_ = 0;
    heard_ = Heard::nothing;
  }

  /// SLI as it is at a falling edge. START is the first 1 behind a 0; it is made anew, not stored.
  constexpr void hear(bool sli) {
    if (heard_ == Heard::start) {
      push(sli);
    } else if (!sli) {
      heard_ = Heard::ack;
    } else if (heard_ == Heard::ack) {
      heard_ = Heard::start;
    }
  }
  constexpr bool started() const { return heard_ == Heard::start; }

  constexpr bool pop() {
    if (size_ == 0) return false;
    const std::size_t at = first_;
    first_ = (first_ + 1U) % CapacityBits;
    --size_;
    return ((words_[at / 32U] >> (at % 32U)) & 1U) != 0;
  }

 private:
  // What the predecessor has sent.
  enum class Heard : std::uint8_t { nothing, ack, start };

  constexpr void push(bool bit) {
    if (size_ == CapacityBits) return;
    const std::size_t at = (first_ + size_++) % CapacityBits;
    const std::uint32_t mask = std::uint32_t{1} << (at % 32U);
    std::uint32_t& word = words_[at / 32U];
    word = bit ? word | mask : word & ~mask;
  }

  std::array<std::uint32_t, CapacityBits / 32U> words_{};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  Heard heard_ = Heard::nothing;
};

/// A slave that stands alone has none.
template <>
class ChainBits<0> {
 public:
  constexpr void clear() {}
  constexpr void hear(bool) {}
  constexpr bool started() const { return false; }
  constexpr bool pop() { return false; }
};

}  // namespace slave_detail

}  // namespace biss
