// How an SPI peripheral is set up to read an encoder, and what follows for the bits it delivers;
// the picture is in biss/master/spi_read.hpp.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "biss/base/units.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"
#include "biss/timing/cable.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

/// The edge of MA the peripheral samples at; MA idles high.
enum class SpiPhase : std::uint8_t {
  sample_on_rising,   ///< CPHA = 1, SPI mode 3
  sample_on_falling,  ///< CPHA = 0, SPI mode 2: half a period less for line and encoder
};

/// What a 1 behind STOP means. The encoder keeps SLO low until its timeout, and that does not
/// expire while MA runs (except TimeoutRule::cycle, whose end is respected).
enum class SpiTail : std::uint8_t {
  must_stay_low,  ///< stop_bit: it is the rest of a frame whose START was taken too early
  ignored,        ///< for encoders that release SLO early
};

/// From MA to SLO, both at the master: cable there and back, drivers, the encoder's own delay.
struct LineDelayRange {
  Picoseconds min{};
  Picoseconds max = biss_line_delay_max;

  constexpr bool operator==(const LineDelayRange&) const = default;
};

/// How the peripheral is set up. The closer the line delay is known, the more a wrong frame stands
/// out.
struct SpiSetup {
  /// Of MA; positive.
  Picoseconds period{};
  SpiPhase phase = SpiPhase::sample_on_rising;
  LineDelayRange line_delay{};
  /// Bits in the buffer before the sample of the first clock, where a peripheral pads.
  std::uint16_t first_bit = 0;
  SpiTail tail = SpiTail::must_stay_low;

  constexpr bool operator==(const SpiSetup&) const = default;
};

namespace spi_detail {

// Zeros that may come before the leading ones: only where the encoder is ready after a fixed time;
// then those that are sampled within the line delay, at most that of 100 m of cable, and never so
// many that START could be taken for a leading one.
constexpr std::int64_t late_max_clocks(const SpiSetup& setup, const DeviceTiming& timing,
                                       const FrameBounds& bounds) {
  if (timing.timeout.rule != TimeoutRule::cycle) return 0;
  const Picoseconds longest =
      std::min(setup.line_delay.max, line_delay(metres(100), timing.internal_delay_max));
  const Picoseconds early =
      setup.phase == SpiPhase::sample_on_falling ? setup.period : setup.period / 2;
  return std::min<std::int64_t>((longest + early).count / setup.period.count,
                                bounds.lead_min_clocks + bounds.ack_min_clocks - 1);
}

}  // namespace spi_detail

/// What may come before the data: leading ones of this phase and line delay, ACK of this device;
/// where it is ready after a fixed time, zeros of the cycle before. \pre period is positive,
/// line_delay.min <= line_delay.max, neither is negative
constexpr FrameBounds spi_bounds(const SpiSetup& setup, const DeviceTiming& timing) {
  constexpr std::int64_t most = FrameBounds{}.lead_max_clocks;
  const Picoseconds early =
      setup.phase == SpiPhase::sample_on_falling ? setup.period / 2 : Picoseconds{};
  const std::int64_t longest =
      std::min(2 + (setup.line_delay.max + early).count / setup.period.count, most);
  const std::int64_t shortest = std::clamp<std::int64_t>(
      1 + clocks_to_cover(setup.line_delay.min + early, setup.period), 2, longest);
  const AckBounds ack = ack_bounds(timing, setup.period);
  FrameBounds bounds{.lead_min_clocks = static_cast<std::uint16_t>(shortest),
                     .lead_max_clocks = static_cast<std::uint16_t>(longest),
                     .ack_min_clocks = ack.min_clocks,
                     .ack_max_clocks = ack.max_clocks};
  bounds.late_max_clocks =
      static_cast<std::uint16_t>(spi_detail::late_max_clocks(setup, timing, bounds));
  return bounds;
}

/// Clocks of MA that reach STOP at the longest line delay and the longest ACK.
constexpr std::size_t spi_clocks(const FrameFormat& format, const SpiSetup& setup,
                                 const DeviceTiming& timing) {
  const FrameBounds bounds = spi_bounds(setup, timing);
  // START, CDS, STOP.
  return std::size_t{bounds.lead_max_clocks} + bounds.ack_max_clocks + 3U + format.payload_bits();
}

/// Bytes to transfer for spi_clocks(), padding included.
constexpr std::size_t spi_bytes(const FrameFormat& format, const SpiSetup& setup,
                                const DeviceTiming& timing) {
  return (setup.first_bit + spi_clocks(format, setup, timing) + 7U) / 8U;
}

}  // namespace biss
