// The encoders of one SPI peripheral with DMA, requested once per control period: one axis, or a
// chain with an axis for each channel.
//
//   control timer interrupt                DMA complete interrupt
//   ------------------------------------   -------------------------------
//   use position() and age(now)            axis.transfer_complete()
//   axis.request(now): SPI starts    --->    decode, turns, limits, rules
//
// Give both interrupts the same priority, so that neither interrupts the other and no lock is
// needed. The frame is decoded once, in the second interrupt, before the first one needs it.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

#include "biss/axis/axis.hpp"
#include "biss/axis/freshness.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/spi_read.hpp"

namespace biss {

/// The board's SPI peripheral: its clock is MA (idle high), its data input is SLO. DMA fills a
/// buffer without a gap between the clocks.
template <class T>
concept SpiDma = requires(T& spi, std::span<std::uint8_t> receive) {
  /// Starts a transfer of `receive.size()` bytes. The DMA uses them until the interrupt. They are
  /// ones, and must be in memory before the DMA writes: a barrier for the compiler, and with a data
  /// cache, clean the cache here and invalidate it at the end.
  /// \return false if the previous transfer has not ended; then nothing was started
  { spi.start(receive) } -> std::same_as<bool>;
};

namespace axis_detail {

// Not constexpr: the compiler prints the error of the function that a constant axis calls.
template <AxisError>
void the_axis_does_not_fit() {}

constexpr void stop_the_build(AxisError error) {
  switch (error) {
    case AxisError::reader:
      return the_axis_does_not_fit<AxisError::reader>();
    case AxisError::buffer:
      return the_axis_does_not_fit<AxisError::buffer>();
    case AxisError::format:
      return the_axis_does_not_fit<AxisError::format>();
    case AxisError::cycle:
      return the_axis_does_not_fit<AxisError::cycle>();
    case AxisError::max_step:
      return the_axis_does_not_fit<AxisError::max_step>();
    case AxisError::offset:
      return the_axis_does_not_fit<AxisError::offset>();
  }
}

}  // namespace axis_detail

/// `Reader` is a SpiReader, `max_bytes` the buffer's size: at least the reader's bytes(). `axes` is
/// the number of the format's channels. `cache_line`: with a data cache, the size of its lines; the
/// buffers then share no line with other data.
template <SpiDma Spi, class Reader, std::size_t max_bytes, std::size_t axes = 1,
          std::size_t cache_line = 4>
class EncoderAxis {
 public:
  /// All must outlive the axis; reader and setup may be in flash. The setup applies to all axes of
  /// a chain. If the parts do not fit, there is an AxisError: a constant axis does not compile; any
  /// other one is tripped from the start and has error().
  constexpr EncoderAxis(Spi& spi, const Reader& reader, const AxisSetup& setup)
      : EncoderAxis(spi, reader, same(setup)) {}
  EncoderAxis(Spi&, const Reader&, const AxisSetup&&) = delete;
  EncoderAxis(Spi&, const Reader&&, const AxisSetup&) = delete;

  EncoderAxis(Spi&, const Reader&&, const std::array<const AxisSetup*, axes>&) = delete;

  /// The same with a setup for each channel.
  constexpr EncoderAxis(Spi& spi, const Reader& reader,
                        const std::array<const AxisSetup*, axes>& setups)
      : spi_(check(reader, setups) ? nullptr : &spi),
        reader_(&reader),
        axes_(axes_of(reader, setups, spi_ != nullptr, std::make_index_sequence<axes>{})) {
    if (std::is_constant_evaluated() && spi_ == nullptr) {
      axis_detail::stop_the_build(*check(reader, setups));
    }
    reset();
  }

  // A running transfer writes to this object's buffer.
  EncoderAxis(const EncoderAxis&) = delete;
  EncoderAxis& operator=(const EncoderAxis&) = delete;

  /// Why this axis never requests a position; it is tripped from the start. Nothing if it can be
  /// used.
  constexpr std::optional<AxisError> error() const {
    std::array<const AxisSetup*, axes> setups{};
    for (std::size_t k = 0; k < axes; ++k) setups[k] = &axes_[k].setup();
    return check(*reader_, setups);
  }

  /// Starts again as after construction, also after a trip: Axis::reset(). The answer to a request
  /// from before is ignored. Call it between the two interrupts or while they are masked.
  constexpr void reset() {
    if (buffer_.end()) count(AxisCause::unanswered);
    axes_[0].delay_min_clocks = std::numeric_limits<std::uint16_t>::max();
    axes_[0].delay_max_clocks = 0;
    for (Slot& axis : axes_) {
      axis.reset();
      if (spi_ == nullptr) axis.trip();
    }
  }

