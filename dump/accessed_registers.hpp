// The registers of one slave as the accesses to them show them.
//
//   AccessedRegisters registers;
//   registers.take(Access::written, reg::bsel, 2);
//   registers.take(Access::read, 0x00, 1);  // register 0x00 of bank 2
#pragma once

#include <cstdint>
#include <optional>

#include "dump/register_dump.hpp"

namespace biss::dump {

enum class Access : std::uint8_t { read, written };

/// Takes the accesses in order; if two are to one register, the last one counts. Its size is 33 KiB
/// for any accesses.
class AccessedRegisters {
 public:
  /// \param bank the bank that is selected before the first access. Empty: not known, because
  ///   accesses may be seen from any time on, and our sources do not give the value of BSEL at
  ///   power-up.
  explicit AccessedRegisters(std::optional<std::uint8_t> bank = std::nullopt) : bank_(bank) {}

  /// A byte that a read returned, or that a write set. The registers 0x00…0x3F are in the bank that
  /// BSEL selects. If the bank is not known yet, a read of BSEL shows it, as long as no write
  /// precedes the read. \pre address <= 0x7F
  void take(Access access, unsigned address, std::uint8_t byte);
  /// A write failed, and the slave may have taken the byte. After such a write to BSEL the bank is
  /// not known.
  void take_uncertain_write(unsigned address);

  /// The last state; registers 0x00…0x3F of an unknown bank count as RegisterDump::without_bank.
  const RegisterDump& dump() const { return dump_; }

 private:
  void found_bank(std::uint8_t bank);

  RegisterDump dump_;
  std::optional<std::uint8_t> bank_;
  DumpedBytes waiting_{};  // accessed in the bank that is not known yet
};

}  // namespace biss::dump
