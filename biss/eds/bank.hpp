// EdsBank: the 64 bytes of which electronic data sheets consist.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "biss/base/language.hpp"

namespace biss {

inline constexpr std::size_t eds_bank_bytes = 64;

/// One bank as at the register addresses 0x00…0x3F while it is selected: byte 0 is at 0x00. Numbers
/// of several bytes are big-endian.
using EdsBank = std::array<std::uint8_t, eds_bank_bytes>;

/// The address of the checksum (BP3 Rev A3, table 8; for the common part by analogy).
inline constexpr std::size_t eds_checksum_address = 0x3F;

/// The checksum of a bank: the lowest 8 bits of the sum of the bytes 0x00…0x3E.
constexpr std::uint8_t eds_checksum(const EdsBank& bank) {
  unsigned sum = 0;
  for (std::size_t i = 0; i < eds_checksum_address; ++i) sum += bank[i];
  return static_cast<std::uint8_t>(sum);
}

/// The bank with the right checksum.
constexpr EdsBank sealed(EdsBank bank) {
  bank[eds_checksum_address] = eds_checksum(bank);
  return bank;
}

/// Whether every byte has this value: 0x00, for which even the checksum is right, or 0xFF of erased
/// memory.
constexpr bool is_filled_with(const EdsBank& bank, std::uint8_t byte) {
  for (const std::uint8_t each : bank) {
    if (each != byte) return false;
  }
  return true;
}

namespace eds_detail {

// 0 and 0xFF: not filled in.
constexpr bool is_given(std::uint8_t byte) { return byte != 0x00 && byte != 0xFF; }

}  // namespace eds_detail

}  // namespace biss
