// Event CSV: a row a change, `time_ns,MA,SLO`.
#pragma once

#include <memory>

#include "capture/byte_source.hpp"
#include "capture/edge_source.hpp"

namespace biss::capture {

/// Opens an event CSV: reads its header, then delivers what each row changes.
///
/// The header is `time` with its unit and a name a line; see event_csv_header.hpp. A row holds a
/// time and the levels from then on: 0, 1, x or z (both Level::unknown), or nothing where a level
/// stays as it is. Times are decimal numbers, with an exponent if need be, rounded exactly to the
/// picosecond; they may be negative and never fall. A byte order mark, CRLF, blanks around cells,
/// blank rows and rows that begin with `#` are no matter.
///
/// Fails with `empty`, `read_failed`, `malformed` (header, number, level, count of columns),
/// `token_too_long` (a row of more than 64 KiB), `time_backwards`, `time_out_of_range` and
/// `truncated`. A row counts whole or not at all. A missing line feed at the end is no fault, but a
/// last row without one is `truncated` when columns are missing or its last cell is empty.
Opened open_event_csv(std::unique_ptr<ByteSource> bytes);

}  // namespace biss::capture
