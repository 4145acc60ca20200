// The master's control communication beside its position frames: accesses one after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/control/session.hpp"

namespace biss::sim {

enum class AccessKind : std::uint8_t { read, write, command, broadcast };

/// Something that the master does over CDM and CDS.
struct ControlAccess {
  AccessKind kind = AccessKind::read;
  /// Read, write: ID and first address.
  std::uint8_t slave = 0;
  std::uint8_t address = 0;
  /// Read: how many registers, 1 to 64.
  std::uint8_t size = 1;
  /// Write: what, 1 to 64 bytes.
  std::vector<std::uint8_t> data{};
  /// Command: bit k for the slave with ID k.
  std::uint8_t slaves = 0;
  ControlCommand command{};
  ExecuteIf execute_if = ExecuteIf::all_accept;
  /// Begins with this cycle, or when the one before it is over.
  std::uint64_t not_before = 0;
};

/// Cycles that an access takes at least, without the 14 zeros before it.
std::uint32_t least_cycles(const ControlAccess& access);

/// How an access went.
struct ControlRecord {
  std::size_t access = 0;   ///< its number in the list
  std::uint64_t cycle = 0;  ///< the one that it began with, zeros before it included
  Picoseconds time{};       ///< of that cycle
  std::uint64_t cycles = 0;
  /// What was read, or written with a good echo.
  std::vector<std::uint8_t> data{};
  ControlOutcome outcome{};
  /// False: the run ended first.
  bool finished = false;
};

/// Makes one step a cycle and one access after the other, whatever became of the one before.
class ControlMaster {
 public:
  ControlMaster(std::vector<ControlAccess> accesses, const ControlOptions& options)
      : accesses_(std::move(accesses)), session_(options) {}
  ControlMaster(const ControlMaster&) = delete;
  ControlMaster& operator=(const ControlMaster&) = delete;

  /// The CDS of a cycle. \param begin of the cycle \param now
  /// \return the CDM that is to end it
  bool step(std::uint64_t cycle, Picoseconds begin, Picoseconds now, CdsBit cds);

  /// Every access is over.
  bool done() const { return next_ == accesses_.size() && session_.done(); }
  const std::vector<ControlAccess>& accesses() const { return accesses_; }
  /// In the order of the list; of the access under way, how far it is.
  std::vector<ControlRecord> records() const;

 private:
  void begin(std::uint64_t cycle, Picoseconds time);
  ControlRecord current() const;

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
