// The control communication in a capture: a CDM bit and a CDS bit a request cycle in, accesses to
// registers and commands out.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>

#include "biss/base/units.hpp"
#include "biss/control/control_frame.hpp"
#include "biss/control/session.hpp"
#include "decode/cycle.hpp"

namespace biss::decode {

/// Result of an access as seen on the line.
enum class AccessOutcome : std::uint8_t {
  ok,
  header_crc,  ///< the header as the master sent it does not fit its CRC: no slave answers
  no_answer,   ///< as in ControlError, like all others with the same name
  no_such_slave,
  id_pattern,
  refused,
  not_addressed,
  refused_or_not_addressed,
  rw_pattern,
  busy_too_long,  ///< the master gave up while it waited for S
  start_missing,
  data_crc,   ///< read: the byte and its CRC do not fit
  write_crc,  ///< write: the byte as the master sent it does not fit its CRC
  echo,
  next_unavailable,  ///< P = 1, and the master requested the next byte anyway
  not_accepted,      ///< command: EX = 0, and not every addressed slave had accepted
  dropped,           ///< command: EX = 0, although all had accepted
  frame_lost,        ///< a cycle of the access brought no CDS or no CDM
  cut_end,           ///< the capture ends within the access
  /// The header was right, but a cycle of the access was a reduced frame, which carries no CDS: the
  /// slaves' answer is unknown.
  cds_not_seen,
};

inline constexpr std::size_t access_outcome_count = 20;
std::string_view name_of(AccessOutcome outcome);

/// One byte read or written, or one command, as seen on the line.
struct SeenAccess {
  enum class Kind : std::uint8_t { read, write, command, unknown };

  std::uint64_t cycle = 0;  ///< of the start bit; for a further byte of a sequence, of its S
  Picoseconds time{};       ///< of that cycle
  Kind kind = Kind::unknown;
  AccessOutcome outcome = AccessOutcome::ok;
  std::uint8_t id = 0;      ///< of the slave; registers only
  std::uint8_t slaves = 0;  ///< commands: bit k for the slave with ID k, 0: broadcast
  std::uint8_t address = 0;
  ControlCommand command{};
  /// Read: the byte that came with a good CRC. Write: the byte sent, echoed or not.
  std::optional<std::uint8_t> data{};
  std::uint8_t slaves_present = 0;  ///< IDL0 … IDL7, bit k for ID k
  bool more_slaves = false;         ///< IDL8
  std::uint8_t accepted = 0;        ///< commands: IDA, bit k for ID k
  std::uint32_t busy_cycles = 0;    ///< cycles by which S came late
  Picoseconds busy{};          ///< from the cycle in which S was due until it came, or was given up
  std::uint32_t cycles = 0;    ///< from the start bit, or S, to the last bit
  bool reduced = false;        ///< a reduced frame was among its cycles: CDS is not known
  bool header_sent = false;    ///< the header's CRC was right: id or slaves are known
  bool next_available = true;  ///< P was 0: the next address may be accessed
  /// A further byte of a sequential access: without its own header.
  bool continues = false;
};

std::string_view name_of(SeenAccess::Kind kind);

/// Follows every cycle in bounded memory. 14 zeros on CDM reset it at any time, as they reset a
/// slave.
class ControlListener {
 public:
  using OnAccess = std::function<void(const SeenAccess&)>;

  explicit ControlListener(OnAccess on_access) : on_access_(std::move(on_access)) {}

  /// The next cycle of the capture.
  void push(std::uint64_t number, const Cycle& cycle) {
    // Too short to be a request: no slave takes notice of its CDM.
    if (cycle.status == CycleStatus::ma_glitch || cycle.status == CycleStatus::cut_start) return;
    constexpr std::uint32_t reduced_edges = 2;
    if (cycle.rising_edges == reduced_edges && !cycle.cds() && cycle.cdm) {
      return step(number, cycle.time, false, *cycle.cdm, true);
    }
    // CDM is missing after a CDS only if the capture ends before the level of MA is certain.
    const bool cut = cycle.status == CycleStatus::cut_end || (cycle.cds() && !cycle.cdm);
    push(number, cycle.time, cycle.cds(), cycle.cdm,
         cut ? AccessOutcome::cut_end : AccessOutcome::frame_lost);
  }

  /// The same, bits given. A missing bit breaks off an access, with the outcome `lost`.
  void push(std::uint64_t number, Picoseconds time, std::optional<bool> cds,
            std::optional<bool> cdm, AccessOutcome lost = AccessOutcome::frame_lost) {
    if (!cds || !cdm) {
      if (phase_ != Phase::idle && phase_ != Phase::over) fail(lost);
      zeros_ = 0;
      return;
    }
    step(number, time, *cds, *cdm, false);
  }

