// EdsBank: the 64 bytes that an electronic data sheet is made of.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "biss/base/language.hpp"

namespace biss {

inline constexpr std::size_t eds_bank_bytes = 64;

/// One bank as it stands at the register addresses 0x00…0x3F while it is selected: byte 0 is the
/// one at 0x00. Numbers of several bytes have their highest byte first.
using EdsBank = std::array<std::uint8_t, eds_bank_bytes>;

/// Where the checksum stands (BP3 Rev A3, table 8; for the common part by analogy).
inline constexpr std::size_t eds_checksum_address = 0x3F;

/// What a bank's byte 0x3F should be: the sum of the bytes 0x00…0x3E, its lowest 8 bits.
constexpr std::uint8_t eds_checksum(const EdsBank& bank) {
  unsigned sum = 0;
  for (std::size_t i = 0; i < eds_checksum_address; ++i) sum += bank[i];
  return static_cast<std::uint8_t>(sum);
}

/// The bank with its checksum made right.
constexpr EdsBank sealed(EdsBank bank) {
  bank[eds_checksum_address] = eds_checksum(bank);
  return bank;
}

/// Whether every byte is this one: 0x00, whose checksum is even right, or 0xFF of erased memory.
constexpr bool is_filled_with(const EdsBank& bank, std::uint8_t byte) {
  for (const std::uint8_t each : bank) {
    if (each != byte) return false;
  }
  return true;
}

}  // namespace biss
