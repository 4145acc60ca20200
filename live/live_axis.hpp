// The axes of a live line: biss/axis for a format that is known at run time only.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <utility>

#include "biss/axis/axis.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss::live {

/// The longest transfer that the axes read.
inline constexpr std::size_t transfer_bytes_max = 512;

/// An axis whose turns are lost, or that has tripped, starts again with the next transfer: turns from
/// 0, no position before two frames agree. A drive would have to stop first; a display does not.
class LiveAxis {
 public:
  virtual ~LiveAxis() = default;

  /// \param setups one for each channel. Without a step limit, the turns are lost at each bad cycle
  /// \return the axes, or why the format cannot be read
  static tl::expected<std::unique_ptr<LiveAxis>, std::string> make(
      const FrameFormat& format, const DeviceTiming& timing, const SpiSetup& spi,
      std::span<const AxisSetup> setups);

  /// The bytes that a transfer needs.
  virtual std::size_t bytes() const = 0;
  /// A transfer that began at `now`; no bytes: it failed.
  virtual void take(Picoseconds now, std::span<const std::uint8_t> received) = 0;
  virtual std::size_t axes() const = 0;
  virtual AxisPosition position(std::size_t k) const = 0;
  /// The last good frame.
  virtual const std::optional<Frame>& frame() const = 0;
  virtual std::uint32_t count(std::size_t k, AxisCause cause) const = 0;
  /// EncoderAxis::line_delay_seen().
  virtual std::optional<std::pair<std::uint16_t, std::uint16_t>> line_delay_seen() const = 0;
};

}  // namespace biss::live
