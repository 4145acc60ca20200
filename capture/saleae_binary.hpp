// The binary export of Saleae Logic 2: a file for each channel.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"

namespace biss::capture {

/// What a file of the binary export begins with.
inline constexpr std::string_view saleae_magic = "<SALEAE>";

/// Opens a digital channel of version 0 or 1; its one line is called `name`.
///
/// Version 1 has chunks. Where one begins later than a sample period after the end of the one before
/// it, data was lost, and the level is unknown in between. A change before the begin of its chunk is
/// `time_backwards`; one after its end extends it.
///
/// Fails with `unknown_format` (another version, an analog channel), `malformed` (a level that is
/// neither 0 nor 1, a time or rate that is no number, bytes after the last chunk), `empty` (no
/// chunk), `time_backwards`, `time_out_of_range`, `truncated`, and as `bytes` fail.
/// Source: Saleae, "Binary Export Format - Version 0" and "Binary and CSV Export Formats - 2025
/// Update".
Opened open_saleae_binary(std::unique_ptr<ByteSource> bytes, std::string name);

}  // namespace biss::capture
