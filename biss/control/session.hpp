// The master's end of the control communication: registers read and written, commands sent, with
// one CDM bit and one CDS bit a BiSS frame.
//
//   ControlSession session;
//   std::array<std::uint8_t, 2> profile;
//   session.read(0, 0x42, profile);
//   // Then once a BiSS frame, between its CDS and its end:
//   const bool cdm = session.step(now, cds);  // the CDM bit that is to end this very frame
//   if (session.done() && !session.outcome().error) ...
//
// A frame without a running access ends with CDM = 0; step() it all the same, and its zero counts.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "biss/base/units.hpp"
#include "biss/control/control_error.hpp"
#include "biss/control/control_frame.hpp"
#include "biss/control/control_outcome.hpp"
#include "biss/control/control_request.hpp"

namespace biss {

/// One access at a time. Every access ends, whatever CDS does, as long as time goes on: a try takes
/// no more frames than are needed, 14 lost ones before its start bit, and busy_max for each byte.
class ControlSession {
 public:
  constexpr explicit ControlSession(const ControlOptions& options = {}) : options_(options) {}

  /// Begins to read `to.size()` registers (1…64) from `address` on, the last one not above 127.
  /// `to` must live until done(); that is at once, with bad_request, where no control frame can say
  /// this. \pre done() \param slave ID, 0…7
  constexpr void read(unsigned slave, unsigned address, std::span<std::uint8_t> to) {
    begin(read_request(slave, address, to));
  }
  /// Begins to write `from`; otherwise as read().
  constexpr void write(unsigned slave, unsigned address, std::span<const std::uint8_t> from) {
    begin(write_request(slave, address, from));
  }
  /// Begins a command to the slaves with these IDs, bit k for ID k; none: bad_request. Done without
  /// an error it was accepted and EX = 1 sent, which nobody confirms. \pre done()
  constexpr void command(std::uint8_t slaves, ControlCommand command,
                         ExecuteIf execute_if = ExecuteIf::all_accept) {
    begin(command_request(slaves, command, execute_if));
  }
  /// Begins a command to all slaves, those without an ID too. It needs no CDS and has no answer;
  /// a frame whose CDS is missing counts as delivered. \pre done()
  constexpr void broadcast(ControlCommand command) { begin(broadcast_request(command)); }

  /// Ends the access with `cancelled`. The zeros that its slaves then need come with the next
  /// frames, before another access does.
  constexpr void cancel() {
    if (done()) return;
    zeros_ = 0;
    end_with(ControlError::cancelled);
  }

  /// \param cds of this frame
  /// \return the CDM bit at the end of this frame
  constexpr bool step(Picoseconds now, CdsBit cds) {
    const bool bit = next(now, cds);
    if (bit) {
      zeros_ = 0;
    } else if (zeros_ < control_reset_zeros && (cds != CdsBit::missing || (deaf() && !done()))) {
      ++zeros_;
    }
    return bit;
  }

  constexpr bool done() const { return phase_ == Phase::idle; }
  /// Of the access begun last; whole when done().
  constexpr const ControlOutcome& outcome() const { return outcome_; }
  constexpr void set_options(const ControlOptions& options) { options_ = options; }

 private:
  using Kind = ControlKind;

  enum class Phase : std::uint8_t {
    idle,
    lead,         // zeros until there are 14
    frame,        // header and what follows it, bit k_ of word_
    write_start,  // S of a write's first byte is due on CDS
    start,        // S of any other byte is due
    busy,         // S is late since busy_since_
    byte,         // DATA, CRC and P, bit k_ of word_
    next,         // P is due, which says whether another byte may follow
  };

  constexpr bool deaf() const { return request_.kind == Kind::broadcast; }

  constexpr void begin(const ControlRequest& request) {
    outcome_ = {};
    request_ = request;
    request.possible ? begin_try() : end_with(ControlError::bad_request);
  }

  constexpr void begin_try() {
    ++outcome_.tries;
    outcome_.slaves_present = 0;
    outcome_.more_slaves = false;
    outcome_.accepted = 0;
    phase_ = Phase::lead;
    k_ = 0;
  }

  constexpr void end_with(ControlError error) {
    outcome_.error = error;
    phase_ = Phase::idle;
  }

