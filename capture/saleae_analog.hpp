// Analog binary export of Saleae Logic 2: one channel a file.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "capture/analog.hpp"
#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"

namespace biss::capture {

/// Whether a file that begins in this way is an analog binary export, of any version.
bool looks_like_saleae_analog(std::string_view head);

/// Opens an analog binary export of version 0 or 1. Its line is called `name`. Waveforms of
/// version 1 follow one another in time; no edge is interpolated between two of them.
///
/// Fails with `unknown_format` (another version), `malformed` (an impossible rate, count or time),
/// `truncated`, `time_backwards`, `time_out_of_range`, `empty`, `read_failed`, and as
/// open_analog().
Opened open_saleae_analog(std::unique_ptr<ByteSource> bytes, std::string name,
                          const AnalogOptions& options);

}  // namespace biss::capture
