#include "sim/control_master.hpp"

#include <span>

namespace biss::sim {

std::uint32_t least_cycles(const ControlAccess& access) {
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

bool ControlMaster::step(std::uint64_t cycle, Picoseconds begin_of_cycle, Picoseconds now,
                         CdsBit cds) {
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

void ControlMaster::begin(std::uint64_t cycle, Picoseconds time) {
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

ControlRecord ControlMaster::current() const {
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

std::vector<ControlRecord> ControlMaster::records() const {
  std::vector<ControlRecord> all = records_;
  if (open_) all.push_back(current());
  return all;
}

}  // namespace biss::sim
