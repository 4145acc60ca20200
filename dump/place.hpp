// Within the room: puts bytes where they belong, and says why not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "dump/read.hpp"

namespace biss::dump {

/// A byte into an empty place, or one that holds it already.
inline std::optional<DumpCause> place(std::optional<std::uint8_t>& at, std::uint8_t byte) {
  if (at && *at != byte) return DumpCause::contradiction;
  at = byte;
  return std::nullopt;
}

/// A byte by its offset in a file that begins with `options.bank`. The registers 0x40…0x7F only
/// have a place in a file that begins with bank 0.
inline std::optional<DumpCause> place_at_offset(RegisterDump& dump, std::size_t offset,
                                                std::uint8_t byte, const DumpOptions& options) {
  const std::size_t skipped = options.bank.value_or(0) * bank_bytes;
  const std::size_t end = skipped == 0 ? image_bytes : direct_offset;
  if (offset >= end - skipped) return DumpCause::outside;
  return place(dump.at_offset(skipped + offset), byte);
}

}  // namespace biss::dump
