// Automatic configuration over an SPI peripheral with DMA: the Configurator's requests as transfers.
//
//   timer interrupt, in every cycle      DMA complete interrupt
//   ----------------------------------   -------------------------------------------------
//   link.request(now): starts if due     link.transfer_complete(): the Configurator gets CDS,
//                                            and MA is held low for CDM 1
//
// Every kind of request is one transfer, up to CDS at the longest ACK: it ends within the frame if
// the channels are active, and after it if they are not. INIT and `reduced`, which need two clocks,
// get the same: CDM is the level of MA at the end of the timeout after the last clock. The
// conditions of EncoderLink hold here too: the interrupt comes before the timeout is over.
#pragma once

#include <cstddef>
#include <cstdint>

#include "biss/axis/encoder_link.hpp"
#include "biss/axis/freshness.hpp"
#include "biss/base/bits.hpp"
#include "biss/base/units.hpp"
#include "biss/configure/configurator.hpp"
#include "biss/frame/decode.hpp"
#include "biss/master/spi_read.hpp"

namespace biss {

/// The bounds of the bits up to CDS, for any device or chain.
constexpr FrameBounds bounds_up_to_cds(Picoseconds period, const LineDelayRange& line_delay) {
  FrameBounds bounds = spi_bounds({.period = period, .line_delay = line_delay}, {});
  bounds.ack_max_clocks = static_cast<std::uint16_t>(
      bounds.ack_max_clocks + biss_busy_s_max_clocks + control_max_slaves - 1U);
  return bounds;
}
/// The bytes of a transfer up to CDS.
constexpr std::size_t bytes_up_to_cds(const FrameBounds& bounds) {
  return (std::size_t{bounds.lead_max_clocks} + bounds.ack_max_clocks + 9U) / 8U;
}
constexpr CdsBit cds_of(const BitView& bits, const FrameBounds& bounds) {
  const auto start = find_start(bits, bounds);
  if (!start.ok() || start->start_bit + 1U >= bits.size_bits()) return CdsBit::missing;
  return bits[start->start_bit + 1U] ? CdsBit::one : CdsBit::zero;
}

/// Done when configurator().done(), if every transfer ends. A cycle of any length will do: a request
/// waits until it is due.
template <EncoderPort Port>
class ConfigureLink {
 public:
  /// \param period of MA, 1 µs to 4 µs: 250 kHz to 1 MHz
  /// \param line_delay at most biss_line_delay_max
  constexpr ConfigureLink(Port& port, Picoseconds period, const LineDelayRange& line_delay,
                          const ConfigureOptions& options = {})
      : port_(port),
        period_(period),
        bounds_(bounds_up_to_cds(period, line_delay)),
        configurator_(options) {}

  /// Requests a CDS if the Configurator's next request is due.
  constexpr void request(Picoseconds now) {
    if (configurator_.done() || now < configurator_.request().at) return;
    const bool unanswered = buffer_.waits();
    if (!buffer_.begin(bytes_up_to_cds(bounds_),
                       [this](auto receive) { return port_.start(receive); })) {
      return;
    }
    // MA was high after it.
    if (unanswered) configurator_.answer(asked_at_, CdsBit::missing);
    asked_at_ = now;
  }

  /// Call one of them in the DMA's interrupt at the end of the transfer.
  constexpr void transfer_complete() { answer(true); }
  constexpr void transfer_failed() { answer(false); }

  constexpr bool waits() const { return buffer_.waits(); }
  constexpr const Configurator& configurator() const { return configurator_; }

 private:
  constexpr void answer(bool received) {
    const auto bytes = buffer_.end();
    if (!bytes || configurator_.done()) return;
    const BitView bits(*bytes);
    const CdsBit cds = received ? cds_of(bits, bounds_) : CdsBit::missing;
    const Picoseconds end = asked_at_ + static_cast<std::int64_t>(bits.size_bits()) * period_;
    if (configurator_.answer(end, cds)) port_.hold_ma_low();
  }

  Port& port_;
  Picoseconds period_;
  FrameBounds bounds_;
  Configurator configurator_;
  Picoseconds asked_at_{};
  // At 1 MHz: 42 clocks before ACK, 40 µs of ACK, 15 of busy_s and a chain, START and CDS.
  FreshBuffer<13> buffer_{};
};

}  // namespace biss
