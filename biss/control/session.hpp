// The master's end of the control communication: reads and writes registers and sends commands,
// with one CDM bit and one CDS bit per BiSS frame.
//
//   ControlSession session;
//   std::array<std::uint8_t, 2> profile;
//   session.read(0, 0x42, profile);
//   // Once per BiSS frame, between its CDS and its end:
//   const bool cdm = session.step(now, cds);  // the CDM bit that ends this frame
//   if (session.done() && !session.outcome().error) use(profile);
//
// A frame without an access ends with CDM = 0. step() is called for it, too, because its zero
// counts.
//
// A master that must choose CDM before it receives the CDS of the same frame:
//
//   transfer(session.cdm_ahead());
//   session.take_cds(now, cds);
//
// cdm_ahead() is the bit of an access that succeeds. Only after S of a byte does this bit depend on
// CDS: a read repeats S, because the next CDM bit of a read is "don't care" (D2); a write expects a
// slave that is ready. If CDS is different, the access ends as with step(), and 14 zeros follow the
// bit; a slave writes no byte of zeros, because its CRC is wrong.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "biss/base/units.hpp"
#include "biss/base/wrapping_time.hpp"
#include "biss/control/control_frame.hpp"

namespace biss {

// ---- How an access ends

/// The one cause why an access did not complete. If the protocol cannot distinguish two causes,
/// they share one enumerator.
enum class ControlError : std::uint8_t {
  bad_request,    ///< no control frame can express the request; nothing was sent
  no_answer,      ///< IDL0 stayed 0: no slave took an ID
  no_such_slave,  ///< fewer slaves took an ID than the one addressed
  id_pattern,     ///< IDL has a gap, or a 1 after it instead of a 0
  refused,        ///< read: protected or absent (the protocol has one answer for both)
  not_addressed,  ///< read: the slave is present, but acts as if not addressed (bad header)
  refused_or_not_addressed,  ///< write: refused, or not_addressed: the answer is the same
  rw_pattern,                ///< an R and W that no slave sends
  busy_too_long,     ///< no start bit in time; an old device without W inversion refuses like this
  start_missing,     ///< write: S of the first byte was not echoed, which may not be delayed
  data_crc,          ///< read: the byte and its CRC do not fit
  echo,              ///< write: the echo differs from the byte sent; the byte written is unknown
  next_unavailable,  ///< sequential: P = 1 before the last byte; the bytes before it are done
  not_accepted,      ///< command: not enough of the addressed slaves accept it, or no slave
                     ///< received it (header damaged); the master cancelled it by EX = 0
  ida_pattern,       ///< command: a slave that is not addressed accepts; dropped by EX = 0
  frame_lost,        ///< a frame of the access brought no CDS
  cancelled,         ///< by the master itself
};

/// The names that users and scripts see, in the order of ControlError.
inline constexpr auto control_error_names = std::to_array<std::string_view>(
    {"bad_request", "no_answer", "no_such_slave", "id_pattern", "refused", "not_addressed",
     "refused_or_not_addressed", "rw_pattern", "busy_too_long", "start_missing", "data_crc", "echo",
     "next_unavailable", "not_accepted", "ida_pattern", "frame_lost", "cancelled"});
inline constexpr std::size_t control_error_count = control_error_names.size();

constexpr std::string_view name_of(ControlError error) {
  return control_error_names[static_cast<std::size_t>(error)];
}

/// Whether damage on the line can be the cause, so that a retry may succeed. A clear refusal
/// (refused, next_unavailable) is not repeated, nor is an error of the master itself.
constexpr bool worth_retrying(ControlError error) {
  return error != ControlError::bad_request && error != ControlError::refused &&
         error != ControlError::next_unavailable && error != ControlError::cancelled;
}

// ---- The setup and the outcome of a session

/// The CDS of a BiSS frame.
enum class CdsBit : std::uint8_t {
  zero,
  one,
  missing,  ///< no valid frame (no answer, no START, cut short), or a reduced one
};

/// When a command to addressed slaves is executed.
enum class ExecuteIf : std::uint8_t {
  all_accept,   ///< all of them accept, and no other slave
  any_accepts,  ///< at least one of them accepts, and no other slave
  always,       ///< for any answers, if one of them is present
};

struct ControlOptions {
  /// The longest time by which a slave may delay S of a byte, counted from the first frame in which
  /// S can come. 0: no delay. S in the first frame after it still counts: the slave may have been
  /// ready in time.
  Picoseconds busy_max = register_busy_max;
  /// How often a failed access is tried again if worth_retrying(); a broadcast is never repeated. A
  /// sequential access continues with the first byte that is not done. A byte of a write whose echo
  /// was wrong may then be written twice: use 0 if that matters for a register.
  std::uint8_t retries = 0;
};

/// The state of an access: how it ended, or how far it is.
struct ControlOutcome {
  /// The longest time by which a slave delayed S of a byte; 0 if no slave did. If the 1 of S was
  /// damaged on CDS, this looks like a delay, too. An error in a byte read is then always detected.
  /// An error in a byte that is written after another one is not: master and slave differ by a bit,
  /// and the echo agrees for half of all values although nothing was written. Read back the bytes
  /// written with a delay, or write each register in a separate access: the protocol allows no
  /// delay of the first byte.
  Picoseconds longest_busy{};
  /// Frames since the access began, including this one.
  std::uint32_t frames = 0;
  /// Bytes read with a good CRC, or written with a good echo; the first ones of the request.
  std::uint8_t bytes_done = 0;
  /// Bit k: a slave took ID k in the last try. 0 for a broadcast.
  std::uint8_t slaves_present = 0;
  /// There are more slaves than the eight with an ID (IDL8).
  bool more_slaves = false;
  /// Command: bit k for a slave with ID k that accepted (IDA).
  std::uint8_t accepted = 0;
  /// Control frames begun or to begin: 1, and one more for each retry.
  std::uint16_t tries = 0;
  /// Why the access did not complete; the last try's cause.
  std::optional<ControlError> error;
  /// The cause of the last retry.
  std::optional<ControlError> retried;
};

// ---- An access, the CDM bits that request it, and the meaning of the answers

enum class ControlKind : std::uint8_t { read, write, addressed, broadcast };

/// One access of a ControlSession. `possible`: a control frame can request it.
struct ControlRequest {
  ControlKind kind = ControlKind::read;
  ExecuteIf execute_if = ExecuteIf::all_accept;
  /// Bit k: the slave with ID k is addressed. 0: broadcast.
  std::uint8_t slaves = 0;
  /// Bytes to read or write.
  std::uint8_t size = 0;
  bool possible = false;
  /// The header of the first byte; see register_header() and command_header().
  std::uint16_t header = 0;
  std::uint8_t* to = nullptr;
  const std::uint8_t* from = nullptr;

