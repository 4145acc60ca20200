// One BiSS Safety encoder on one SPI peripheral with DMA, requested once per control period.
//
//   control timer interrupt                DMA complete interrupt
//   ------------------------------------   -------------------------------
//   position(now): none -> torque off      axis.transfer_complete()
//   axis.request(now): SPI starts    --->    both evaluations, verdict
//
// Two clocks: `now` is the time of the control timer, `second` the time of another oscillator, for
// example the time base of the network. OneClock compiles as well, and names the weaker
// monitor.
//
// Give both interrupts the same priority, so that neither interrupts the other and no lock is
// needed. Call the other functions in one of them, or with both disabled. The board switches the
// torque off when this class returns no position.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "biss/axis/counters.hpp"
#include "biss/axis/encoder_axis.hpp"
#include "biss/axis/freshness.hpp"
#include "biss/base/bits.hpp"
#include "biss/base/units.hpp"
#include "biss/safety/monitor.hpp"
#include "biss/safety/verdict.hpp"

namespace biss {

/// `Monitor` is a SafetyMonitor. `bytes` is the size of a complete answer: spi_bytes() of the
/// master's setup. `cache_line`: with a data cache, the size of its lines.
template <SpiDma Spi, class Monitor, std::size_t bytes, std::size_t cache_line = 4>
class SafeAxis {
 public:
  /// `spi` must outlive the axis.
  constexpr explicit SafeAxis(Spi& spi) : spi_(spi) {}

  /// Runs the self test at power-up, before the interrupts are enabled. False: the self test failed
  /// on this processor, and there is never a position.
  [[nodiscard]] constexpr bool power_up() { return monitor_.self_test(); }

  /// Requests a position. Call it once per period in the control timer's interrupt, after
  /// position().
  /// \param now both clocks at the first falling edge of MA; its transfer is ignored, because it is
  ///   known only at the end
  constexpr void request(const TwoClocks& now) {
    const bool unanswered = buffer_.waits();
    const auto start = [this](std::span<std::uint8_t> receive) { return spi_.start(receive); };
    if (buffer_.begin(bytes, start)) {
      // The end of the request was never reported, and its position must not count for a later
      // request.
      if (unanswered) judge(asked_at_, BitView());
      asked_at_ = now;
      if (expected_) monitor_.expect_position(expected_->first, expected_->second);
      expected_.reset();
    } else {
      // A transfer that has not ended is one lost answer, with any bytes in its buffer: its end does
      // not count again.
      static_cast<void>(buffer_.end());
      judge(now, BitView());
    }
  }

  /// Judges the transfer. Call it in the DMA's interrupt at the end of the transfer. An end that no
  /// request waits for is ignored: its buffer has nothing new.
  /// \param transfer_time the time of all clocks of the transfer, measured by a different clock,
  /// not the clock of MA; needed with SafetyClocks::bit_period, otherwise ignored
  constexpr void transfer_complete(Picoseconds transfer_time = {}) {
    const auto received = buffer_.end();
    if (!received) return;
    TwoClocks time = asked_at_;
    time.transfer.time = transfer_time;
    judge(time, BitView(*received));
  }

  /// The transfer ended with an error: it counts as no answer. Call it in the DMA's interrupt for
  /// errors.
  constexpr void transfer_failed() {
    if (buffer_.end()) judge(asked_at_, BitView());
  }

  /// The position at the next request must be from `low` to `high`: SafetyMonitor::expect_position().
  /// An answer to an earlier request is not affected.
  constexpr void expect_position(std::uint64_t low, std::uint64_t high) { expected_ = {low, high}; }

  /// Call it after the encoder was switched off or exchanged: SafetyMonitor::encoder_restarted().
  /// There is no position until the monitor is safe again, and an answer to an earlier request is not
  /// judged. After `counter_first` or `stimulus`, switch the encoder off and on, call this function,
  /// and then acknowledge() if the fault holds.
  constexpr void encoder_restarted() {
    monitor_.encoder_restarted();
    static_cast<void>(buffer_.end());
    latest_ = monitor_.watch(asked_at_);
  }

  /// The position at the last request; none if it is not safe, and the axis must go to its safe
  /// state. Time alone can be the cause: an encoder or a DMA without an answer.
  constexpr GuardedPosition position(const TwoClocks& now) {
    const SafetyJudgement watched = monitor_.watch(now);
    if (is_fault(watched.verdict)) latest_ = watched;
    return latest_.position;
  }

  /// The verdict on the position; while a fault holds, that fault. `starting` once it was
  /// acknowledged, or power_up() has passed, until the next answer.
  constexpr SafetyVerdict cause() const {
    const SafetyState state = monitor_.state();
    const bool holds = state == SafetyState::latched || state == SafetyState::failed;
    if (holds) return monitor_.latched_cause();
    const bool starts_again =
        state == SafetyState::starting && latest_.state != SafetyState::starting;
    return starts_again ? SafetyVerdict::starting : latest_.verdict;
  }

  /// Cycles, by their verdict.
  constexpr const CauseCounts<SafetyVerdict>& counts() const { return counts_; }
  /// Whether the last request still waits for its answer.
  constexpr bool waits() const { return buffer_.waits(); }
  /// The number of the last request, from 1; 0 before it. It wraps around.
  constexpr std::uint32_t number() const { return buffer_.number(); }

  /// Acknowledges the fault with this cause. Call it after its cause was removed. A fault of this
  /// processor (FaultPlace::receiver) holds until the next power-up.
  constexpr bool acknowledge(SafetyVerdict cause) { return monitor_.acknowledge(cause); }

 private:
  constexpr void judge(const TwoClocks& time, const BitView& bits) {
    latest_ = monitor_.step(time, bits);
    counts_.add(latest_.verdict);
  }

  Spi& spi_;
  Monitor monitor_;
  TwoClocks asked_at_{{}, {}};
  SafetyJudgement latest_{};
  CauseCounts<SafetyVerdict> counts_{};
  std::optional<std::pair<std::uint64_t, std::uint64_t>> expected_{};
  FreshBuffer<bytes, cache_line> buffer_{};
};

}  // namespace biss
