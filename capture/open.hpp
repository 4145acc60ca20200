// Opens a capture of any known format, and says in words what went wrong.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "capture/byte_source.hpp"
#include "capture/edge_source.hpp"

namespace biss::capture {

/// Opens the capture at `path`; `-` is standard input. The content decides what it is, the
/// extension (`.vcd`, `.csv`) where the content does not say. Fails with every CaptureCause.
Opened open_capture(const std::string& path);

/// The same for bytes from elsewhere; of `path` only the extension counts.
Opened open_capture(std::unique_ptr<ByteSource> bytes, std::string_view path);

/// The error as one line without a line feed: what, where in the file, what to do.
std::string capture_error_text(const CaptureError& error, std::string_view path);

}  // namespace biss::capture