  /// The CDM bits up to S of the first byte or to EX = 1, the first one topmost; zeros follow.
  /// \param bytes_done how many bytes of a sequential access are already done and are skipped
  constexpr std::uint32_t first_bits(unsigned bytes_done) const {
    const auto here = static_cast<std::uint16_t>(header + bytes_done);
    return 1U << 31U | std::uint32_t{here} << 20U | std::uint32_t{header_crc(here)} << 16U | tail();
  }

  /// Why the access ends after CDS bits 0…15, bit 0 topmost; the slaves that are present go into
  /// `outcome`.
  constexpr std::optional<ControlError> judge_ids(std::uint16_t cds,
                                                  ControlOutcome& outcome) const {
    // IDL0 … IDL8 and seven zeros: slaves take an ID from 0 on without a gap.
    const std::uint32_t zeros = ~std::uint32_t{cds} & 0xFFFFU;
    if ((zeros & (zeros + 1U)) != 0 || zeros < 0x7FU) return ControlError::id_pattern;
    const auto count = static_cast<unsigned>(std::countl_zero(zeros)) - 16U;
    if (count == 0) return ControlError::no_answer;
    outcome.more_slaves = count > control_max_slaves;
    outcome.slaves_present = static_cast<std::uint8_t>((1U << count) - 1U);
    if (!enough(outcome.slaves_present)) return ControlError::no_such_slave;
    return std::nullopt;
  }

  /// Why a register access ends after R and W, W lowest.
  constexpr std::optional<ControlError> judge_access(std::uint16_t cds) const {
    const bool r = (cds & 2U) != 0;
    const bool w = (cds & 1U) != 0;
    if (kind == ControlKind::read) {
      if (r && !w) return std::nullopt;
      if (r) return ControlError::refused;
      return w ? ControlError::rw_pattern : ControlError::not_addressed;
    }
    if (r) return ControlError::rw_pattern;
    if (w) return std::nullopt;
    return ControlError::refused_or_not_addressed;
  }

