// One encoder on one SPI peripheral with DMA, requested once per control period.
//
//   control timer interrupt                DMA complete interrupt
//   ------------------------------------   -------------------------------
//   use latest() and age(now)              axis.transfer_complete()
//   axis.request(now): SPI starts    --->    decode, turns, policy
//
// Give both interrupts the same priority, so that neither interrupts the other and no lock is
// needed. The frame is decoded once, in the second interrupt, before the first one needs it.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>

#include "biss/axis/counters.hpp"
#include "biss/axis/freshness.hpp"
#include "biss/base/units.hpp"
#include "biss/base/wrapping_time.hpp"
#include "biss/frame/frame.hpp"
#include "biss/timing/device_timing.hpp"
#include "biss/turns/turn_counter.hpp"
#include "firmware/control_loop/position_policy.hpp"

namespace control_loop {

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

/// A position for the controller.
struct AxisPosition {
  PolicyOutput output{};
  /// The time of the position; for a held position the time of its measurement.
  biss::Picoseconds moment{};
  /// The number of the request in whose frame the position was measured, from 1; 0: none yet. The
  /// same number again is the same frame.
  std::uint32_t number = 0;
  /// The cause of the last bad cycle. Empty after a good one, after nE = 0, and after a step that
  /// is too large.
  std::optional<biss::FrameFault> fault{};

  /// The age of the position, for the observer: speed × age is the error if it is ignored.
  constexpr biss::Picoseconds age(biss::Picoseconds now) const {
    return biss::wrapping_elapsed(moment, now);
  }
};

/// Why an axis never requests a position: the first cause that applies.
enum class AxisError : std::uint8_t {
  reader,    ///< the reader's error() has the cause
  buffer,    ///< the reader needs more than max_bytes
  format,    ///< it does not have one channel with a position
  max_step,  ///< it is not positive
};

namespace axis_detail {

// Not constexpr: the compiler names it for an axis that is a constant.
inline void the_reader_the_buffer_the_format_or_max_step_is_wrong_see_AxisError() {}

template <class Reader>
constexpr std::optional<AxisError> check(const Reader& reader, std::size_t max_bytes,
                                         const PolicyLimits& limits) {
  const biss::FrameFormat& format = reader.codec().format();
  if (reader.error()) return AxisError::reader;
  if (reader.bytes() > max_bytes) return AxisError::buffer;
  if (format.channel_count != 1 || format.channel_list[0].position_bits() == 0) {
    return AxisError::format;
  }
  if (limits.max_step <= 0) return AxisError::max_step;
  return std::nullopt;
}

}  // namespace axis_detail

/// `Reader` is a biss::SpiReader, `max_bytes` the buffer's size: at least the reader's bytes().
template <SpiDma Spi, class Reader, std::size_t max_bytes>
class EncoderAxis {
 public:
  /// All three must outlive the axis; the reader may be in flash. If the axis may have moved by
  /// half a turn or more since the last good frame, its turns are unknown, and the cycle is a bad
  /// one. With no_step_limit this applies after any bad cycle. If the parts do not fit, there is an
  /// AxisError: a constant axis does not compile; any other axis has error().
  constexpr EncoderAxis(Spi& spi, const Reader& reader, biss::Picoseconds ma_period,
                        const biss::DeviceTiming& timing, const PolicyLimits& limits)
      : spi_(spi),
        reader_(reader),
        error_(axis_detail::check(reader, max_bytes, limits)),
        // The position belongs to the sampling time, which is measured from the first rising edge.
        to_sampling_(ma_period / 2 + timing.sampling_typical),
        turns_(error_ ? biss::TurnCounter(1)
                      : turns_of(reader.codec().format().channel_list[0].position_bits(),
                                 limits.max_step)),
        policy_(limits) {
    if (std::is_constant_evaluated() && error_) {
      axis_detail::the_reader_the_buffer_the_format_or_max_step_is_wrong_see_AxisError();
    }
    reset();
  }

  /// Why this axis never requests a position; it is tripped from the start. Nothing if it can be
  /// used.
  constexpr const std::optional<AxisError>& error() const { return error_; }

  /// Starts again as after construction, also after a trip: no position, turns from 0, and the time
  /// to power up begins with the next request. Call it between the two interrupts or while they are
  /// masked, and only after the drive has stopped and the cause was found: the next position may be
  /// whole turns away from the last one, so the axis needs its reference again. The answer to a
  /// request from before is ignored. Counts and numbers continue.
  constexpr void reset() {
    static_cast<void>(buffer_.end());
    policy_.reset();
    turns_.restart();
    first_asked_.reset();
    latest_ = {};
    if (error_) latest_.output = policy_.trip();
  }

