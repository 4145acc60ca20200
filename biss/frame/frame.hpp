// The values of a frame, and the causes why there is none.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "biss/frame/format.hpp"

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
  /// They would be gone with the frame.
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

/// Why the bits are not a frame: the first cause that applies, in the order on the line.
enum class FrameError : std::uint8_t {
  no_response,     ///< SLO stayed high: nothing connected, no power, or the encoder did not answer
  not_ready,       ///< SLO was low when the request began: still busy, or the line is stuck low
  response_range,  ///< ACK began earlier or later than the line delay's bounds allow
  no_start,        ///< ACK began and no START ever came
  ack_range,       ///< START came earlier or later than the ACK bounds allow
  truncated,       ///< the clock stopped before the last CRC bit
  cds,             ///< CDS was 1 and the format says it must be 0
  crc,             ///< a channel's checksum is wrong, or is that of the frame before
  stop_bit,        ///< the bit after the last CRC bit was not 0
};

inline constexpr std::size_t frame_error_count = 9;

/// The number of a cause, from 0; frame_error_count for a value that is no cause.
constexpr std::size_t index_of(FrameError error) {
  const auto index = static_cast<std::size_t>(error);
  return index < frame_error_count ? index : frame_error_count;
}

/// The name users see, the same as the enumerator's.
constexpr std::string_view name_of(FrameError error) {
  constexpr std::array<std::string_view, frame_error_count> names{
      "no_response", "not_ready", "response_range", "no_start", "ack_range", "truncated",
      "cds",         "crc",       "stop_bit"};
  return names[static_cast<std::size_t>(error)];
}

/// The cause, and its channel (0 where the channel does not matter).
struct FrameFault {
  FrameError cause{};
  std::uint8_t channel = 0;

  constexpr bool operator==(const FrameFault&) const = default;
};

/// The bounds of what precedes the data. The defaults are the widest that BiSS C allows at 10 MHz.
struct FrameBounds {
  /// Ones before ACK as sampled: at least the LAT clock, at most LAT and 40 µs of line delay (D2).
  std::uint16_t lead_min_clocks = 1;
  std::uint16_t lead_max_clocks = 402;
  /// Zeros of ACK: at least one clock, at most 40 µs of processing time (D2).
  std::uint16_t ack_min_clocks = 1;
  std::uint16_t ack_max_clocks = 400;
  /// Zeros that may replace the first leading ones, and count with them: where an encoder is ready
  /// after a fixed time, SLO may still be seen low from the previous cycle.
  std::uint16_t late_max_clocks = 0;

  constexpr bool operator==(const FrameBounds&) const = default;
};

}  // namespace biss
