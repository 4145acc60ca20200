// Within the room: the reader of each text format. Each fails with the causes of its format.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "dump/read.hpp"

namespace biss::dump {

DumpResult read_hex_page(LineSource& lines, const DumpOptions& options);
DumpResult read_hex_offsets(LineSource& lines, const DumpOptions& options);
DumpResult read_intel_hex(LineSource& lines, const DumpOptions& options);
DumpResult read_json_lines(LineSource& lines, const DumpOptions& options);

/// Sets a byte that is empty or has this value already.
inline std::optional<DumpCause> set_byte(std::optional<std::uint8_t>& at, std::uint8_t byte) {
  if (at && *at != byte) return DumpCause::contradiction;
  at = byte;
  return std::nullopt;
}

/// Sets a byte by its offset in a file that begins with `options.bank`. Only a file that begins
/// with bank 0 has a place for the registers 0x40…0x7F.
inline std::optional<DumpCause> set_byte_at_offset(RegisterDump& dump, std::size_t offset,
                                                   std::uint8_t byte, const DumpOptions& options) {
  const std::size_t skipped = options.bank.value_or(0) * bank_bytes;
  const std::size_t end = skipped == 0 ? image_bytes : direct_offset;
  if (offset >= end - skipped) return DumpCause::outside;
  return set_byte(dump.at_offset(skipped + offset), byte);
}

}  // namespace biss::dump