  /// Requests a position. Call it once per period in the control timer's interrupt, after the use
  /// of latest(). An earlier request without an answer counts as a bad cycle.
  /// \param now the time of the first falling edge of MA; it may wrap around at the limits of its
  ///   type
  constexpr void request(biss::Picoseconds now) {
    if (error_) return;
    if (!first_asked_) first_asked_ = now;
    const bool unanswered = buffer_.waits();
    const auto start = [this](std::span<std::uint8_t> receive) { return spi_.start(receive); };
    if (!buffer_.begin(reader_.bytes(), start)) {
      // A transfer that has not ended keeps the time of its own request.
      ++counts_.late;
      return bad(std::nullopt, now);
    }
    if (unanswered) {
      ++counts_.unanswered;
      bad(std::nullopt, asked_at_);
    }
    asked_at_ = now;
  }

  /// The transfer ended with an error. Call it in the DMA's interrupt for errors.
  constexpr void transfer_failed() {
    if (!answered()) return;
    bad(std::nullopt, asked_at_);
  }

  /// Decodes the transfer. Call it in the DMA's interrupt at the end of the transfer. If no request
  /// waits for it, it is ignored and counted as unexpected.
  constexpr void transfer_complete() {
    const auto received = answered();
    if (!received) return;
    const auto frame = reader_.read(*received);
    if (!frame.ok()) {
      counts_.causes.add(frame.error().cause);
      return bad(frame.error(), asked_at_);
    }
    ++counts_.good;
    if (!frame->trusted()) return bad(std::nullopt, asked_at_);

    // Works on a copy: a step that the policy refuses must not count turns.
    biss::TurnCounter turns = turns_;
    const bool ambiguous =
        turns.update(frame->channels()[0].position, policy_.output().bad_in_a_row) ==
        biss::TurnState::ambiguous;
    const auto position = turns.position();
    if (ambiguous || !position) return bad(std::nullopt, asked_at_);
    take(policy_.good(*position), std::nullopt, asked_at_);
    if (latest_.output.quality == Quality::measured) turns_ = turns;
  }

  constexpr const AxisPosition& latest() const { return latest_; }
  /// Whether the last request still waits for its answer: latest() then belongs to an earlier
  /// request.
  constexpr bool waits() const { return buffer_.waits(); }
  constexpr const biss::CycleCounts& counts() const { return counts_; }
  constexpr const biss::TurnCounter& turns() const { return turns_; }

 private:
  static constexpr biss::TurnCounter turns_of(unsigned position_bits, std::int64_t max_step) {
    if (max_step == no_step_limit) return biss::TurnCounter(position_bits);
    return {position_bits, static_cast<std::uint64_t>(max_step)};
  }

  constexpr std::optional<std::span<const std::uint8_t>> answered() {
    const auto received = buffer_.end();
    ++(received ? counts_.cycles : counts_.unexpected);
    return received;
  }

  // `asked` is when the cycle was requested.
  constexpr void bad(std::optional<biss::FrameFault> fault, biss::Picoseconds asked) {
    const biss::Picoseconds waited = biss::wrapping_elapsed(first_asked_.value_or(asked), asked);
    // A negative time is one of more than 106 days.
    const bool powers_up = waited >= biss::Picoseconds{} && waited < policy_.limits().power_up;
    take(powers_up ? policy_.wait() : policy_.bad(), fault, asked);
  }

  constexpr void take(const PolicyOutput& output, std::optional<biss::FrameFault> fault,
                      biss::Picoseconds asked) {
    latest_.output = output;
    latest_.fault = fault;
    const bool of_this_cycle =
        output.quality == Quality::measured || output.quality == Quality::extrapolated;
    const biss::Picoseconds sampled = biss::wrapping_later(asked, to_sampling_);
    if (output.quality == Quality::measured) {
      measured_at_ = sampled;
      latest_.number = buffer_.number();
    }
    latest_.moment = of_this_cycle ? sampled : measured_at_;
  }

  Spi& spi_;
  const Reader& reader_;
  std::optional<AxisError> error_;
  biss::Picoseconds to_sampling_;
  biss::Picoseconds asked_at_{};  // of the last transfer that began
  std::optional<biss::Picoseconds> first_asked_{};
  biss::Picoseconds measured_at_{};
  biss::TurnCounter turns_;
  PositionPolicy policy_;
  AxisPosition latest_{};
  biss::CycleCounts counts_{};
  biss::FreshBuffer<max_bytes> buffer_{};
};

}  // namespace control_loop
