// Receives frames without DMA: an SPI that is polled byte by byte, or pins that software switches.
// The bytes are the same as with DMA, and SpiReader reads them.
//
//   struct Board {              // an SPI; for pins see PolledPins
//     std::uint8_t transfer();  // makes eight clocks and returns the bits
//     // Only if the board has a clock:
//     static constexpr biss::Picoseconds time_step = biss::microseconds(1);
//     biss::Picoseconds now();
//   };
//   constexpr biss::SpiSetup setup{.period = biss::microseconds(2),
//                                  .line_delay = {.max = biss::microseconds(1)},
//                                  .max_pause = biss::microseconds(12)};
//   constexpr biss::SpiReader reader(codec, setup, timing);
//   biss::PolledRequest request(board, setup, timing);
//
//   request.start(buffer);                                              // reader.bytes() bytes
//   while (request.step() == biss::PolledState::running) other_work();  // shorter than max_pause
//   use(reader.read(buffer));
//
// The encoder ends its frame if MA rests for its timeout; a clock after that begins a new cycle, and
// the bits are parts of two frames. A CRC cannot detect this with certainty. With a clock, the
// request itself detects a pause that is too long: each edge is between two times,
//
//   step      |before ... 8 clocks ... after|    pause    |before ... 8 clocks ... after|
//             |<-------------------------- at least as long as the pause -------------->|
//
// and the pause cannot be longer than this time without the clocks. An interrupt anywhere is in it.
// Without a clock of the board, interrupts must be off in a request, or shorter than max_pause.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>

#include "biss/base/units.hpp"
#include "biss/base/wrapping_time.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

/// An SPI that is polled: MA is its clock, idle high. transfer() begins no clock before the call,
/// makes eight without a pause, and returns the bits of SLO, most significant bit first.
template <class T>
concept PolledSpi = requires(T& board) {
  { board.transfer() } -> std::same_as<std::uint8_t>;
};

/// Two pins. Without now(), set_ma() returns no earlier than half a period after the edge.
template <class T>
concept PolledPins = requires(T& board) {
  board.set_ma(true);
  { board.slo() } -> std::same_as<bool>;
};

/// A clock of the board, of which each reading is at most `time_step` old. A clock that jumps back,
/// because its counter is shorter than Picoseconds, ends a request as a pause would. The period of
/// this counter must be longer than any interrupt: a pause of a whole period is not detected.
template <class T>
concept PolledClock = requires(T& board) {
  { board.now() } -> std::same_as<Picoseconds>;
  { T::time_step } -> std::convertible_to<Picoseconds>;
};

enum class PolledState : std::uint8_t {
  idle,      ///< no request was started
  running,   ///< bytes are missing: call step() again
  complete,  ///< all bytes were received
  paused,    ///< a pause may have been longer than max_pause: there is no frame
};

/// Receives the bytes of one request after the other. It is an SPI of an axis (start()): call
/// transfer_complete() of the axis for `complete`, and transfer_failed() for `paused`.
template <class Board>
requires PolledSpi<Board> || PolledPins<Board>
class PolledRequest {
 public:
  /// The SpiReader has the same setup and timing. Its check of pauses is repeated here, and the
  /// setup must have max_pause: a constant object with an error does not compile; any other has
  /// error() and starts nothing.
  constexpr PolledRequest(Board& board, const SpiSetup& setup, const DeviceTiming& timing)
      : board_(board),
        period_(setup.period),
        half_((setup.period + picoseconds(1)) / 2),
        max_pause_(setup.max_pause),
        falling_(setup.phase == SpiPhase::sample_on_falling),
        error_(check(setup, timing)) {
    if (std::is_constant_evaluated() && error_) spi_detail::stop_the_build(*error_);
  }

  /// Why nothing is started: period, line_delay, pause, pause_delay, clock_constant or time_step.
  constexpr const std::optional<SpiSetupError>& error() const { return error_; }
  constexpr PolledState state() const { return state_; }
  /// No step() is missing.
  constexpr bool done() const { return state_ != PolledState::running; }

  /// Begins a request. MA moves in the first step(), for which there is no limit of time, except
  /// that the time of the position counts from there.
  /// \param receive used until done(); then all bytes are new
  /// \return false if a request is running, if there is an error(), or for no bytes
  constexpr bool start(std::span<std::uint8_t> receive) {
    if (!done() || error_ || receive.empty()) return false;
    receive_ = receive;
    received_ = 0;
    state_ = PolledState::running;
    moved_ = late_ = false;
    return true;
  }

