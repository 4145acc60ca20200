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

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

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
  /// Starts a transfer of `receive.size()` bytes. The DMA uses them until the interrupt.
  /// \return false if the previous transfer has not ended; then nothing was started
  { spi.start(receive) } -> std::same_as<bool>;
};

/// A position for the controller.
struct AxisPosition {
  PolicyOutput output{};
  /// The time of the position; for a held position the time of its measurement.
  biss::Picoseconds moment{};
  /// The cause of the last bad cycle. Empty after a good one, after nE = 0, and after a step that
  /// is too large.
  std::optional<biss::FrameFault> fault{};

  /// The age of the position, for the observer: speed × age is the error if it is ignored.
  constexpr biss::Picoseconds age(biss::Picoseconds now) const {
    return biss::wrapping_elapsed(moment, now);
  }
};

/// `Reader` is a biss::SpiReader, `max_bytes` the buffer's size: at least the reader's bytes().
template <SpiDma Spi, class Reader, std::size_t max_bytes>
class EncoderAxis {
 public:
  /// All three must outlive the axis; the reader may be in flash.
  /// Where the axis may have moved by half a turn or more since the last good frame, its turns are
  /// unknown, and the cycle is a bad one. With no_step_limit this is so after any bad cycle.
  /// \pre reader.bytes() <= max_bytes, the format has one channel with a position
  constexpr EncoderAxis(Spi& spi, const Reader& reader, biss::Picoseconds ma_period,
                        const biss::DeviceTiming& timing, const PolicyLimits& limits)
      : spi_(spi),
        reader_(reader),
        // The position is that of the sampling time, which is measured from the first rising edge.
        to_sampling_(ma_period / 2 + timing.sampling_typical),
        turns_(turns_of(reader.codec().format().channel_list[0].position_bits(), limits.max_step)),
        policy_(limits) {}

  /// Requests a position. Call it once per period in the control timer's interrupt, after the use
  /// of latest(). A request before that was never answered counts as a bad cycle.
  /// \param now the time of the first falling edge of MA; it may wrap around at the limits of its
  ///   type
  constexpr void request(biss::Picoseconds now) {
    // A transfer that has not ended keeps the time of its own request.
    if (!spi_.start(std::span(buffer_).first(reader_.bytes()))) return bad(std::nullopt, now);
    if (waits_) bad(std::nullopt, asked_at_);
    waits_ = true;
    asked_at_ = now;
  }

  /// The transfer ended with an error. Call it in the DMA's interrupt for errors.
  constexpr void transfer_failed() {
    waits_ = false;
    bad(std::nullopt, asked_at_);
  }

  /// Decodes the transfer. Call it in the DMA's interrupt at the end of the transfer.
  constexpr void transfer_complete() {
    waits_ = false;
    const auto frame = reader_.read(std::span<const std::uint8_t>(buffer_).first(reader_.bytes()));
    if (!frame.ok()) return bad(frame.error(), asked_at_);
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
  constexpr const biss::TurnCounter& turns() const { return turns_; }

 private:
  static constexpr biss::TurnCounter turns_of(unsigned position_bits, std::int64_t max_step) {
    if (max_step == no_step_limit) return biss::TurnCounter(position_bits);
    return {position_bits, static_cast<std::uint64_t>(max_step)};
  }

  // `asked` is when the cycle was requested.
  constexpr void bad(std::optional<biss::FrameFault> fault, biss::Picoseconds asked) {
    take(policy_.bad(), fault, asked);
  }

  constexpr void take(const PolicyOutput& output, std::optional<biss::FrameFault> fault,
                      biss::Picoseconds asked) {
    latest_.output = output;
    latest_.fault = fault;
    const bool of_this_cycle =
        output.quality == Quality::measured || output.quality == Quality::extrapolated;
    const biss::Picoseconds sampled = biss::wrapping_later(asked, to_sampling_);
    if (output.quality == Quality::measured) measured_at_ = sampled;
    latest_.moment = of_this_cycle ? sampled : measured_at_;
  }

  Spi& spi_;
  const Reader& reader_;
  biss::Picoseconds to_sampling_;
  biss::Picoseconds asked_at_{};  // of the last transfer that began
  bool waits_ = false;            // for its end
  biss::Picoseconds measured_at_{};
  biss::TurnCounter turns_;
  PositionPolicy policy_;
  AxisPosition latest_{};
  std::array<std::uint8_t, max_bytes> buffer_{};
};

}  // namespace control_loop
