// Opens a capture of any known format, and describes errors in words.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "capture/analog.hpp"
#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"
#include "capture/pair_source.hpp"
#include "capture/samples.hpp"

namespace biss::capture {

/// Settings that the capture itself does not contain.
struct OpenOptions {
  /// Raw samples: a file `.bin` or `.raw` with any content, but not the binary export of Saleae
  /// Logic; and any file that is known neither by its content nor by its extension.
  std::optional<RawLayout> raw = {};
  /// Do not verify the checksums of compressed samples.
  bool no_verify = false;
  /// Bytes of a piece of EdgeSource::pairs() if the file itself is not divided.
  std::size_t piece_bytes = default_piece_bytes;
  /// How voltages become levels.
  AnalogOptions analog = {};
};

/// Opens the capture at `path`; `-` is standard input. The content selects the format; if it does
/// not, the extension does (`.vcd`, `.csv`, `.sr`, `.dsl`). A file that is compressed by gzip or
/// zstd, up to three times, is decompressed as it is read. A line without a name gets the name of
/// the file, without folder and extension. Fails with every CaptureCause.
Opened open_capture(const std::string& path, const OpenOptions& options = {});

/// The same for bytes from elsewhere; only the name in `path` matters.
Opened open_capture(std::unique_ptr<ByteSource> bytes, std::string_view path,
                    const OpenOptions& options = {});

/// The enumerator, as scripts see it.
std::string_view name_of(CaptureCause cause);

/// The error as one line without a line feed: the cause, the place in the file, and the remedy.
std::string capture_error_text(const CaptureError& error, std::string_view path);

}  // namespace biss::capture