  constexpr bool next(Picoseconds now, CdsBit cds) {
    if (phase_ == Phase::idle) return false;
    ++outcome_.frames;
    if (cds == CdsBit::missing && !deaf()) return frame_lost();
    const bool one = cds == CdsBit::one;
    heard_ = static_cast<std::uint16_t>(std::uint32_t{heard_} << 1U | (one ? 1U : 0U));
    switch (phase_) {
      case Phase::lead:
        return zeros_ >= control_reset_zeros && begin_frame();
      case Phase::frame:
        return k_ < control_bit::header_end ? send() : behind_header();
      case Phase::write_start:
        return one ? begin_byte() : fail(ControlError::start_missing);
      case Phase::start:
        if (one) return begin_byte();
        busy_since_ = now;
        phase_ = Phase::busy;
        return options_.busy_max.count > 0 || fail(ControlError::busy_too_long);
      case Phase::busy:
        return busy(now - busy_since_, one);
      case Phase::byte:
        return k_ < control_byte_bits - 2 ? send() : end_byte();
      case Phase::next:
        return next_byte(one);
      default:
        return false;
    }
  }

  constexpr bool send() {
    const bool bit = (word_ << k_ >> 31U) != 0;
    ++k_;
    return bit;
  }

  constexpr bool begin_frame() {
    word_ = request_.first_bits(outcome_.bytes_done);
    phase_ = Phase::frame;
    k_ = 0;
    return send();
  }

  constexpr bool behind_header() {
    if (deaf()) {
      if (k_ == control_bit::ex_broadcast) phase_ = Phase::idle;
      return send();
    }
    const bool addressed = request_.kind == Kind::addressed;
    std::optional<ControlError> error;
    if (k_ == control_bit::header_end) {
      error = request_.judge_ids(heard_, outcome_);
    } else if (addressed && k_ == control_bit::ex_addressed) {
      error = request_.judge_ida(heard_, outcome_);
      phase_ = Phase::idle;
    } else if (!addressed && k_ == control_bit::byte_start) {
      error = request_.judge_access(heard_);
      phase_ = request_.kind == Kind::read ? Phase::start : Phase::write_start;
    }
    return error ? fail(*error) : send();
  }

  constexpr bool busy(Picoseconds since, bool one) {
    if (one) {
      outcome_.longest_busy = std::max(outcome_.longest_busy, since);
      return begin_byte();
    }
    return since > options_.busy_max ? fail(ControlError::busy_too_long) : true;
  }

  constexpr bool begin_byte() {
    phase_ = Phase::byte;
    k_ = 0;
    word_ = 0;
    if (request_.kind == Kind::write) {
      const std::uint8_t data = request_.from[outcome_.bytes_done];
      word_ = (std::uint32_t{data} << 4U | byte_crc(data)) << 20U;
    }
    return send();
  }

  // DATA and CRC have come; P = 0 is sent.
  constexpr bool end_byte() {
    const unsigned heard = heard_ & 0xFFFU;
    if (request_.kind == Kind::read) {
      const auto data = static_cast<std::uint8_t>(heard >> 4U);
      if (byte_crc(data) != (heard & 0xFU)) return fail(ControlError::data_crc);
      request_.to[outcome_.bytes_done] = data;
    } else if (heard != word_ >> 20U) {
      return fail(ControlError::echo);
    }
    ++outcome_.bytes_done;
    phase_ = Phase::next;
    return false;
  }

  constexpr bool next_byte(bool p) {
    if (outcome_.bytes_done == request_.size) {
      phase_ = Phase::idle;
      return false;
    }
    if (p) return fail(ControlError::next_unavailable);
    phase_ = Phase::start;
    return true;
  }

  // Behind the last byte nothing is missing that matters; before the start bit only a zero is.
  [[gnu::noinline, gnu::cold]] constexpr bool frame_lost() {
    if (phase_ == Phase::next && outcome_.bytes_done == request_.size) return next_byte(false);
    if (phase_ == Phase::lead && ++k_ < control_reset_zeros) return false;
    return fail(ControlError::frame_lost);
  }

  // False for CDM: the first of 14 zeros.
  [[gnu::noinline, gnu::cold]] constexpr bool fail(ControlError error) {
    zeros_ = 0;
    if (outcome_.tries > options_.retries || !worth_retrying(error)) {
      end_with(error);
    } else {
      outcome_.retried = error;
      begin_try();
    }
    return false;
  }

  ControlOptions options_;
  Picoseconds busy_since_{};
  ControlOutcome outcome_;
  ControlRequest request_;
  std::uint32_t word_ = 0;   // what is sent, the first bit topmost
  std::uint16_t heard_ = 0;  // the last 16 bits of CDS, the latest lowest
  Phase phase_ = Phase::idle;
  std::uint8_t k_ = 0;      // the next bit of word_; in the lead the frames lost
  std::uint8_t zeros_ = 0;  // CDM bits since the last 1, or since the last error; at most 14
};

}  // namespace biss
