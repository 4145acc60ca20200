// A slave's registers as seen in the control communication, and the faults of the data sheet in
// them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "biss/control/register_map.hpp"
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
  void take(const SeenAccess& access) {
    if (!access.header_sent || access.kind == SeenAccess::Kind::command) return;
    const AccessOutcome outcome = access.outcome;
    if (outcome == AccessOutcome::ok && access.data) {
      const bool reads = access.kind == SeenAccess::Kind::read;
      registers_.take(reads ? dump::Access::read : dump::Access::written, access.address,
                      *access.data);
      return;
    }
    const bool not_taken = outcome == AccessOutcome::no_answer ||
                           outcome == AccessOutcome::no_such_slave ||
                           outcome == AccessOutcome::refused_or_not_addressed;
    if (access.kind != SeenAccess::Kind::read && !not_taken) {
      registers_.take_uncertain_write(access.address);
    }
  }

  const dump::RegisterDump& registers() const { return registers_.dump(); }
  /// Registers 0x42 (upper byte) and 0x43.
  std::optional<std::uint16_t> identifier() const {
    const auto number = registers().direct_number(reg::bp_id, 2);
    if (!number) return std::nullopt;
    return static_cast<std::uint16_t>(*number);
  }

  struct EdsJudgement {
    std::uint64_t findings = 0;
    EdsFinding first{};
  };
  /// The judgement on the banks of the data sheet that were seen whole; empty if its common part
  /// was not.
  std::optional<EdsJudgement> judge_eds() const {
    const auto number = registers().direct_byte(reg::eds_bank);
    if (!number || *number == 0) return std::nullopt;
    const auto common = registers().whole_bank(*number);
    if (!common) return std::nullopt;
    const CommonPart part = parse_common_part(*common);
    std::array<std::optional<EdsBank>, max_channels> profiles;
    EdsImage image;
    image.common = &*common;
    image.eds_bank = number;
    for (std::size_t i = 0; i < std::min<std::size_t>(part.dc_num, max_channels); ++i) {
      if (part.channels[i].bank == *number) continue;
      profiles[i] = registers().whole_bank(part.channels[i].bank);
      if (profiles[i]) image.profiles[i] = &*profiles[i];
    }
    const auto stated = identifier();
    if (stated && *stated != 0)
      image.identifiers[part.sl_off < max_channels ? part.sl_off : 0] = stated;
    EdsJudgement judged;
    check_eds(image, [&](const EdsFinding& found) {
      if (judged.findings++ == 0) judged.first = found;
    });
    return judged;
  }

 private:
  dump::AccessedRegisters registers_;
};

}  // namespace biss::decode
