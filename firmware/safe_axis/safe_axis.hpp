// One BiSS Safety encoder on one SPI peripheral with DMA, asked once a control period.
//
//   control timer interrupt                DMA complete interrupt
//   ------------------------------------   -------------------------------
//   position(now): none -> torque off      axis.transfer_complete()
//   axis.request(now): SPI starts    --->    both evaluations, verdict
//
// Give both interrupts the same priority: neither then breaks into the other, and nothing here
// needs a lock. What makes the torque go off is the board's; this says when it has to.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "biss/base/bits.hpp"
#include "biss/base/units.hpp"
#include "biss/safety/verdict.hpp"
#include "firmware/control_loop/encoder_axis.hpp"

namespace safe_axis {

/// `Monitor` is a biss::SafetyMonitor; `bytes` hold a whole answer: spi_bytes() of the master's
/// setup.
template <control_loop::SpiDma Spi, class Monitor, std::size_t bytes>
class SafeAxis {
 public:
  /// `spi` outlives the axis.
  constexpr explicit SafeAxis(Spi& spi) : spi_(spi) {}

  /// At power-up, before the interrupts are on. False: this processor does not see what it has to;
  /// there will never be a position.
  [[nodiscard]] constexpr bool power_up() { return monitor_.self_test(); }

  /// Asks the encoder. For the control timer's interrupt, once a period, after position().
  /// \param now the moment of the first falling edge of MA
  constexpr void request(biss::Picoseconds now) {
    asked_at_ = now;
    // A transfer that has not ended is no answer, whatever its buffer holds.
    if (!spi_.start(buffer_)) latest_ = monitor_.step(now, biss::BitView());
  }

  /// Judges what came. For the DMA's interrupt at the end of the transfer.
  constexpr void transfer_complete() { latest_ = monitor_.step(asked_at_, biss::BitView(buffer_)); }

  /// The CPW's position at the last request; none where it is not to be trusted, and the axis must
  /// go to its safe state. Time alone can be the reason: an encoder or a DMA that is silent.
  constexpr std::optional<std::uint64_t> position(biss::Picoseconds now) {
    const biss::SafetyJudgement watched = monitor_.watch(now);
    if (watched.verdict == biss::SafetyVerdict::watchdog) latest_ = watched;
    return latest_.position;
  }

  /// Why there is a position, or none; while a fault holds, that fault.
  constexpr biss::SafetyVerdict cause() const {
    return latest_.verdict == biss::SafetyVerdict::latched ? monitor_.latched_cause()
                                                           : latest_.verdict;
  }

  /// Once somebody has seen to the fault.
  constexpr void acknowledge() { monitor_.acknowledge(); }

 private:
  Spi& spi_;
  Monitor monitor_;
  biss::Picoseconds asked_at_{};
  biss::SafetyJudgement latest_{};
  std::array<std::uint8_t, bytes> buffer_{};
};

}  // namespace safe_axis