  /// Receives the next byte, if a request is running. From `paused` on, MA stays high, and the
  /// buffer has only ones, which is no_response if it is read after all. The encoder may be in a new
  /// cycle then: do not start again before its longest timeout.
  constexpr PolledState step() {
    if (done()) return state_;
    receive_[received_++] = receive_byte();
    if (received_ == receive_.size()) state_ = PolledState::complete;
    if (late_) {
      std::fill(receive_.begin(), receive_.end(), std::uint8_t{0xFF});
      state_ = PolledState::paused;
    }
    return state_;
  }

  /// The longest time of a request that is not `paused`, from its first edge to its last. BiSS C has
  /// no limit for it; the position belongs to its beginning. \pre !error()
  constexpr Picoseconds time_max(std::size_t bytes) const {
    const auto count = static_cast<std::int64_t>(bytes);
    if constexpr (PolledSpi<Board>) return count * 15 * period_ / 2 + (count - 1) * max_pause_;
    return (16 * count - 1) * max_pause_;
  }

 private:
  static constexpr std::optional<SpiSetupError> check(const SpiSetup& setup,
                                                      const DeviceTiming& timing) {
    if (setup.max_pause.count == 0) return SpiSetupError::pause;
    const auto error = check_pause(setup, timing);
    if constexpr (PolledClock<Board>) {
      // took() may be wrong by two steps, without any pause; edge() waits for half a period.
      const Picoseconds step = Board::time_step;
      const Picoseconds most = setup.max_pause - (PolledSpi<Board> ? 0 : 1) * setup.period / 2;
      if (!error && (step.count < 0 || step > most / 2)) return SpiSetupError::time_step;
    }
    return error;
  }

  constexpr std::uint8_t receive_byte() {
    if constexpr (PolledSpi<Board>) {
      const Picoseconds before = now();
      const std::uint8_t byte = board_.transfer();
      // MA moved for seven and a half periods in each of the two bytes. If the SPI samples at the
      // falling edge, transfer() may return half a period before the last edge.
      took(before, (falling_ ? 29 : 30) * period_ / 2);
      return byte;
    } else {
      unsigned byte = 0;
      for (unsigned clock = 0; clock < 8; ++clock) {
        const bool early = edge(false);
        const bool late = edge(true);
        byte = byte * 2U + ((falling_ ? early : late) ? 1U : 0U);
      }
      return static_cast<std::uint8_t>(byte);
    }
  }

  // Makes an edge, half a period or more after the last one. Returns SLO just before it.
  constexpr bool edge(bool level) {
    Picoseconds before = now();
    if constexpr (PolledClock<Board>) {
      // after_ may be older than the edge by a step of the clock.
      const auto is_early = [&](Picoseconds passed) {
        return passed.count >= 0 && passed - Board::time_step < half_;
      };
      while (moved_ && is_early(wrapping_elapsed(after_, before))) before = now();
    }
    const bool slo = board_.slo();
    board_.set_ma(level);
    took(before, {});
    return slo;
  }

  // MA moved between `before` and now, and also since the last call for `clocks`.
  constexpr void took(Picoseconds before, Picoseconds clocks) {
    if constexpr (PolledClock<Board>) {
      after_ = now();
      const Picoseconds passed = wrapping_elapsed(before_, after_);
      const Picoseconds most = max_pause_ + clocks - Board::time_step;
      if (moved_ && (passed.count < 0 || passed > most)) late_ = true;
      before_ = before;
      moved_ = true;
    }
  }

  constexpr Picoseconds now() {
    if constexpr (PolledClock<Board>) return board_.now();
    return {};
  }

  Board& board_;
  std::span<std::uint8_t> receive_{};
  std::size_t received_ = 0;
  Picoseconds period_;
  Picoseconds half_;  // rounded up
  Picoseconds max_pause_;
  // The last edge, or all of the last byte, was between these times.
  Picoseconds before_{};
  Picoseconds after_{};
  bool falling_;
  bool moved_ = false;
  bool late_ = false;
  PolledState state_ = PolledState::idle;
  std::optional<SpiSetupError> error_;
};

}  // namespace biss
