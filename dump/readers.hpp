// Within the room: the readers of the formats. They throw a DumpError with a cause of the format.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "dump/read.hpp"

namespace biss::dump {

/// Any format but banks.
RegisterDump read_text(DumpFormat format, LineSource& lines, const DumpOptions& options);
/// Banks of 64 bytes one after the other, whatever their bytes look like.
RegisterDump read_binary(std::istream& stream, std::string head, const DumpOptions& options);

/// A byte by its offset in a file that begins with `options.bank`; null if no register is there.
/// Only a file that begins with bank 0 has a place for the registers 0x40…0x7F.
inline std::optional<std::uint8_t>* byte_at_offset(RegisterDump& dump, std::size_t offset,
                                                   const DumpOptions& options) {
  const std::size_t skipped = options.bank.value_or(0) * bank_bytes;
  const std::size_t end = skipped == 0 ? image_bytes : direct_offset;
  return offset < end - skipped ? &dump.at_offset(skipped + offset) : nullptr;
}

}  // namespace biss::dump
