// Files to a RegisterDump: five formats, told apart by their content. docs/eds.md describes them.
//
//   const auto dump = biss::dump::read_dump_file("registers.hex", {});
//   if (!dump.ok()) … biss::dump::dump_error_text(dump.error()) …
#pragma once

#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <string_view>

#include "biss/base/result.hpp"
#include "dump/dump_error.hpp"
#include "dump/line_source.hpp"
#include "dump/register_dump.hpp"

namespace biss::dump {

enum class DumpFormat : std::uint8_t {
  binary,       ///< banks of 64 bytes, one behind the other
  hex_page,     ///< `0x40: 00 02 62 1E …` by register address
  hex_offsets,  ///< as xxd and hexdump -C print a binary
  intel_hex,    ///< records by offset
  json_lines,   ///< accesses, as `biss registers --to jsonl` prints them
};

struct DumpOptions {
  /// The bank that a file begins with (binary, offsets, Intel HEX), or that its registers 0x00…0x3F
  /// belong to where the file does not say. Empty: 0, or what BSEL in the same file says.
  std::optional<std::uint8_t> bank{};
  /// Of accesses to several slaves, take those to this ID.
  std::optional<std::uint8_t> slave{};
};

using DumpResult = Result<RegisterDump, DumpError>;

/// Enough of a file to tell its format.
inline constexpr std::size_t head_bytes = 4'096;

/// The first bytes of a stream, at most head_bytes.
std::string read_head(std::istream& stream);

/// Which format this is the beginning of; text that has no shape of ours is none, anything else
/// binary.
std::optional<DumpFormat> recognise(std::string_view head);

/// The rest of the stream after `head`. Memory is bounded, however long the stream. Fails with any
/// DumpCause but cannot_open and is_directory.
DumpResult read_dump(std::istream& stream, std::string head, const DumpOptions& options);

/// A file, `-` for standard input.
DumpResult read_dump_file(const std::string& path, const DumpOptions& options);

/// The readers. Each fails with the causes of its format; a byte that two places give differently
/// is a `contradiction`, except in accesses, where the last one counts.
DumpResult read_binary(std::istream& stream, std::string head, const DumpOptions& options);
DumpResult read_hex_page(LineSource& lines, const DumpOptions& options);
DumpResult read_hex_offsets(LineSource& lines, const DumpOptions& options);
DumpResult read_intel_hex(LineSource& lines, const DumpOptions& options);
DumpResult read_json_lines(LineSource& lines, const DumpOptions& options);

}  // namespace biss::dump
