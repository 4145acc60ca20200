// One encoder on an SPI peripheral with DMA, with its registers: a position and one bit of the
// control communication in every cycle.
//
//   timer interrupt, once per cycle        DMA complete interrupt
//   ------------------------------------   -------------------------------------------------
//   use latest()                           link.transfer_complete()
//   link.request(): MA high, SPI starts      decodes the frame, gives its CDS to the session,
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
#include <span>
#include <type_traits>

#include "biss/axis/counters.hpp"
#include "biss/axis/freshness.hpp"
#include "biss/base/units.hpp"
#include "biss/base/wrapping_time.hpp"
#include "biss/control/session.hpp"
#include "biss/frame/frame.hpp"
#include "firmware/control_loop/encoder_axis.hpp"

namespace boards {

/// A port whose clock pin can be held low. start() gives the pin back to the clock first: MA is
/// then high for at least half a period before its first falling edge.
template <class T>
concept EncoderPort = control_loop::SpiDma<T> && requires(T& port) {
  port.hold_ma_low();
};

/// The result of one cycle.
struct Cycle {
  /// Counts from 0; the same number is the same cycle.
  std::uint32_t number = 0;
  /// The request that it answers, from 1; a gap is a request without an answer. 0: no cycle yet.
  std::uint32_t request = 0;
  biss::Channel channel{};
  /// The frame is good and nE is 1.
  bool trusted = false;
  /// Why there is no frame.
  std::optional<biss::FrameFault> fault{};
};

/// `Reader` is a biss::SpiReader of a format with one channel, `Bytes` the size of its buffer. If
/// they do not fit, there is an AxisError: a constant link does not compile; any other link makes
/// no request and counts each cycle as `late`.
template <EncoderPort Port, class Reader, std::size_t Bytes>
class EncoderLink {
 public:
  /// Port and reader must outlive the link; the reader may be in flash.
  /// \param cycle the time from one request to the next
  constexpr EncoderLink(Port& port, const Reader& reader, biss::Picoseconds cycle,
                        const biss::ControlOptions& options)
      : port_(port),
        reader_(reader),
        error_(control_loop::axis_detail::check(reader, Bytes, {.max_step = 1})),
        cycle_(cycle),
        session_(options) {
    if (std::is_constant_evaluated() && error_) {
      control_loop::axis_detail::
          the_reader_the_buffer_the_format_or_max_step_is_wrong_see_AxisError();
    }
  }

  /// Why this link never makes a request; nothing if it can be used.
  constexpr const std::optional<control_loop::AxisError>& error() const { return error_; }

  constexpr void request() {
    const biss::Picoseconds before = now_;
    now_ = biss::wrapping_later(now_, cycle_);
    const bool unanswered = buffer_.waits();
    const auto start = [this](std::span<std::uint8_t> receive) { return port_.start(receive); };
    if (!buffer_.begin(error_ ? 0 : reader_.bytes(), start)) {
      ++counts_.late;
    } else if (unanswered) {
      // MA was high after the request, so that the encoder has seen CDM = 0.
      ++counts_.unanswered;
      if (session_.step(before, biss::CdsBit::missing)) session_.cancel();
      latest_ = {.number = counts_.cycles++, .request = buffer_.number() - 1};
      latest_.fault = biss::FrameFault{biss::FrameError::truncated};
    }
  }

  constexpr void transfer_complete() {
    const auto received = buffer_.end();
    if (!received) return unexpected();
    const auto frame = reader_.read(*received);
    if (!frame.ok()) return no_frame(frame.error());
    step(frame->cds ? biss::CdsBit::one : biss::CdsBit::zero);
    ++counts_.good;
    latest_.channel = frame->channels()[0];
    latest_.trusted = frame->trusted();
  }

  /// Call it instead of transfer_complete() if the DMA reports an error: the buffer then does not
  /// have the bytes of the line.
  constexpr void transfer_failed() {
    if (!buffer_.end()) return unexpected();
    no_frame({biss::FrameError::truncated});
  }

  constexpr biss::ControlSession& session() { return session_; }
  constexpr const Cycle& latest() const { return latest_; }
  constexpr const biss::CycleCounts& counts() const { return counts_; }

 private:
  // No request waits for it: it is not a cycle, and the bytes are old.
  constexpr void unexpected() { ++counts_.unexpected; }

  constexpr void no_frame(biss::FrameFault fault) {
    step(biss::CdsBit::missing);
    counts_.causes.add(fault.cause);
    latest_.fault = fault;
  }

  // CDM first: the encoder's timeout is running.
  constexpr void step(biss::CdsBit cds) {
    if (session_.step(now_, cds)) port_.hold_ma_low();
    latest_ = {.number = counts_.cycles++, .request = buffer_.number()};
  }

  Port& port_;
  const Reader& reader_;
  std::optional<control_loop::AxisError> error_;
  biss::Picoseconds cycle_;
  biss::Picoseconds now_{};
  biss::ControlSession session_;
  Cycle latest_{};
  biss::CycleCounts counts_{};
  biss::FreshBuffer<Bytes> buffer_{};
};

}  // namespace boards
