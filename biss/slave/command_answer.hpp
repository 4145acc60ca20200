// A command's bits behind its header: IDA and EX, or EX at once where all slaves are meant.
#pragma once

#include <cstdint>
#include <optional>

#include "biss/control/control_frame.hpp"
#include "biss/control/control_header.hpp"
#include "biss/slave/id_assignment.hpp"
#include "biss/slave/register_owner.hpp"

namespace biss::slave_detail {

template <RegisterOwner Owner, unsigned Ids>
class CommandAnswer {
 public:
  constexpr void begin(const ControlHeader& header) {
    command_ = header.command;
    slaves_ = header.slaves;
    accepted_ = 0;
    index_ = control_bit::header_end;
    done_ = false;
  }

  /// The next CDM bit. \return the CDS bit with its index
  constexpr bool take(bool bit, IdAssignment<Ids>& ids, Owner& owner) {
    const unsigned index = index_++;
    if (index == (slaves_ == 0 ? control_bit::ex_broadcast : control_bit::ex_addressed)) {
      done_ = true;
      if (bit) slaves_ == 0 ? execute_by_all(ids, owner) : execute(ids, owner);
      return false;
    }
    done_ = bit != (index == control_bit::header_end);  // S, then zeros
    return !done_ && slaves_ != 0 && answer(index - control_bit::ida, ids, owner);
  }

  /// Executed, dropped or broken off.
  constexpr bool done() const { return done_; }

 private:
  constexpr bool answer(unsigned id, const IdAssignment<Ids>& ids, Owner& owner) {
    const std::optional<unsigned> slave = ids.slave_of(id);
    if (!slave || (slaves_ >> id & 1U) == 0) return false;
    if (!owner.accepts(*slave, command_, false)) return false;
    accepted_ = static_cast<std::uint8_t>(accepted_ | 1U << *slave);
    return true;
  }

  constexpr void execute(IdAssignment<Ids>& ids, Owner& owner) {
    for (unsigned slave = 0; slave < Ids; ++slave) {
      if ((accepted_ >> slave & 1U) == 0) continue;
      if (command_ == ControlCommand::control) ids.silence(slave);
      owner.execute(slave, command_, false);
    }
  }

  constexpr void execute_by_all(IdAssignment<Ids>& ids, Owner& owner) {
    if (command_ == ControlCommand::control) ids.admit_all();
    for (unsigned slave = 0; slave < Ids; ++slave) {
      if (owner.accepts(slave, command_, true)) owner.execute(slave, command_, true);
    }
  }

  ControlCommand command_ = ControlCommand::channels;
  std::uint8_t slaves_ = 0;    // bit k: ID k; 0: all
  std::uint8_t accepted_ = 0;  // bit k: this device's slave k
  std::uint8_t index_ = 0;
  bool done_ = true;
};

}  // namespace biss::slave_detail
