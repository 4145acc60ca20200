// sigrok sessions (`.sr`), as sigrok-cli and PulseView save them.
#pragma once

#include <memory>
#include <string_view>

#include "capture/byte_source.hpp"
#include "capture/edge_source.hpp"

namespace biss::capture {

/// Whether a file that begins so may be a session: every ZIP archive does.
bool looks_like_zip(std::string_view head);

/// Opens a sigrok session of version 1 or 2 and delivers the changes of its logic probes.
///
/// The samples are one member or numbered chunks, which need not hold whole samples. One chunk at a
/// time is inflated, or a part of one that has more than 32 MiB, so that memory does not grow with
/// the capture. Checksums are verified. Analog members are passed over.
///
/// Fails with `read_failed`, `unknown_format` (another kind of archive), `damaged` (no directory,
/// members that overlap, data that does not inflate to the size and checksum the directory has, a
/// chunk that is missing between others), `malformed` (metadata), `empty`, `truncated` (the last
/// sample is not whole) and `time_out_of_range`.
Opened open_sr(std::unique_ptr<ByteSource> bytes);

}  // namespace biss::capture