  /// Requests a position. Call it once per period in the control timer's interrupt, after the use
  /// of position(). An earlier request without an answer counts as a bad cycle.
  /// \param now the time of the first falling edge of MA; it may wrap around at the limits of its
  ///   type
  constexpr void request(Picoseconds now) {
    if (spi_ == nullptr) return;
    const bool unanswered = buffer_.waits();
    const auto start = [this](std::span<std::uint8_t> receive) { return spi_->start(receive); };
    if (!buffer_.begin(reader_->bytes(), start)) [[unlikely]] {
      // A transfer that has not ended keeps the time of its own request.
      return bad(AxisCause::late, now);
    }
    if (unanswered) [[unlikely]]
      bad(AxisCause::unanswered, asked_at_);
    asked_at_ = now;
  }

  /// Decodes the transfer. Call it in the DMA's interrupt at the end of the transfer. If no request
  /// waits for it, it is ignored and counted as unexpected.
  /// \return CDS of the frame; nothing without a frame
  constexpr std::optional<bool> transfer_complete() {
    const auto received = buffer_.end();
    if (!received) [[unlikely]] {
      count(AxisCause::unexpected);
      return std::nullopt;
    }
    const auto frame = reader_->read(*received);
    if (!frame.ok()) [[unlikely]] {
      bad(cause_of(frame.error().cause), asked_at_);
      return std::nullopt;
    }
    const std::uint16_t delay = line_delay_clocks(*frame);
    Slot& first = axes_[0];
    first.delay_min_clocks = std::min(first.delay_min_clocks, delay);
    first.delay_max_clocks = std::max(first.delay_max_clocks, delay);
    for (std::size_t k = 0; k < axes; ++k) {
      axes_[k].good(frame->channel_list[k], asked_at_, buffer_.number());
    }
    return frame->cds;
  }

  /// The transfer ended with an error. Call it in the DMA's interrupt for errors.
  constexpr void transfer_failed() {
    if (!buffer_.end()) return count(AxisCause::unexpected);
    bad(AxisCause::failed, asked_at_);
  }

  /// The position for the drive, and what it is. \pre k is below `axes`
  constexpr AxisPosition position(std::size_t k = 0) const { return axes_[k].position(); }
  /// The axis of channel k, with its counts: trip(), set_turns(), counts(). Call trip() and
  /// set_turns() between the two interrupts or while they are masked. \pre k is below `axes`
  constexpr Axis& axis(std::size_t k = 0) { return axes_[k]; }
  constexpr const Axis& axis(std::size_t k = 0) const { return axes_[k]; }

  /// Whether the last request still waits for its answer: position() then belongs to an earlier
  /// request.
  constexpr bool waits() const { return buffer_.waits(); }
  /// The number of the last request, from 1; 0 before it. It wraps around.
  constexpr std::uint32_t number() const { return buffer_.number(); }

  /// The line delay of all good frames since the last reset, in whole clocks of MA: the smallest and
  /// the largest. Empty before the first one. A delay that changes by more than one clock is a fault
  /// of the line. The reader's setup can have this range, and then detects more wrong frames.
  constexpr std::optional<std::pair<std::uint16_t, std::uint16_t>> line_delay_seen() const {
    const Slot& first = axes_[0];
    if (first.delay_min_clocks > first.delay_max_clocks) return std::nullopt;
    return std::pair(first.delay_min_clocks, first.delay_max_clocks);
  }

 private:
  using Setups = std::array<const AxisSetup*, axes>;

  // The line delay of the frames, in the last bytes of an Axis, which are padding. It is the same for
  // all axes; the first one has it.
  struct Slot : Axis {
    using Axis::Axis;
    std::uint16_t delay_min_clocks = 0;
    std::uint16_t delay_max_clocks = 0;
  };

  static constexpr Setups same(const AxisSetup& setup) {
    Setups setups{};
    setups.fill(&setup);
    return setups;
  }

  static constexpr unsigned bits_of(const Reader& reader, std::size_t k) {
    return reader.codec().format().channel_list[k].position_bits();
  }

  static constexpr std::optional<AxisError> check(const Reader& reader, const Setups& setups) {
    if (reader.error()) return AxisError::reader;
    if (reader.bytes() > max_bytes) return AxisError::buffer;
    if (reader.codec().format().channel_count != axes) return AxisError::format;
    for (std::size_t k = 0; k < axes; ++k) {
      if (const auto error = check_axis(*setups[k], bits_of(reader, k))) return error;
    }
    return std::nullopt;
  }

  template <std::size_t... k>
  static constexpr std::array<Slot, axes> axes_of(const Reader& reader, const Setups& setups,
                                                  bool fits, std::index_sequence<k...>) {
    return {Slot(*setups[k], fits ? bits_of(reader, k) : 1U)...};
  }

  constexpr void count(AxisCause cause) {
    for (Axis& axis : axes_) axis.count(cause);
  }
  constexpr void bad(AxisCause cause, Picoseconds asked) {
    for (Axis& axis : axes_) axis.bad(cause, asked);
  }

  Spi* spi_;
  const Reader* reader_;
  Picoseconds asked_at_{};  // of the last transfer that began
  std::array<Slot, axes> axes_;
  FreshBuffer<max_bytes, cache_line> buffer_{};
};

}  // namespace biss
