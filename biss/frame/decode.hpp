// Bits to frame. The same function reads the bits of a capture and of an SPI buffer.
#pragma once

#include <cstddef>
#include <cstdint>

#include "biss/base/bits.hpp"
#include "biss/base/result.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/frame.hpp"

namespace biss {

/// Where a frame begins in a run of bits.
struct FrameStart {
  std::size_t start_bit = 0;  ///< index of START
  std::uint16_t lead_clocks = 0;
  std::uint16_t ack_clocks = 0;
};

/// Finds ACK and START.
/// \param bits SLO once a MA clock from the first on: ones (LAT, line delay), zeros (ACK), START, …
/// \return the place of START, or no_response, not_ready, response_range, no_start, ack_range
constexpr Result<FrameStart, FrameFault> find_start(BitView bits, const FrameBounds& bounds) {
  const std::size_t ack = bits.find(false, 0);
  if (ack == bits.size_bits()) return failure(FrameFault{FrameError::no_response});
  if (ack == 0) return failure(FrameFault{FrameError::not_ready});
  if (ack < bounds.lead_min_clocks || ack > bounds.lead_max_clocks) {
    return failure(FrameFault{FrameError::response_range});
  }
  const std::size_t start = bits.find(true, ack);
  if (start == bits.size_bits()) return failure(FrameFault{FrameError::no_start});
  const std::size_t ack_clocks = start - ack;
  if (ack_clocks < bounds.ack_min_clocks || ack_clocks > bounds.ack_max_clocks) {
    return failure(FrameFault{FrameError::ack_range});
  }
  return FrameStart{start, static_cast<std::uint16_t>(ack), static_cast<std::uint16_t>(ack_clocks)};
}

/// Reads CDS, the channels and STOP behind a START that was found.
/// \return the frame, or truncated, cds, crc, stop_bit. Bits that end before STOP are no fault.
template <class Codec>
constexpr Result<Frame, FrameFault> decode_payload(BitView bits, const FrameStart& start,
                                                   const Codec& codec) {
  const FrameFormat& format = codec.format();
  std::size_t at = start.start_bit + 2;
  const std::size_t stop = at + codec.payload_bits();
  if (stop > bits.size_bits()) return failure(FrameFault{FrameError::truncated});
  Frame frame;
  frame.cds = bits.bit(at - 1);
  if (frame.cds && format.cds0) return failure(FrameFault{FrameError::cds});
  frame.channel_count = format.channel_count;
  frame.lead_clocks = start.lead_clocks;
  frame.ack_clocks = start.ack_clocks;
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    const std::uint64_t data = bits.word(at, channel.data_bits);
    at += channel.data_bits;
    if (channel.crc.present()) {
      if (bits.word(at, channel.crc.width_bits) != codec.crc(k, data)) {
        return failure(FrameFault{FrameError::crc, static_cast<std::uint8_t>(k)});
      }
      at += channel.crc.width_bits;
    }
    frame.channel_list[k] = unpack(channel, data);
  }
  if (stop < bits.size_bits()) {
    if (bits.bit(stop)) return failure(FrameFault{FrameError::stop_bit});
    frame.stop_seen = true;
  }
  return frame;
}

/// Finds and reads a frame.
/// \param bits as for find_start(); they may go on behind STOP
/// \return the frame, or the first cause on the line why there is none (any FrameError)
template <class Codec>
constexpr Result<Frame, FrameFault> decode_frame(BitView bits, const Codec& codec,
                                                 const FrameBounds& bounds = {}) {
  const auto start = find_start(bits, bounds);
  if (!start.ok()) return failure(start.error());
  return decode_payload(bits, *start, codec);
}

}  // namespace biss
