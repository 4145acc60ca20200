// A ready-made owner for a register server: 64 registers of the bank that BSEL selects at 0x00 …
// 0x3F, and 64 fixed ones at 0x40 … 0x7F (D2, register map).
//
//   struct Device : NoRegisterHooks {  // what the registers do
//     void written(std::uint8_t bank, std::uint8_t address, std::uint8_t value);
//   };
//   BankedRegisters<2, Device> registers;
//   registers.bank(1) = RegisterBank(eds, RegisterProtection::read_only);
//   registers.put_number<2>(reg::mfr_id, 0x6943, RegisterProtection::read_only);
//   RegisterServer server(registers);
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "biss/base/big_endian.hpp"
#include "biss/control/control_frame.hpp"
#include "biss/control/register_map.hpp"
#include "biss/slave/register_server.hpp"

namespace biss {

// ---- 64 registers with their protection

/// The three levels of D2; on the line, "protected" and "absent" are the same.
enum class RegisterProtection : std::uint8_t { not_available, read_only, read_write };

/// 64 registers. Offsets are 0 … 63; the owner of the bank defines the address of the first. At
/// first no register is available.
class RegisterBank {
 public:
  constexpr RegisterBank() = default;
  /// All 64 with the same protection.
  constexpr RegisterBank(std::span<const std::uint8_t, bank_bytes> values,
                         RegisterProtection protection) {
    put(0, values, protection);
  }

  /// Sets values and protection of the registers from `offset` on; values after the last register
  /// are ignored.
  constexpr void put(std::size_t offset, std::span<const std::uint8_t> values,
                     RegisterProtection protection) {
    for (std::size_t i = 0; i < values.size() && offset + i < bank_bytes; ++i) {
      values_[offset + i] = values[i];
      protect(offset + i, protection);
    }
  }
  /// The same for a number of `Bytes` bytes, the highest at the lowest offset.
  template <std::size_t Bytes>
  constexpr void put_number(std::size_t offset, std::uint64_t number,
                            RegisterProtection protection) {
    put(offset, to_big_endian<Bytes>(number), protection);
  }
  /// \pre offset below 64, here and below
  constexpr void protect(std::size_t offset, RegisterProtection protection) {
    const std::uint64_t mask = std::uint64_t{1} << offset;
    readable_ =
        protection == RegisterProtection::not_available ? readable_ & ~mask : readable_ | mask;
    writable_ = protection == RegisterProtection::read_write ? writable_ | mask : writable_ & ~mask;
  }

  constexpr bool permits(RegisterAccess access, std::size_t offset) const {
    return ((access == RegisterAccess::read ? readable_ : writable_) >> offset & 1U) != 0;
  }
  constexpr std::uint8_t& operator[](std::size_t offset) { return values_[offset]; }
  constexpr std::uint8_t operator[](std::size_t offset) const { return values_[offset]; }

 private:
  std::array<std::uint8_t, bank_bytes> values_{};
  std::uint64_t readable_ = 0;
  std::uint64_t writable_ = 0;
};

/// Default hooks for a device that only stores bytes. A device derives from this class and hides
/// the functions that differ; none is virtual.
struct NoRegisterHooks {
  /// Called before a byte is sent; `value` is the stored one, and may be changed. `bank` is BSEL,
  /// which has no meaning for addresses from 0x40 on; likewise below.
  constexpr void reading(std::uint8_t /*bank*/, std::uint8_t /*address*/, std::uint8_t& /*value*/) {
  }
  /// Called after a byte was written and stored.
  constexpr void written(std::uint8_t /*bank*/, std::uint8_t /*address*/, std::uint8_t /*value*/) {}
  /// Whether the next byte must wait; called once per frame, but not for the first byte of a write.
  constexpr bool busy() { return false; }
  constexpr bool accepts(ControlCommand, bool /*broadcast*/) { return false; }
  constexpr void execute(ControlCommand, bool /*broadcast*/) {}
};

template <class Hooks>
concept RegisterHooks = requires(Hooks hooks, std::uint8_t byte) {
  hooks.reading(byte, byte, byte);
  hooks.written(byte, byte, byte);
  { hooks.busy() } -> std::same_as<bool>;
  { hooks.accepts(ControlCommand::channels, true) } -> std::same_as<bool>;
  hooks.execute(ControlCommand::channels, true);
};

/// The number of frames by which S of a byte is delayed.
struct RegisterBusy {
  std::uint16_t read_frames = 0;   ///< each byte read
  std::uint16_t write_frames = 0;  ///< each byte after a written one
};

/// The registers of one slave. A device with several slaves has one for each (PerSlave).
///
/// BSEL (0x40) is built in: refused if there is only one bank, otherwise readable and writable. It
/// holds the value written. If no bank has this number, no register at 0x00 … 0x3F is available.
template <std::size_t Banks, RegisterHooks Hooks = NoRegisterHooks>
class BankedRegisters {
  static_assert(Banks >= 1 && Banks <= 256);

