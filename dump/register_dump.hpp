// RegisterDump: the registers of one slave, as far as they are known.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "biss/control/register_map.hpp"
#include "biss/eds/bank.hpp"

namespace biss::dump {

/// 64 registers; those that are unknown, or that the device does not have, are empty.
using DumpedBytes = std::array<std::optional<std::uint8_t>, bank_bytes>;

/// Whether one of the registers is known.
inline bool any_known(std::span<const std::optional<std::uint8_t>> bytes) {
  return std::any_of(bytes.begin(), bytes.end(), [](const auto& byte) { return byte.has_value(); });
}

/// The registers 0x40…0x7F, which are in no bank.
inline constexpr unsigned first_direct = reg::bsel;
inline constexpr unsigned last_address = 0x7F;

/// The place of a byte in a file that has offsets only: bank b begins at 64 b; the registers
/// 0x40…0x7F follow the last of the 256 banks.
inline constexpr std::size_t direct_offset = bank_count * bank_bytes;
inline constexpr std::size_t image_bytes = direct_offset + bank_bytes;

class RegisterDump {
 public:
  /// \pre number < 256
  const DumpedBytes& bank(unsigned number) const { return banks_[number]; }
  /// Register 0x40 is the first.
  const DumpedBytes& direct() const { return banks_[bank_count]; }

  /// The register at `address` while bank `number` is selected.
  /// \pre number < 256, address <= 0x7F
  std::optional<std::uint8_t>& at(unsigned number, unsigned address) {
    return address < first_direct ? banks_[number][address]
                                  : banks_[bank_count][address - first_direct];
  }
  /// The same by its place in a file. \pre offset < image_bytes
  std::optional<std::uint8_t>& at_offset(std::size_t offset) {
    return banks_[offset / bank_bytes][offset % bank_bytes];
  }
  std::optional<std::uint8_t> at_offset(std::size_t offset) const {
    return banks_[offset / bank_bytes][offset % bank_bytes];
  }
  void set_bank(unsigned number, const EdsBank& bytes) {
    for (std::size_t i = 0; i < bank_bytes; ++i) banks_[number][i] = bytes[i];
  }

  /// One of the registers 0x40…0x7F. \pre address is one of them
  std::optional<std::uint8_t> direct_byte(unsigned address) const {
    return direct()[address - first_direct];
  }
  /// The number in `size` registers, most significant byte first; empty unless all are known.
  std::optional<std::uint64_t> direct_number(unsigned address, unsigned size) const;

  /// How many bytes of a bank are known.
  std::size_t known_bytes(unsigned number) const;
  /// A bank; empty unless every byte of it is known.
  std::optional<EdsBank> whole_bank(unsigned number) const;
  /// The first and the last bank with a known byte; empty without one.
  struct BankRange {
    unsigned first = 0;
    unsigned last = 0;
  };
  std::optional<BankRange> banks() const;

  /// The known registers are the same.
  bool operator==(const RegisterDump& other) const { return banks_ == other.banks_; }

  /// How many registers 0x00…0x3F were accessed while the bank was not known; they are in no bank.
  std::size_t without_bank = 0;

 private:
  std::array<DumpedBytes, bank_count + 1> banks_{};  // the last one: the registers 0x40…0x7F
};

}  // namespace biss::dump
