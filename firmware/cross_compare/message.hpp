// The message between two processors that judge the same encoder: the finding of one evaluation,
// with its address and a checksum over both. 34 bytes, most significant byte first.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "biss/crc/engines.hpp"
#include "biss/safety/verdict.hpp"

namespace cross_compare {

/// request (4 bytes), connection, sender (2 each), CPW and SPW position (8 each), difference (4),
/// counter, nW (1 each), cause (2), checksum (2).
using Message = std::array<std::uint8_t, 34>;

/// The processor with FieldEvaluation and the processor with LineEvaluation. All 16 bits differ.
enum class Sender : std::uint16_t { field = 0x3A59, line = 0xC5A6 };

/// The connection and the request of a message. A receiver ignores a message with any other
/// address.
struct Address {
  /// Number of the request.
  std::uint32_t request = 0;
  /// Number of the pair of processors.
  std::uint16_t connection = 0;
  Sender sender{};
};

namespace detail {

constexpr void put(Message& message, std::size_t at, std::uint64_t value, std::size_t bytes) {
  for (std::size_t k = 0; k < bytes; ++k) {
    message[at + k] = static_cast<std::uint8_t>(value >> (8U * (bytes - 1U - k)));
  }
}
constexpr std::uint64_t get(const Message& message, std::size_t at, std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t k = 0; k < bytes; ++k) value = (value << 8U) | message[at + k];
  return value;
}

// The CRC of CCITT: it detects any three wrong bits of a message (0x190D9 does not detect two that
// are 151 bits apart). The CRC of a word of eight bytes is the start value of the next one.
constexpr std::uint16_t checksum(const Message& message) {
  biss::CrcSpec spec{.polynomial = 0x11021, .start = 0xFFFF, .width_bits = 16, .inverted = false};
  for (std::size_t at = 0; at < 32; at += 8) {
    spec.start = biss::CrcBitwise(spec)(get(message, at, 8), 64);
  }
  return spec.start;
}

}  // namespace detail

constexpr Message encode(const Address& address, const biss::SafetyFinding& finding) {
  Message message{};
  detail::put(message, 0, address.request, 4);
  detail::put(message, 4, address.connection, 2);
  detail::put(message, 6, static_cast<std::uint16_t>(address.sender), 2);
  detail::put(message, 8, finding.cpw_position, 8);
  detail::put(message, 16, finding.spw_position, 8);
  detail::put(message, 24, static_cast<std::uint32_t>(finding.difference_lsb), 4);
  detail::put(message, 28, finding.life_counter, 1);
  detail::put(message, 29, finding.nW, 1);
  detail::put(message, 30, static_cast<std::uint16_t>(finding.cause), 2);
  detail::put(message, 32, detail::checksum(message), 2);
  return message;
}

/// \return empty if the message is damaged, or has another address
constexpr std::optional<biss::SafetyFinding> decode(const Address& expected,
                                                    const Message& message) {
  if (detail::get(message, 32, 2) != detail::checksum(message)) return std::nullopt;
  if (detail::get(message, 0, 4) != expected.request) return std::nullopt;
  if (detail::get(message, 4, 2) != expected.connection) return std::nullopt;
  if (static_cast<Sender>(detail::get(message, 6, 2)) != expected.sender) return std::nullopt;
  return biss::SafetyFinding{
      .cpw_position = detail::get(message, 8, 8),
      .spw_position = detail::get(message, 16, 8),
      .difference_lsb = static_cast<std::int32_t>(detail::get(message, 24, 4)),
      .life_counter = static_cast<std::uint8_t>(detail::get(message, 28, 1)),
      .nW = static_cast<std::uint8_t>(detail::get(message, 29, 1)),
      .cause = static_cast<biss::SafetyVerdict>(detail::get(message, 30, 2))};
}

}  // namespace cross_compare
