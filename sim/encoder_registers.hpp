// The registers of one simulated encoder, and its reaction to commands.
#pragma once

#include <cstdint>
#include <optional>

#include "biss/control/register_map.hpp"
#include "biss/slave/banked_registers.hpp"
#include "biss/slave/register_server.hpp"

namespace biss::sim {

/// Accepts the commands that switch the data channels and the control communication, and refuses all
/// others. An addressed `channels` activates the data channels, a broadcast deactivates them.
/// `control` has no effect here: the RegisterServer executes it.
struct EncoderCommands : NoRegisterHooks {
  bool channels_active = true;

  static bool accepts(ControlCommand command, bool /*broadcast*/) {
    return command == ControlCommand::channels || command == ControlCommand::control;
  }
  void execute(ControlCommand command, bool broadcast) {
    if (command == ControlCommand::channels) channels_active = !broadcast;
  }
};

/// 256 banks and the registers 0x40 … 0x7F; at first none is available.
class EncoderRegisters : public BankedRegisters<bank_count, EncoderCommands> {
 public:
  /// Makes one register available. \pre address 0x41 … 0x7F
  void put(unsigned address, std::uint8_t value, RegisterProtection protection) {
    BankedRegisters::put(address, {&value, 1}, protection);
  }
  /// Makes BSEL available with this value. Before, accesses to it are refused and bank 0 is the only
  /// one. `bank` may be a bank without registers.
  void put_bsel(std::uint8_t bank) {
    has_bsel_ = true;
    write(0 /* the only slave */, reg::bsel, bank);
  }
  /// Hides permits() of BankedRegisters, which permits BSEL from the beginning.
  bool permits(unsigned slave, RegisterAccess access, std::uint8_t address) {
    return (address != reg::bsel || has_bsel_) && BankedRegisters::permits(slave, access, address);
  }
  /// The data channels send positions: active at first, then as the master commands.
  bool channels_active() { return hooks().channels_active; }

 private:
  bool has_bsel_ = false;
};

/// Passes accesses on to registers elsewhere, which are too large (20 KB) to move with the server and
/// must outlive it.
struct RegistersAt {
  /// Not null. A pointer, because an Encoder can be assigned.
  EncoderRegisters* registers;

  bool permits(unsigned slave, RegisterAccess access, std::uint8_t address) const {
    return registers->permits(slave, access, address);
  }
  std::optional<std::uint8_t> read(unsigned slave, std::uint8_t address) const {
    return registers->read(slave, address);
  }
  bool ready(unsigned slave) const { return registers->ready(slave); }
  void write(unsigned slave, std::uint8_t address, std::uint8_t value) const {
    registers->write(slave, address, value);
  }
  bool accepts(unsigned slave, ControlCommand command, bool broadcast) const {
    return registers->accepts(slave, command, broadcast);
  }
  void execute(unsigned slave, ControlCommand command, bool broadcast) const {
    registers->execute(slave, command, broadcast);
  }
};

/// The encoder's end of the control communication.
using EncoderControl = RegisterServer<RegistersAt>;

}  // namespace biss::sim
