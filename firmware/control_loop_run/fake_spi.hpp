// A software model of an SPI peripheral with DMA and an encoder: QEMU has none that could read a
// BiSS frame. The axis turns back and forth across zero, and the line is damaged.
#pragma once

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

  void step();
};

class FakeSpi {
 public:
  /// Implements the concept SpiDma.
  bool start(std::span<std::uint8_t> receive);

  /// The hardware's part: answers the request, writes the buffer, raises the DMA interrupt. Nothing
  /// happens without a request.
  void finish_transfer(const Axis& axis, Damage damage, std::uint64_t random);

 private:
  std::span<std::uint8_t> receive_{};
};

}  // namespace control_loop_run
