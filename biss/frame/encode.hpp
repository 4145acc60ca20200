// Encodes a frame to bits: the bits that an encoder sends on SLO.
#pragma once

#include <cstddef>
#include <cstdint>

#include "biss/base/bit_buffer.hpp"
#include "biss/base/result.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/frame.hpp"

namespace biss {

/// Why values do not fit a format.
enum class EncodeError : std::uint8_t {
  channel_count,       ///< the frame has a different number of channels than the format
  position_too_large,  ///< a position does not fit its channel
  life_counter_too_large,
  ack_range,       ///< ACK of 0 clocks, or of more clocks than 40 µs have at 10 MHz
  lead_range,      ///< more leading ones than the longest line delay makes
  needs_previous,  ///< the format's CRC belongs to the previous frame (CrcSpec::of_previous)
};

/// The bits from the first clock to STOP at the longest ACK and the longest line delay.
inline constexpr std::size_t max_frame_bits =
    FrameBounds{}.lead_max_clocks + FrameBounds{}.ack_max_clocks + 2 + max_payload_bits + 1;

using FrameBits = BitBuffer<max_frame_bits>;

/// SLO once per MA clock: `frame.lead_clocks` ones, `frame.ack_clocks` zeros, START, `frame.cds`,
/// each channel with its CRC, STOP. decode_frame() of these bits returns the same frame if there is
/// a leading one (a line that begins with ACK is `not_ready`) and the format allows the value of
/// CDS.
/// \return the bits, or the cause why the values do not fit
template <std::size_t Channels, class Codec>
constexpr Result<FrameBits, EncodeError> encode_frame(const BasicFrame<Channels>& frame,
                                                      const Codec& codec) {
  const FrameFormat& format = codec.format();
  if (frame.channel_count != format.channel_count || frame.channel_count > Channels) {
    return failure(EncodeError::channel_count);
  }
  if (format.needs_previous()) return failure(EncodeError::needs_previous);
  if (frame.ack_clocks == 0 || frame.ack_clocks > FrameBounds{}.ack_max_clocks) {
    return failure(EncodeError::ack_range);
  }
  if (frame.lead_clocks > FrameBounds{}.lead_max_clocks) return failure(EncodeError::lead_range);
  // The one object that is returned, so that it is built in the caller's memory.
  Result<FrameBits, EncodeError> result = FrameBits();
  FrameBits& bits = result.value();
  bits.append_run(true, frame.lead_clocks);
  bits.append_run(false, frame.ack_clocks);
  bits.append(frame.cds ? 3U : 2U, 2);
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    const Channel& values = frame.channel_list[k];
    if ((values.position & ~low_mask(channel.position_bits())) != 0) {
      return failure(EncodeError::position_too_large);
    }
    if ((values.life_counter & ~low_mask(channel.life_counter.bits)) != 0) {
      return failure(EncodeError::life_counter_too_large);
    }
    const std::uint64_t data = pack(channel, values);
    bits.append(data, channel.data_bits);
    if (channel.crc.present()) bits.append(codec.crc(k, data, frame.cds), channel.crc.width_bits);
  }
  bits.append_run(false, 1);
  return result;
}

}  // namespace biss