  /// The capture ends.
  void finish() {
    if (phase_ != Phase::idle && phase_ != Phase::over) fail(AccessOutcome::cut_end);
  }

  /// Number of cycles with CDS = 1 outside of an access.
  std::uint64_t stray_cds() const { return stray_cds_; }
  /// CDM = 1 with fewer than 14 zeros before it, outside of an access.
  std::uint64_t stray_cdm() const { return stray_cdm_; }

 private:
  enum class Phase : std::uint8_t { idle, header, kind, command, start, byte, next, over };

  static constexpr unsigned byte_bits = 12;  // DATA and CRC

  static bool fits(unsigned data_and_crc) {
    return byte_crc(static_cast<std::uint8_t>(data_and_crc >> 4U)) == (data_and_crc & 0xFU);
  }

  void step(std::uint64_t number, Picoseconds time, bool cds, bool cdm, bool reduced) {
    using Listener = ControlListener;
    // By phase.
    constexpr std::array handlers{&Listener::idle,    &Listener::header, &Listener::kind,
                                  &Listener::command, &Listener::start,  &Listener::byte,
                                  &Listener::next};
    number_ = number;
    time_ = time;
    reduced_ = reduced;
    cdm_ = cdm_ << 1U | (cdm ? 1U : 0U);
    cds_ = cds_ << 1U | (cds ? 1U : 0U);
    ++access_.cycles;
    access_.reduced = access_.reduced || reduced;
    if (phase_ != Phase::over) (this->*handlers[static_cast<std::size_t>(phase_)])();
    zeros_ = cdm ? 0 : zeros_ + 1;
    if (zeros_ < control_reset_zeros) return;
    if (phase_ == Phase::header) fail(AccessOutcome::header_crc);
    phase_ = Phase::idle;
  }

  // Each takes the cycle at hand in its phase.
  void idle() {
    if (cds()) ++stray_cds_;
    if (!cdm()) return;
    if (zeros_ < control_reset_zeros) {
      ++stray_cdm_;
      return;
    }
    access_ = {.cycle = number_, .time = time_, .cycles = 1, .reduced = reduced_};
    phase_ = Phase::header;
    k_ = control_bit::cts;
  }

  void header() {
    if (++k_ < control_bit::header_end) return;
    const auto header = parse_header(static_cast<std::uint32_t>(cdm_));
    if (!header) return fail(AccessOutcome::header_crc);
    access_.header_sent = true;
    access_.id = header->slave;
    access_.slaves = header->slaves;
    access_.address = header->address;
    access_.command = header->command;
    if (!header->register_access) access_.kind = SeenAccess::Kind::command;
    phase_ = header->register_access ? Phase::kind : Phase::command;
  }

  void kind() {
    if (k_ == control_bit::header_end) take_ids();
    if (k_++ < control_bit::byte_start) return;
    const unsigned asked = cdm_ >> 1U & 3U;
    const unsigned answered = cds_ & 3U;
    constexpr unsigned read = 0b10;
    constexpr unsigned write = 0b01;
    if (asked == read) access_.kind = SeenAccess::Kind::read;
    if (asked == write) access_.kind = SeenAccess::Kind::write;
    // A master that sees the reason in the IDs stops before R and W.
    const AccessOutcome ids = access_.reduced ? AccessOutcome::ok : judge_ids();
    if (ids != AccessOutcome::ok) return fail(ids);
    if (access_.kind == SeenAccess::Kind::unknown) return fail(AccessOutcome::rw_pattern);
    if (access_.reduced) {
      phase_ = Phase::start;
      return;
    }
    if (answered == 0) {
      return fail(asked == read ? AccessOutcome::not_addressed
                                : AccessOutcome::refused_or_not_addressed);
    }
    if (asked == read && answered == 0b11) return fail(AccessOutcome::refused);
    if (answered != asked) return fail(AccessOutcome::rw_pattern);
    phase_ = Phase::start;
    if (!cdm()) fail(AccessOutcome::busy_too_long);
  }