  /// Why a command is dropped after CDS bits 16…23, bit 23 lowest; the slaves that accept it go
  /// into `outcome`.
  constexpr std::optional<ControlError> judge_ida(std::uint16_t cds,
                                                  ControlOutcome& outcome) const {
    // IDA0 comes first.
    unsigned ida = cds & 0xFFU;
    ida = (ida & 0x0FU) << 4U | ida >> 4U;
    ida = (ida & 0x33U) << 2U | (ida >> 2U & 0x33U);
    ida = (ida & 0x55U) << 1U | (ida >> 1U & 0x55U);
    outcome.accepted = static_cast<std::uint8_t>(ida);
    if (execute_if == ExecuteIf::always) return std::nullopt;
    if ((outcome.accepted | slaves) != slaves) return ControlError::ida_pattern;
    if (!enough(outcome.accepted)) return ControlError::not_accepted;
    return std::nullopt;
  }

 private:
  constexpr bool enough(std::uint8_t those) const {
    const unsigned addressed = those & slaves;
    return execute_if == ExecuteIf::all_accept ? addressed == slaves : addressed != 0;
  }

  constexpr std::uint32_t tail() const {
    switch (kind) {
      case ControlKind::read:
        return 0b101U << 13U;  // R, W, S
      case ControlKind::write:
        return 0b011U << 13U;
      case ControlKind::addressed:
        return 0b1'0000000'1U << 7U;  // S, while IDA comes, EX
      case ControlKind::broadcast:
        return 0b11U << 14U;  // S, EX
    }
    return 0;
  }
};

/// One access at a time. Every access ends for any CDS if time advances: a try takes the frames
/// that it needs, at most 14 lost ones before its start bit, and busy_max for each byte.
class ControlSession {
 public:
  constexpr explicit ControlSession(const ControlOptions& options = {}) : options_(options) {}

  /// Begins to read `to.size()` registers (1…64) from `address` on, the last one at most 127. `to`
  /// must live until done(). A request that no control frame can express ends immediately, with
  /// bad_request.
  /// \pre done()
  /// \param slave ID, 0…7
  constexpr void read(unsigned slave, unsigned address, std::span<std::uint8_t> to) {
    ControlRequest request = register_request(ControlKind::read, slave, address, to.size());
    request.to = to.data();
    begin(request);
  }
  /// Begins to write `from`; otherwise like read().
  constexpr void write(unsigned slave, unsigned address, std::span<const std::uint8_t> from) {
    ControlRequest request = register_request(ControlKind::write, slave, address, from.size());
    request.from = from.data();
    begin(request);
  }
  /// Begins a command to the slaves with these IDs, bit k for ID k; none: bad_request. Done without
  /// an error means that it was accepted and EX = 1 was sent, which no slave confirms. \pre done()
  constexpr void command(std::uint8_t slaves, ControlCommand command,
                         ExecuteIf execute_if = ExecuteIf::all_accept) {
    begin({.kind = ControlKind::addressed,
           .execute_if = execute_if,
           .slaves = slaves,
           .possible = slaves != 0,
           .header = command_header(slaves, command)});
  }
  /// Begins a command to all slaves, also those without an ID. It needs no CDS and has no answer; a
  /// frame whose CDS is missing counts as sent. \pre done()
  constexpr void broadcast(ControlCommand command) {
    begin({.kind = ControlKind::broadcast, .possible = true, .header = command_header(0, command)});
  }

  /// Ends the access with `cancelled`. The zeros that its slaves then need are sent with the next
  /// frames, before another access begins.
  constexpr void cancel() {
    if (done()) return;
    zeros_ = 0;
    end_with(ControlError::cancelled);
  }

  /// \param now may wrap around at the limits of its type
  /// \param cds of this frame
  /// \return the CDM bit at the end of this frame
  constexpr bool step(Picoseconds now, CdsBit cds) {
    const bool bit = next(now, cds);
    if (bit) {
      zeros_ = 0;
    } else if (zeros_ < control_reset_zeros &&
               (cds != CdsBit::missing || (needs_no_cds() && !done()))) {
      ++zeros_;
    }
    return bit;
  }

  /// The CDM bit of the next frame, before its CDS is known.
  /// \pre no command to addressed slaves: EX would not wait for their answers
  constexpr bool cdm_ahead() const {
    switch (phase_) {
      case Phase::idle:
        return false;
      case Phase::lead:
        return zeros_ >= control_reset_zeros;
      case Phase::frame:
      case Phase::byte:
        return (word_ << k_ >> 31U) != 0;
      case Phase::next:
        return outcome_.bytes_done != request_.size;
      default:
        return request_.kind == ControlKind::read || request_.from[outcome_.bytes_done] >> 7U != 0;
    }
  }
  /// Like step(), for a frame that ended with cdm_ahead(). A slave that delays a further byte of a
  /// write causes busy_too_long; a retry continues with this byte.
  constexpr void take_cds(Picoseconds now, CdsBit cds) {
    const bool sent = cdm_ahead();
    static_cast<void>(step(now, cds));
    if (sent) zeros_ = 0;
    if (phase_ == Phase::busy && request_.kind == ControlKind::write) {
      fail(ControlError::busy_too_long);
    }
  }

