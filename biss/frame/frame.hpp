// The values of a frame, or the cause why there is no frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/frame/format.hpp"
#include "biss/frame/status.hpp"

namespace biss {

/// The values of one channel.
struct Channel {
  /// Unsigned, the channel's position_bits() wide; multiturn above singleturn. 0 when it carries
  /// none.
  std::uint64_t position = 0;
  /// Sign-of-life counter, 0 when the channel carries none.
  std::uint32_t life_counter = 0;
  /// Low-active: false = error, the position must not be used. True when the channel has no such
  /// bit.
  bool nE = true;
  /// Low-active: false = warning. True when the channel has no such bit.
  bool nW = true;

  constexpr bool operator==(const Channel&) const = default;
};

/// A frame with good structure and good checksums, with room for `Channels` channels.
template <std::size_t Channels>
struct BasicFrame {
  std::array<Channel, Channels> channel_list{};
  std::uint8_t channel_count = 0;
  bool cds = false;
  /// The bits include the STOP bit (which is then 0).
  bool stop_seen = false;
  /// Ones before ACK, and zeros of ACK, both in MA clocks.
  std::uint16_t lead_clocks = 0;
  std::uint16_t ack_clocks = 0;

  constexpr std::span<const Channel> channels() const& {
    return std::span<const Channel>(channel_list).first(channel_count);
  }
  /// The channels would not outlive a temporary frame.
  void channels() const&& = delete;
  /// The position may be used: structure and CRC are good (otherwise there is no frame) and no
  /// channel reports an error. The all-zero "no data" word has a valid CRC; only nE shows it.
  constexpr bool trusted() const {
    for (const Channel& channel : channels()) {
      if (!channel.nE) return false;
    }
    return true;
  }
};

/// A frame of any format. A codec's Frame has room for the codec's channels only.
using Frame = BasicFrame<max_channels>;

/// The cause, and its channel (0 if the channel does not matter).
struct FrameFault {
  FrameError cause{};
  std::uint8_t channel = 0;

  constexpr bool operator==(const FrameFault&) const = default;
};

/// The bounds of leading ones and ACK. The defaults are the widest that BiSS C allows at 10 MHz.
struct FrameBounds {
  /// Ones before ACK as sampled: at least the LAT clock, at most LAT and 40 µs of line delay (D2).
  std::uint16_t lead_min_clocks = 1;
  std::uint16_t lead_max_clocks = 402;
  /// Zeros of ACK: at least one clock, at most 40 µs of processing time (D2).
  std::uint16_t ack_min_clocks = 1;
  std::uint16_t ack_max_clocks = 400;
  /// Zeros that may replace the first leading ones, and count with them: if an encoder is ready
  /// after a fixed time, SLO may still be low from the previous cycle.
  std::uint16_t late_max_clocks = 0;

  constexpr bool operator==(const FrameBounds&) const = default;
};

}  // namespace biss
