// The control communication in a capture: a CDM bit and a CDS bit a request cycle in, accesses to
// registers and commands out.
#pragma once

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
  std::optional<std::uint8_t> data;
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
  void push(std::uint64_t number, const Cycle& cycle);
  /// The same, bits given. A missing bit aborts an access, with the outcome `lost`.
  void push(std::uint64_t number, Picoseconds time, std::optional<bool> cds,
            std::optional<bool> cdm, AccessOutcome lost = AccessOutcome::frame_lost);
  /// The capture ends.
  void finish();

  /// Number of cycles with CDS = 1 outside of an access.
  std::uint64_t stray_cds() const { return stray_cds_; }
  /// CDM = 1 with fewer than 14 zeros before it, outside of an access.
  std::uint64_t stray_cdm() const { return stray_cdm_; }

 private:
  enum class Phase : std::uint8_t { idle, header, kind, command, start, byte, next, over };

  void step(std::uint64_t number, Picoseconds time, bool cds, bool cdm, bool reduced);
  // Each takes the cycle at hand in its phase.
  void idle();
  void header();
  void kind();
  void command();
  void start();
  void byte();
  void next();
  bool cds() const { return (cds_ & 1U) != 0; }
  bool cdm() const { return (cdm_ & 1U) != 0; }
  void take_ids();
  AccessOutcome judge_ids() const;
  void report(AccessOutcome outcome);
  void fail(AccessOutcome outcome);

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