  void command() {
    if (k_ == control_bit::header_end) {
      take_ids();
      if (!cdm()) return fail(AccessOutcome::rw_pattern);
    }
    const bool all = access_.slaves == 0;
    if (k_++ < (all ? control_bit::ex_broadcast : control_bit::ex_addressed)) return;
    for (unsigned id = 0; !all && id < control_max_slaves; ++id) {
      if ((cds_ >> (7U - id) & 1U) != 0) access_.accepted |= static_cast<std::uint8_t>(1U << id);
    }
    phase_ = Phase::idle;
    if (cdm()) return report(AccessOutcome::ok);
    const bool accepted = (access_.slaves & ~access_.accepted) == 0;
    if (accepted) return report(AccessOutcome::dropped);
    report(access_.slaves_present == 0 ? AccessOutcome::no_answer : AccessOutcome::not_accepted);
  }

  void start() {
    if (access_.busy_cycles == 0) busy_since_ = time_;
    access_.busy = time_ - busy_since_;
    if (cds() || access_.reduced) {
      phase_ = Phase::byte;
      k_ = 1;
      return;
    }
    if (!access_.continues && access_.kind == SeenAccess::Kind::write)
      return fail(AccessOutcome::start_missing);
    ++access_.busy_cycles;
    if (!cdm()) fail(AccessOutcome::busy_too_long);
  }

  // CRC0 of CDS comes with P of CDM.
  void byte() {
    if (k_++ < byte_bits) return;
    const auto heard = static_cast<unsigned>(cds_ & 0xFFFU);
    const auto sent = static_cast<unsigned>(cdm_ >> 1U & 0xFFFU);
    phase_ = Phase::next;
    if (access_.kind == SeenAccess::Kind::read) {
      if (access_.reduced) return;
      if (!fits(heard)) return fail(AccessOutcome::data_crc);
      access_.data = static_cast<std::uint8_t>(heard >> 4U);
      return;
    }
    access_.data = static_cast<std::uint8_t>(sent >> 4U);
    if (!fits(sent)) return fail(AccessOutcome::write_crc);
    if (heard != sent && !access_.reduced) return fail(AccessOutcome::echo);
  }

  void next() {
    access_.next_available = !cds();
    report(AccessOutcome::ok);
    phase_ = Phase::idle;
    if (!cdm()) return;
    access_.cycle = number_;
    access_.time = time_;
    access_.address = static_cast<std::uint8_t>((access_.address + 1U) % register_count);
    access_.data.reset();
    access_.busy = {};
    access_.busy_cycles = 0;
    access_.cycles = 1;
    access_.continues = true;
    if (cds()) return fail(AccessOutcome::next_unavailable);
    phase_ = Phase::start;
  }

  bool cds() const { return (cds_ & 1U) != 0; }
  bool cdm() const { return (cdm_ & 1U) != 0; }

  // CDS 0 … 15 have arrived when the CDM bit 16 comes.
  void take_ids() {
    for (unsigned id = 0; id < control_max_slaves; ++id) {
      if ((cds_ >> (15U - id) & 1U) != 0) {
        access_.slaves_present |= static_cast<std::uint8_t>(1U << id);
      }
    }
    access_.more_slaves = (cds_ >> 7U & 1U) != 0;
    ids_end_in_zeros_ = (cds_ & 0x7FU) == 0;
  }

  AccessOutcome judge_ids() const {
    const unsigned present = access_.slaves_present;
    if (present == 0)
      return ids_end_in_zeros_ ? AccessOutcome::no_answer : AccessOutcome::id_pattern;
    const bool gap = (present & (present + 1U)) != 0;
    if (gap || !ids_end_in_zeros_) return AccessOutcome::id_pattern;
    return (present >> access_.id & 1U) != 0 ? AccessOutcome::ok : AccessOutcome::no_such_slave;
  }

  void report(AccessOutcome outcome) {
    access_.outcome =
        outcome == AccessOutcome::ok && access_.reduced ? AccessOutcome::cds_not_seen : outcome;
    on_access_(access_);
  }

  void fail(AccessOutcome outcome) {
    phase_ = Phase::over;
    report(outcome);
  }

  OnAccess on_access_;
  SeenAccess access_;
  Phase phase_ = Phase::idle;
  // Index of the CDM bit of the next cycle in the control frame; in a byte, how many of its bits
  // CDM has brought.
  unsigned k_ = 0;
  // The last bits of either side, the newest lowest.
  std::uint64_t cdm_ = 0;
  std::uint64_t cds_ = 0;
  unsigned zeros_ = 0;
  // The cycle at hand; a reduced frame is LAT and ACK, which carry CDM alone.
  std::uint64_t number_ = 0;
  Picoseconds time_{};
  bool reduced_ = false;
  bool ids_end_in_zeros_ = true;
  Picoseconds busy_since_{};
  std::uint64_t stray_cds_ = 0;
  std::uint64_t stray_cdm_ = 0;
};

}  // namespace biss::decode
