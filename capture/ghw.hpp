// GHDL's own waveforms (`.ghw`), written with `--wave`.
#pragma once

#include <memory>
#include <string_view>

#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"

namespace biss::capture {

bool looks_like_ghw(std::string_view head);

/// Opens a GHW of version 0 or 1, of either byte order, and delivers the changes of every signal
/// whose type is an enumeration with the values '0' and '1', or false and true: std_ulogic,
/// std_logic, bit, boolean.
///
/// Elements of arrays and records of up to 64 values are lines too: `pins(3)`, `bus.clk`. Larger
/// ones (memories), numbers and other enumerations are skipped. 1, H and true are high; 0, L and
/// false are low; every other value is Level::unknown. Times are femtoseconds, rounded to the
/// picosecond, halves up.
///
/// Fails with `read_failed`, `malformed`, `too_many_lines`, `time_backwards`, `time_out_of_range`
/// and `truncated` (no end mark: GHDL was stopped).
Opened open_ghw(std::unique_ptr<ByteSource> bytes);

}  // namespace biss::capture
