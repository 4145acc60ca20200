// The lines of the test runs: the bits that an encoder sends during each SPI transfer, for the stubs
// of the vendors' SPI drivers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>

#include "biss/crc/engines.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"

namespace stubs {

/// `no_dma`: the transfer ends, and nothing was written.
enum class LineFault : std::uint8_t { none, no_response, crc, error_bit, no_dma };
using enum LineFault;

/// The fault of each transfer. The encoder is unplugged and plugged in again, for a short and for a
/// long time.
inline constexpr LineFault faults[] = {none,        none,        crc,    none,        error_bit,
                                       no_response, none,        no_dma, no_response, no_response,
                                       no_response, no_response, none,   none,        none};
inline unsigned transfers = 0;
inline bool done() { return transfers == std::size(faults); }

/// Fills in the bytes that the SPI received in the next transfer, number k. The position is first +
/// k.
inline void receive(std::span<std::uint8_t> bytes, const biss::FrameFormat& format,
                    std::uint64_t first, std::uint16_t ack_clocks) {
  const LineFault fault = faults[transfers];
  const std::uint64_t position = first + transfers++;
  if (fault == no_dma) return;
  std::fill(bytes.begin(), bytes.end(), fault == no_response ? 0xFF : 0);
  if (fault == no_response) return;
  biss::BasicFrame<1> frame;
  frame.channel_count = 1;
  frame.lead_clocks = 3;
  frame.ack_clocks = ack_clocks;
  frame.channel_list[0].position = position;
  frame.channel_list[0].nE = fault != error_bit;
  auto bits = biss::encode_frame(frame, biss::FrameCodec<biss::CrcBitwise, 1>(format)).value();
  if (fault == crc) bits.flip(std::size_t{3} + ack_clocks + 4U);
  const auto sent = bits.bytes().first(std::min(bits.bytes().size(), bytes.size()));
  std::copy(sent.begin(), sent.end(), bytes.begin());
}

}  // namespace stubs
