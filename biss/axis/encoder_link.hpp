// One encoder on an SPI peripheral with DMA, with its registers: a position and one bit of the
// control communication in every cycle.
//
//   timer interrupt, once per cycle        DMA complete interrupt
//   ------------------------------------   -------------------------------------------------
//   use axis().position()                  link.transfer_complete()
//   link.request(now): MA high, SPI starts     decodes the frame, gives its CDS to the session,
//                                            and holds MA low if the session's CDM is 1
//
// CDM is the inverted level of MA at the end of the encoder's timeout. An SPI clock is idle high,
// which is CDM = 0. For CDM = 1 the port holds the pin low from the end of the transfer to the next
// request. The interrupt must therefore run before the timeout is over, and the next request must
// come after it.
//
// Give both interrupts the same priority. request() and transfer_complete() are the only functions
// that they call; begin an access of session() while they are masked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "biss/axis/encoder_axis.hpp"
#include "biss/base/units.hpp"
#include "biss/control/session.hpp"

namespace biss {

/// A port whose clock pin can be held low. start() gives the pin back to the clock first: MA is
/// then high for at least half a period before its first falling edge.
template <class T>
concept EncoderPort = SpiDma<T> && requires(T& port) {
  port.hold_ma_low();
};

/// EncoderAxis has the same parameters.
template <EncoderPort Port, class Reader, std::size_t max_bytes, std::size_t axes = 1,
          std::size_t cache_line = 4>
class EncoderLink {
 public:
  using Axis = EncoderAxis<Port, Reader, max_bytes, axes, cache_line>;

  /// Port, reader and setup must outlive the link; reader and setup may be in flash. The setup
  /// applies to all axes of a chain.
  constexpr EncoderLink(Port& port, const Reader& reader, const AxisSetup& setup,
                        const ControlOptions& options)
      : port_(port), axis_(port, reader, setup), session_(options) {}
  EncoderLink(Port&, const Reader&, const AxisSetup&&, const ControlOptions&) = delete;
  EncoderLink(Port&, const Reader&&, const AxisSetup&, const ControlOptions&) = delete;

  /// Requests a position: EncoderAxis::request(). Call it once per cycle in the timer's interrupt.
  constexpr void request(Picoseconds now) {
    const std::uint32_t before = axis_.number();
    axis_.request(now);
    if (axis_.number() == before) return;
    // MA was high after the request before, so that the encoder has seen CDM = 0.
    if (open_ && session_.step(asked_at_, CdsBit::missing)) session_.cancel();
    asked_at_ = now;
    open_ = true;
  }

  /// Call it in the DMA's interrupt at the end of the transfer.
  constexpr void transfer_complete() {
    end([this] { return axis_.transfer_complete(); });
  }

  /// Call it instead of transfer_complete() if the DMA reports an error: the buffer then does not
  /// have the bytes of the line.
  constexpr void transfer_failed() {
    end([this] {
      axis_.transfer_failed();
      return std::optional<bool>();
    });
  }

  constexpr ControlSession& session() { return session_; }
  constexpr Axis& axis() { return axis_; }
  constexpr const Axis& axis() const { return axis_; }

 private:
  constexpr void end(const auto& read) {
    const bool is_cycle = axis_.waits();
    const std::optional<bool> cds = read();
    if (!is_cycle) return;
    open_ = false;
    const CdsBit bit = !cds ? CdsBit::missing : *cds ? CdsBit::one : CdsBit::zero;
    if (session_.step(asked_at_, bit)) port_.hold_ma_low();
  }

  Port& port_;
  Axis axis_;
  Picoseconds asked_at_{};
  bool open_ = false;  // the session has not seen the last request; also after a reset of the axis
  ControlSession session_;
};

}  // namespace biss
