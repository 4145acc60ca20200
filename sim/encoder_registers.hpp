// The registers of one simulated encoder, and what it does when it is commanded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "biss/control/register_map.hpp"
#include "biss/slave/banked_registers.hpp"
#include "biss/slave/register_server.hpp"

namespace biss::sim {

/// 256 banks and the registers 0x40 … 0x7F; at first none is available. It obeys the commands that
/// switch its data channels and its control communication, and accepts no other.
class EncoderRegisters {
 public:
  /// \pre number < 256
  RegisterBank& bank(std::size_t number) { return map_.bank(number); }
  void set_busy(const RegisterBusy& busy) { map_.set_busy(busy); }
  /// One of the registers 0x41 … 0x7F.
  void put(unsigned address, std::uint8_t value, RegisterProtection protection) {
    map_.put(address, {&value, 1}, protection);
  }
  /// Makes BSEL available; without, it is refused and bank 0 is the only one.
  void put_bsel(std::uint8_t bank) {
    has_bsel_ = true;
    map_.write(0, reg::bsel, bank);
  }
  std::uint8_t bsel() const { return map_.bsel(); }
  /// As the master commanded.
  bool channels_active() { return map_.hooks().channels_active; }

  bool permits(unsigned slave, RegisterAccess access, std::uint8_t address) {
    return (address != reg::bsel || has_bsel_) && map_.permits(slave, access, address);
  }
  std::optional<std::uint8_t> read(unsigned slave, std::uint8_t address) {
    return map_.read(slave, address);
  }
  bool ready(unsigned slave) { return map_.ready(slave); }
  void write(unsigned slave, std::uint8_t address, std::uint8_t value) {
    map_.write(slave, address, value);
  }
  bool accepts(unsigned slave, ControlCommand command, bool broadcast) {
    return map_.accepts(slave, command, broadcast);
  }
  void execute(unsigned slave, ControlCommand command, bool broadcast) {
    map_.execute(slave, command, broadcast);
  }

 private:
  struct Commands : NoRegisterHooks {
    bool channels_active = true;

    static bool accepts(ControlCommand command, bool /*broadcast*/) {
      return command == ControlCommand::channels || command == ControlCommand::control;
    }
    void execute(ControlCommand command, bool broadcast) {
      if (command == ControlCommand::channels) channels_active = !broadcast;
    }
  };

  BankedRegisters<bank_count, Commands> map_;
  bool has_bsel_ = false;
};

/// Speaks for registers that stay where they are: some 20 KB, too many to go about with the server.
struct RegistersAt {
  EncoderRegisters* registers = nullptr;

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
