// A control frame's header as it was heard: what a slave, a listener and a test bench make of the
// 15 bits behind the start bit.
#pragma once

#include <cstdint>
#include <optional>

#include "biss/control/control_frame.hpp"

namespace biss {

/// What a header asks for.
struct ControlHeader {
  /// CTS = 1. False: a command.
  bool register_access = false;
  /// Register access: ID and address.
  std::uint8_t slave = 0;
  std::uint8_t address = 0;
  /// Command: bit k stands for the slave with ID k (IDS0 came first on the line); 0: broadcast.
  std::uint8_t slaves = 0;
  ControlCommand command = ControlCommand::channels;

  constexpr bool broadcast() const { return !register_access && slaves == 0; }
  /// Whether the slave with this ID is meant, by its ID or by a broadcast.
  constexpr bool addresses(unsigned id) const {
    if (register_access) return slave == id;
    return slaves == 0 || (slaves >> id & 1U) != 0;
  }
  constexpr bool operator==(const ControlHeader&) const = default;
};

/// Bits of a header behind the start bit: CTS, ten of addressing, four of CRC.
inline constexpr unsigned control_header_bits = control_bit::header_end - control_bit::cts;

/// \param bits the 15 bits in line order, CTS topmost (bit 14), CRC0 lowest; what is above is not
/// looked at
/// \return nothing when the CRC is wrong: a slave then behaves as not addressed
constexpr std::optional<ControlHeader> parse_header(std::uint32_t bits) {
  const auto covered = static_cast<std::uint16_t>(bits >> 4U & 0x7FFU);
  if (header_crc(covered) != (bits & 0xFU)) return std::nullopt;
  ControlHeader header{.register_access = (covered >> 10U) != 0};
  if (header.register_access) {
    header.slave = static_cast<std::uint8_t>(covered >> 7U & 7U);
    header.address = static_cast<std::uint8_t>(covered & 0x7FU);
    return header;
  }
  header.command = static_cast<ControlCommand>(covered & 3U);
  for (unsigned k = 0; k < control_max_slaves; ++k) {
    if ((covered >> (9U - k) & 1U) != 0) header.slaves |= static_cast<std::uint8_t>(1U << k);
  }
  return header;
}

}  // namespace biss
