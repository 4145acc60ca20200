// Fast signal traces (`.fst`), as GTKWave, Verilator, Icarus Verilog and GHDL write them.
#pragma once

#include <memory>
#include <string_view>

#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"

namespace biss::capture {

/// Whether a file that begins in this way is an FST, plain or wrapped in gzip. 33 bytes are enough.
bool looks_like_fst(std::string_view head);

/// Opens an FST and delivers the changes of every one-bit signal, with the names and levels of the
/// same dump as VCD.
///
/// Vectors of several bits, integers, reals, strings and events are skipped. An FST keeps no order
/// among the changes with the same time: they come in the order of their declaration. While dumping
/// was off all levels are unknown.
///
/// The names of signals are at the end of the file, so the file is read at any place: anything but
/// a regular file is copied, see gather(). The chains of changes of one block, of the one-bit
/// signals only, are in memory while the block is read.
///
/// Fails with `read_failed`, `truncated` (no names: the simulator has not finished the file),
/// `malformed`, `damaged` (data that does not unpack to its size, places outside a block),
/// `too_many_lines`, `block_too_large` (more than 256 MiB), `time_backwards` and
/// `time_out_of_range`.
Opened open_fst(std::unique_ptr<ByteSource> bytes);

}  // namespace biss::capture
