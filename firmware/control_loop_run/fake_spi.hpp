// A software model of an SPI peripheral with DMA and an encoder: QEMU has none that could read a
// BiSS frame. The axis turns back and forth across zero, and the line is damaged.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/encode.hpp"
#include "biss/master/spi_read.hpp"

namespace control_loop_run {

inline constexpr biss::CatalogueEntry encoder = biss::catalogue_encoder("resolute-26");
inline constexpr biss::Picoseconds ma_period = biss::period_of(biss::megahertz(10));
inline constexpr biss::SpiSetup setup{.period = ma_period,
                                      .line_delay = {.max = biss::nanoseconds(700)}};
using Codec = biss::FrameCodec<biss::CrcFast, 1>;
inline constexpr Codec codec{encoder.frame_format()};

/// The damage to a cycle on the line.
enum class Damage : std::uint8_t {
  none,
  flips,      ///< one or two bits of data and CRC
  pulled,     ///< SLO goes high in the middle of the data and stays
  unplugged,  ///< SLO is high throughout
  stuck_low,  ///< SLO is low throughout
  error_bit,  ///< a good frame with nE = 0
};

/// The axis: its speed changes by `acceleration` a cycle, up and down between plus and minus
/// `top_speed` counts a cycle.
struct Axis {
  static constexpr std::int64_t top_speed = 1'500'000;
  static constexpr std::int64_t acceleration = 4'000;

  /// Far enough from zero that the first sample is in turn 0, in which counting begins.
  std::int64_t position = 5'000'000;
  std::int64_t speed = -top_speed / 2;
  bool upwards = true;

  void step() {
    position += speed;
    speed += upwards ? acceleration : -acceleration;
    if (speed >= top_speed) upwards = false;
    if (speed <= -top_speed) upwards = true;
  }
};

inline constexpr unsigned word_bits = codec.payload_bits();

// Software pends the interrupt in place of the DMA controller, by NVIC_ISPR0.
inline void raise_dma_interrupt() { *reinterpret_cast<volatile std::uint32_t*>(0xE000'E200U) = 1; }

inline biss::FrameBits answer(const Axis& axis, Damage damage, std::uint64_t random) {
  biss::Frame frame;
  frame.channel_count = 1;
  frame.lead_clocks = static_cast<std::uint16_t>(2U + random % 5U);
  frame.ack_clocks = static_cast<std::uint16_t>(33U + (random >> 8U) % 100U);
  frame.channel_list[0].position = static_cast<std::uint64_t>(axis.position) & biss::low_mask(26);
  frame.channel_list[0].nE = damage != Damage::error_bit;
  return biss::encode_frame(frame, codec).value();
}

inline void spoil(biss::FrameBits& bits, Damage damage, std::uint64_t random) {
  const std::size_t word = bits.size_bits() - 1U - word_bits;
  const auto first = static_cast<std::size_t>((random >> 16U) % word_bits);
  const auto second = static_cast<std::size_t>((random >> 24U) % word_bits);
  if (damage == Damage::flips) {
    bits.flip(word + first);
    if (second != first) bits.flip(word + second);
  }
  if (damage == Damage::pulled) {
    bits.truncate(word + first);
    bits.append_run(true, 400);
  }
}

class FakeSpi {
 public:
  /// Implements the concept SpiDma.
  bool start(std::span<std::uint8_t> receive) {
    if (!receive_.empty()) return false;
    receive_ = receive;
    return true;
  }

  /// The hardware's part: answers the request, writes the buffer, raises the DMA interrupt. Nothing
  /// happens without a request.
  void finish_transfer(const Axis& axis, Damage damage, std::uint64_t random) {
    if (receive_.empty()) return;
    auto bits = answer(axis, damage, random);
    spoil(bits, damage, random);
    const auto bytes = bits.bytes().first(std::min(bits.bytes().size(), receive_.size()));
    const std::uint8_t rest = damage == Damage::unplugged ? 0xFF : 0;
    std::fill(receive_.begin(), receive_.end(), rest);
    const bool answers = damage != Damage::unplugged && damage != Damage::stuck_low;
    if (answers) std::copy(bytes.begin(), bytes.end(), receive_.begin());
    receive_ = {};
    raise_dma_interrupt();
  }

 private:
  std::span<std::uint8_t> receive_{};
};

}  // namespace control_loop_run
