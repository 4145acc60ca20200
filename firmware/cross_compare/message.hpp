// The message between two processors that judge the same encoder: the finding of one evaluation,
// with the number of the request and a checksum. 32 bytes, most significant byte first.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "biss/crc/engines.hpp"
#include "biss/safety/verdict.hpp"

namespace cross_compare {

/// request (4 bytes), CPW and SPW position (8 each), difference (4), counter, nW (1 each), cause
/// (2), spare (2), checksum (2).
using Message = std::array<std::uint8_t, 32>;

namespace detail {

// 0x190D9 over the words of eight bytes: the CRC of a word is the start value of the next one.
constexpr std::uint16_t checksum(const Message& message) {
  biss::CrcSpec spec{.polynomial = 0x190D9, .start = 0xFFFF, .width_bits = 16, .inverted = false};
  for (std::size_t at = 0; at + 2U < message.size(); at += 8U) {
    const std::size_t bytes = at + 8U < message.size() ? 8U : 6U;
    std::uint64_t word = 0;
    for (std::size_t k = 0; k < bytes; ++k) word = (word << 8U) | message[at + k];
    spec.start = biss::CrcBitwise(spec)(word, static_cast<unsigned>(8U * bytes));
  }
  return spec.start;
}

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

}  // namespace detail

constexpr Message encode(std::uint32_t request, const biss::SafetyFinding& finding) {
  Message message{};
  detail::put(message, 0, request, 4);
  detail::put(message, 4, finding.cpw_position, 8);
  detail::put(message, 12, finding.spw_position, 8);
  detail::put(message, 20, static_cast<std::uint32_t>(finding.difference_lsb), 4);
  detail::put(message, 24, finding.life_counter, 1);
  detail::put(message, 25, finding.nW, 1);
  detail::put(message, 26, static_cast<std::uint16_t>(finding.cause), 2);
  detail::put(message, 30, detail::checksum(message), 2);
  return message;
}

/// \return none where the message is damaged, or is that of another request
constexpr std::optional<biss::SafetyFinding> decode(std::uint32_t request, const Message& message) {
  if (detail::get(message, 30, 2) != detail::checksum(message)) return std::nullopt;
  if (detail::get(message, 0, 4) != request) return std::nullopt;
  return biss::SafetyFinding{
      .cpw_position = detail::get(message, 4, 8),
      .spw_position = detail::get(message, 12, 8),
      .difference_lsb = static_cast<std::int32_t>(detail::get(message, 20, 4)),
      .life_counter = static_cast<std::uint8_t>(detail::get(message, 24, 1)),
      .nW = static_cast<std::uint8_t>(detail::get(message, 25, 1)),
      .cause = static_cast<biss::SafetyVerdict>(detail::get(message, 26, 2))};
}

}  // namespace cross_compare