  constexpr bool done() const { return phase_ == Phase::idle; }
  /// The outcome of the last access, complete when done().
  constexpr const ControlOutcome& outcome() const { return outcome_; }
  constexpr void set_options(const ControlOptions& options) { options_ = options; }

 private:
  enum class Phase : std::uint8_t {
    idle,
    lead,         // 14 zeros
    frame,        // header and the bits after it, bit k_ of word_
    write_start,  // S of a write's first byte is due on CDS
    start,        // S of any other byte is due
    busy,         // S is late since busy_since_
    byte,         // DATA, CRC and P, bit k_ of word_
    next,         // P is due: whether another byte may follow
  };

  static constexpr ControlRequest register_request(ControlKind kind, unsigned slave,
                                                   unsigned address, std::size_t size) {
    return {.kind = kind,
            .slaves = static_cast<std::uint8_t>(1U << (slave & 7U)),
            .size = static_cast<std::uint8_t>(size),
            .possible = slave < control_max_slaves && size >= 1 && size <= sequential_max_bytes &&
                        address < register_count && size <= register_count - address,
            .header = register_header(slave, address)};
  }

  constexpr bool needs_no_cds() const { return request_.kind == ControlKind::broadcast; }

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
    if (cds == CdsBit::missing && !needs_no_cds()) return frame_lost();
    const bool one = cds == CdsBit::one;
    received_ = static_cast<std::uint16_t>(std::uint32_t{received_} << 1U | (one ? 1U : 0U));
    switch (phase_) {
      case Phase::lead:
        return zeros_ >= control_reset_zeros && begin_frame();
      case Phase::frame:
        return k_ < control_bit::header_end ? send() : after_header();
      case Phase::write_start:
        return one ? begin_byte() : fail(ControlError::start_missing);
      case Phase::start:
        if (one) return begin_byte();
        busy_since_ = now;
        phase_ = Phase::busy;
        return options_.busy_max.count > 0 || fail(ControlError::busy_too_long);
      case Phase::busy:
        return busy(wrapping_elapsed(busy_since_, now), one);
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

  constexpr bool after_header() {
    if (needs_no_cds()) {
      if (k_ == control_bit::ex_broadcast) phase_ = Phase::idle;
      return send();
    }
    const bool addressed = request_.kind == ControlKind::addressed;
    std::optional<ControlError> error;
    if (k_ == control_bit::header_end) {
      error = request_.judge_ids(received_, outcome_);
    } else if (addressed && k_ == control_bit::ex_addressed) {
      error = request_.judge_ida(received_, outcome_);
      phase_ = Phase::idle;
    } else if (!addressed && k_ == control_bit::byte_start) {
      error = request_.judge_access(received_);
      phase_ = request_.kind == ControlKind::read ? Phase::start : Phase::write_start;
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
    if (request_.kind == ControlKind::write) {
      const std::uint8_t data = request_.from[outcome_.bytes_done];
      word_ = (std::uint32_t{data} << 4U | byte_crc(data)) << 20U;
    }
    return send();
  }

  // DATA and CRC have been received; P = 0 is sent.
  constexpr bool end_byte() {
    const unsigned received = received_ & 0xFFFU;
    if (request_.kind == ControlKind::read) {
      const auto data = static_cast<std::uint8_t>(received >> 4U);
      if (byte_crc(data) != (received & 0xFU)) return fail(ControlError::data_crc);
      request_.to[outcome_.bytes_done] = data;
    } else if (received != word_ >> 20U) {
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

  // A lost frame after the last byte is harmless; before the start bit it only loses a zero.
  [[gnu::noinline, gnu::cold]] constexpr bool frame_lost() {
    if (phase_ == Phase::next && outcome_.bytes_done == request_.size) return next_byte(false);
    if (phase_ == Phase::lead && ++k_ < control_reset_zeros) return false;
    return fail(ControlError::frame_lost);
  }

  // Returns CDM: the first of 14 zeros.
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
  std::uint32_t word_ = 0;      // the bits to send, the first one topmost
  std::uint16_t received_ = 0;  // the last 16 bits of CDS, the latest lowest
  Phase phase_ = Phase::idle;
  std::uint8_t k_ = 0;      // the next bit of word_; in the lead the frames lost
  std::uint8_t zeros_ = 0;  // CDM bits since the last 1, or since the last error; at most 14
};

}  // namespace biss
