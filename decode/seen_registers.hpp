// A slave's registers as seen in the control communication, and the faults of the data sheet in
// them.
#pragma once

#include <cstdint>
#include <optional>

#include "biss/eds/check.hpp"
#include "decode/control_listener.hpp"
#include "dump/accessed_registers.hpp"

namespace biss::decode {

/// The registers of one slave.
class SeenRegisters {
 public:
  /// \param bank the bank that is selected at the beginning of the capture; empty: not known
  explicit SeenRegisters(std::optional<std::uint8_t> bank = std::nullopt) : registers_(bank) {}

  /// An access to this slave.
  void take(const SeenAccess& access);

  const dump::RegisterDump& registers() const { return registers_.dump(); }
  /// Registers 0x42 (upper byte) and 0x43.
  std::optional<std::uint16_t> identifier() const;

  struct EdsJudgement {
    std::uint64_t findings = 0;
    EdsFinding first{};
  };
  /// The judgement on the banks of the data sheet that were seen whole; empty if its common part
  /// was not.
  std::optional<EdsJudgement> judge_eds() const;

 private:
  dump::AccessedRegisters registers_;
};

}  // namespace biss::decode