 public:
  constexpr explicit BankedRegisters(const Hooks& hooks = {}, const RegisterBusy& busy = {})
      : hooks_(hooks), busy_(busy) {}

  /// \pre number < Banks
  constexpr RegisterBank& bank(std::size_t number) { return banks_[number]; }
  /// Sets values and protection of registers outside the banks. \pre address 0x41 … 0x7F, here and
  /// below; values after the last register are ignored
  constexpr void put(unsigned address, std::span<const std::uint8_t> values,
                     RegisterProtection protection) {
    fixed_.put(address - reg::bsel, values, protection);
  }
  /// The same for a number of `Bytes` bytes, the highest at the lowest address.
  template <std::size_t Bytes>
  constexpr void put_number(unsigned address, std::uint64_t number, RegisterProtection protection) {
    fixed_.template put_number<Bytes>(address - reg::bsel, number, protection);
  }
  constexpr std::uint8_t& value(unsigned address) { return fixed_[address - reg::bsel]; }
  constexpr std::uint8_t bsel() const { return bsel_; }
  constexpr Hooks& hooks() { return hooks_; }
  constexpr void set_busy(const RegisterBusy& busy) { busy_ = busy; }

  constexpr bool permits(unsigned /*slave*/, RegisterAccess access, std::uint8_t address) {
    waited_ = 0;
    if (address == reg::bsel) return Banks > 1;
    if (address >= reg::bsel) return fixed_.permits(access, address - reg::bsel);
    return bsel_ < Banks && banks_[bsel_].permits(access, address);
  }

  constexpr std::optional<std::uint8_t> read(unsigned /*slave*/, std::uint8_t address) {
    if (must_wait(busy_.read_frames)) return std::nullopt;
    if (address == reg::bsel) return bsel_;
    std::uint8_t& value = at(address);
    hooks_.reading(bsel_, address, value);
    return value;
  }

  constexpr bool ready(unsigned /*slave*/) { return !must_wait(busy_.write_frames); }

  constexpr void write(unsigned /*slave*/, std::uint8_t address, std::uint8_t value) {
    if (address == reg::bsel) {
      bsel_ = value;
    } else {
      at(address) = value;
    }
    hooks_.written(bsel_, address, value);
  }

  constexpr bool accepts(unsigned /*slave*/, ControlCommand command, bool broadcast) {
    return hooks_.accepts(command, broadcast);
  }
  constexpr void execute(unsigned /*slave*/, ControlCommand command, bool broadcast) {
    hooks_.execute(command, broadcast);
  }

 private:
  constexpr bool must_wait(std::uint16_t frames) {
    if (waited_ < frames) {
      ++waited_;
      return true;
    }
    return hooks_.busy();
  }

  // \pre permitted
  constexpr std::uint8_t& at(std::uint8_t address) {
    if (address >= reg::bsel) return fixed_[address - reg::bsel];
    return banks_[bsel_][address];
  }

  [[no_unique_address]] Hooks hooks_;
  RegisterBusy busy_;
  std::array<RegisterBank, Banks> banks_{};
  RegisterBank fixed_;
  std::uint8_t bsel_ = 0;
  std::uint16_t waited_ = 0;  // frames, for the byte that is due
};

/// One owner for each slave of a device, slave 0 first.
template <RegisterOwner Owner, unsigned Count>
struct PerSlave {
  std::array<Owner, Count> owner;

  constexpr bool permits(unsigned slave, RegisterAccess access, std::uint8_t address) {
    return owner[slave].permits(slave, access, address);
  }
  constexpr std::optional<std::uint8_t> read(unsigned slave, std::uint8_t address) {
    return owner[slave].read(slave, address);
  }
  constexpr bool ready(unsigned slave) { return owner[slave].ready(slave); }
  constexpr void write(unsigned slave, std::uint8_t address, std::uint8_t value) {
    owner[slave].write(slave, address, value);
  }
  constexpr bool accepts(unsigned slave, ControlCommand command, bool broadcast) {
    return owner[slave].accepts(slave, command, broadcast);
  }
  constexpr void execute(unsigned slave, ControlCommand command, bool broadcast) {
    owner[slave].execute(slave, command, broadcast);
  }
};

}  // namespace biss
