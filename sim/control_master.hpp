// The control communication of the master during its position frames: one access after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/control/session.hpp"

namespace biss::sim {

enum class AccessKind : std::uint8_t { read, write, command, broadcast };

/// An access of the master over CDM and CDS.
struct ControlAccess {
  AccessKind kind = AccessKind::read;
  /// Read, write: ID and first address.
  std::uint8_t slave = 0;
  std::uint8_t address = 0;
  /// Read: the number of registers, 1 to 64.
  std::uint8_t size = 1;
  /// Write: 1 to 64 bytes.
  std::vector<std::uint8_t> data{};
  /// Command: bit k for the slave with ID k.
  std::uint8_t slaves = 0;
  ControlCommand command{};
  ExecuteIf execute_if = ExecuteIf::all_accept;
  /// Begins at this cycle, or after the previous access if that is later.
  std::uint64_t not_before = 0;
};

/// The least number of cycles of an access, without the 14 zeros before it.
inline std::uint32_t least_cycles(const ControlAccess& access) {
  switch (access.kind) {
    case AccessKind::read:
      return register_access_frames(access.size) - control_reset_zeros;
    case AccessKind::write:
      return register_access_frames(access.data.size()) - control_reset_zeros;
    case AccessKind::command:
      return addressed_command_frames - control_reset_zeros;
    case AccessKind::broadcast:
      break;
  }
  return broadcast_command_frames - control_reset_zeros;
}

/// The outcome of an access.
struct ControlRecord {
  std::size_t access = 0;   ///< its number in the list
  std::uint64_t cycle = 0;  ///< its first cycle, including the zeros before it
  Picoseconds time{};       ///< of that cycle
  std::uint64_t cycles = 0;
  /// The bytes read, or written with a good echo.
  std::vector<std::uint8_t> data{};
  ControlOutcome outcome{};
  /// False: the run ended before the access.
  bool finished = false;
};

/// Makes one step per cycle. The accesses follow each other, with any outcomes.
class ControlMaster {
 public:
  ControlMaster(std::vector<ControlAccess> accesses, const ControlOptions& options)
      : accesses_(std::move(accesses)), session_(options) {}
  ControlMaster(const ControlMaster&) = delete;
  ControlMaster& operator=(const ControlMaster&) = delete;

  /// Takes the CDS of a cycle. \param begin_of_cycle its time
  /// \return the CDM that ends the cycle
  bool step(std::uint64_t cycle, Picoseconds begin_of_cycle, Picoseconds now, CdsBit cds) {
    if (!open_ && next_ < accesses_.size() && cycle >= accesses_[next_].not_before) {
      begin(cycle, begin_of_cycle);
    }
    const bool cdm = session_.step(now, cds);
    last_cycle_ = cycle;
    if (open_ && session_.done()) {
      records_.push_back(current());
      records_.back().finished = true;
      open_ = false;
    }
    return cdm;
  }

  /// Every access is finished.
  bool done() const { return next_ == accesses_.size() && session_.done(); }
  const std::vector<ControlAccess>& accesses() const { return accesses_; }
  /// In the order of the list, including the access in progress.
  std::vector<ControlRecord> records() const {
    std::vector<ControlRecord> all = records_;
    if (open_) all.push_back(current());
    return all;
  }

 private:
  void begin(std::uint64_t cycle, Picoseconds time) {
    const ControlAccess& access = accesses_[next_++];
    begun_cycle_ = cycle;
    begun_time_ = time;
    open_ = true;
    switch (access.kind) {
      case AccessKind::read:
        return session_.read(access.slave, access.address, std::span(read_).first(access.size));
      case AccessKind::write:
        return session_.write(access.slave, access.address, access.data);
      case AccessKind::command:
        return session_.command(access.slaves, access.command, access.execute_if);
      case AccessKind::broadcast:
        return session_.broadcast(access.command);
    }
  }

  ControlRecord current() const {
    const ControlAccess& access = accesses_[next_ - 1];
    ControlRecord record{.access = next_ - 1,
                         .cycle = begun_cycle_,
                         .time = begun_time_,
                         .cycles = last_cycle_ - begun_cycle_ + 1,
                         .outcome = session_.outcome()};
    const std::vector<std::uint8_t>& bytes = access.kind == AccessKind::write ? access.data : read_;
    record.data.assign(bytes.begin(), bytes.begin() + record.outcome.bytes_done);
    return record;
  }

  std::vector<ControlAccess> accesses_;
  ControlSession session_;
  std::vector<ControlRecord> records_;
  std::vector<std::uint8_t> read_ = std::vector<std::uint8_t>(sequential_max_bytes);
  std::size_t next_ = 0;
  std::uint64_t begun_cycle_ = 0;
  std::uint64_t last_cycle_ = 0;
  Picoseconds begun_time_{};
  bool open_ = false;
};

}  // namespace biss::sim
