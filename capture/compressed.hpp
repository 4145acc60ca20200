// Captures compressed by gzip or zstd: their bytes as they were before.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "capture/bytes.hpp"

namespace biss::capture {

enum class Compression : std::uint8_t { none, gzip, zstd };

/// The compression of bytes that begin in this way. Four bytes are enough.
Compression compression_of(std::string_view head);

/// The path without the extension of a compressed file: `a.vcd` of `a.vcd.gz`.
std::string_view without_compression(std::string_view path);

/// The content of the compressed `bytes`.
///
/// Members or frames that follow each other are one text, as for gzip and zstd themselves. Bytes are
/// decompressed as they are read, so memory does not depend on their number: 64 KiB and the window,
/// 32 KiB for gzip and at most 128 MiB for zstd. Checksums are verified.
///
/// Everything before a fault is delivered first. Then every read fails with `truncated` (the
/// compressed data ends in the middle), `damaged` (its format does not allow it, or has the wrong
/// checksum), or with the cause of `bytes`.
/// \pre compression is not none
std::unique_ptr<ByteSource> decompressed(std::unique_ptr<ByteSource> bytes,
                                         Compression compression);

}  // namespace biss::capture
