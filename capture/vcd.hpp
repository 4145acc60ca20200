// Value change dumps (IEEE 1364), as simulators and logic analysers write them.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"
#include "capture/edge_writer.hpp"
#include "capture/pair_source.hpp"
#include "capture/timescale.hpp"

namespace biss::capture {

/// `1ns`, `10 us`, `100fs`, without white space; not known() for anything else.
Timescale parse_vcd_timescale(std::string_view text);

/// Opens a VCD: reads its declarations, then delivers the changes of every one-bit signal.
///
/// A VCD is read by words, not lines. Vectors of several bits, reals and strings are skipped.
/// 0 and 1 are levels, and so are the L and H of VHDL dumps; x, z, u, w and - are Level::unknown.
/// Values before the first time stand at time 0. A value that changes nothing gives no edge. Times
/// are rounded to the picosecond.
///
/// Fails with `empty`, `read_failed`, `malformed` (no VCD, a word the format does not allow, a
/// value for an identifier that was not declared), `token_too_long`, `too_many_lines`,
/// `time_backwards`, `time_out_of_range` (beyond 106 days) and `truncated`.
///
/// A missing line feed at the end is not a fault: the last word counts when it is complete as it
/// stands. `#4235750` may be the rest of `#42357500`; this is detected only if time would run
/// backwards (`truncated`). It does no harm, because no value follows.
///
/// \param piece_limit the most text of a piece of pairs()
Opened open_vcd(std::unique_ptr<ByteSource> bytes, std::size_t piece_limit = default_piece_bytes);

/// Writes a VCD with a time scale of 1 ps and a one-bit wire a line; only changes. White space and
/// control characters in names become `_`. Times before zero cannot be written.
class VcdWriter final : public EdgeWriter {
 public:
  VcdWriter(std::vector<std::string> lines, ByteSink& sink);

 private:
  void put(const wire::Edge& edge, bool new_time) override;
  void put_end(Picoseconds end_time, bool later) override;
  bool negative_times() const override { return false; }
  void put_time(Picoseconds time);

  std::vector<std::string> ids_;
};

}  // namespace biss::capture
