// Files to a RegisterDump. The content shows which format a file has; docs/eds.md describes them.
//
//   const auto dump = biss::dump::read_dump(stream, biss::dump::read_head(stream), {});
//   if (!dump) … biss::dump::dump_error_text(dump.error()) …
#pragma once

#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "dump/register_dump.hpp"
#include "dump/text.hpp"

namespace biss::dump {

struct DumpOptions {
  /// The bank that a file begins with (binary, offsets, Intel HEX), or the bank of its registers
  /// 0x00…0x3F if the file does not give it. Empty: 0, or the value of BSEL in the same file. For
  /// accesses: the bank before the first one; empty: not known, see AccessedRegisters.
  std::optional<std::uint8_t> bank{};
  /// With accesses to several slaves: reads only those to this ID.
  std::optional<std::uint8_t> slave{};
};

/// A byte with different values at two places is a `contradiction`, except in accesses: there the
/// last value counts.
using DumpResult = tl::expected<RegisterDump, DumpError>;

/// The part of a file that shows its format.
inline constexpr std::size_t head_bytes = 4'096;

/// The first bytes of a stream, at most head_bytes.
std::string read_head(std::istream& stream);

/// The format of a file with this head. Empty for text in none of the formats; all other content is
/// binary.
std::optional<DumpFormat> recognise(std::string_view head);

/// Reads the rest of the stream after `head`, in bounded memory. Fails with any DumpCause.
DumpResult read_dump(std::istream& stream, std::string head, const DumpOptions& options);

}  // namespace biss::dump
