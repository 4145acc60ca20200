// What the control communication shows of a slave's registers, and what is wrong with the data
// sheet in them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "biss/control/register_map.hpp"
#include "biss/eds/bank.hpp"
#include "biss/eds/check.hpp"
#include "decode/control_listener.hpp"

namespace biss::decode {

/// The registers of one slave; 33 KiB, whatever is read.
class SeenRegisters {
 public:
  /// An access to this slave. BSEL is 0 at power-up; a write to it of which the outcome is not
  /// certain leaves the bank unknown until the next one.
  void take(const SeenAccess& access);

  /// One of the registers 0x40 … 0x7F. \pre 0x40 <= address <= 0x7F
  std::optional<std::uint8_t> direct(unsigned address) const {
    return bytes_[direct_begin + address - reg::bsel];
  }
  /// Registers 0x42 (upper byte) and 0x43.
  std::optional<std::uint16_t> identifier() const;
  /// A bank of which every byte was seen. \pre number < 256
  std::optional<EdsBank> bank(unsigned number) const;

  struct EdsJudgement {
    std::uint64_t findings = 0;
    EdsFinding first{};
  };
  /// The banks of the data sheet that were seen whole; nothing where its common part was not.
  std::optional<EdsJudgement> judge_eds() const;

 private:
  static constexpr std::size_t direct_begin = bank_count * bank_bytes;

  std::array<std::optional<std::uint8_t>, direct_begin + bank_bytes> bytes_{};
  std::optional<std::uint8_t> selected_ = 0;
};

}  // namespace biss::decode
