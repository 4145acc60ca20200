// The binary export of Saleae Logic 2: a file for each channel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "capture/analog.hpp"
#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"
#include "capture/edge_writer.hpp"
#include "capture/gather.hpp"

namespace biss::capture {

/// The beginning of a file of the binary export.
inline constexpr std::string_view saleae_magic = "<SALEAE>";
/// The magic, the version, and the type of the channel.
inline constexpr std::size_t saleae_header_bytes = 16;

/// Opens a channel of version 0 or 1, digital or analog; its one line is called `name`, or `digital`
/// or `analog` without a name.
///
/// Version 1 has chunks. If a chunk begins later than a sample period after the end of the chunk
/// before it, data was lost, and the level is unknown in between. A change before the begin of its
/// chunk is `time_backwards`; one after its end extends it. Analog waveforms of version 1 follow one
/// another in time; no edge is interpolated between two of them.
///
/// Fails with `unknown_format` (another version), `malformed` (a level that is neither 0 nor 1, an
/// impossible time, rate or count, bytes after the last chunk), `empty` (no chunk or waveform),
/// `time_backwards`, `time_out_of_range`, `truncated`, as `bytes` fail, and as open_analog().
/// Source: Saleae, "Binary Export Format - Version 0" and "Binary and CSV Export Formats - 2025
/// Update".
Opened open_saleae_binary(std::unique_ptr<ByteSource> bytes, std::string name,
                          const AnalogOptions& options = {});

/// Writes a digital channel of version 0. If the level is unknown for a time, it writes version 1,
/// with a chunk for each time in which the level is known. Unknown times before the first level or
/// after the last one cannot be written. Times are doubles, see seconds_of(). Changes are kept
/// until the end, in a temporary file if there are many. With more than one line every call fails
/// with `too_many_lines`.
class SaleaeBinaryWriter final : public EdgeWriter {
 public:
  /// `rate` is the rate of the samples in version 1; 0 Hz if it is not known.
  SaleaeBinaryWriter(std::vector<std::string> lines, Hertz rate, ByteSink& sink);

 private:
  void put(const wire::Edge& edge, bool new_time) override;
  void put_end(Picoseconds end_time, bool later) override;
  bool negative_times() const override { return true; }
  void end_chunk(Picoseconds end);
  void put_changes(std::uint64_t changes);

  Hertz rate_;
  Spool changes_;
  Spool chunks_;  // their headers
  std::uint64_t chunk_count_ = 0;
  wire::Level level_ = wire::Level::unknown;
  wire::Level first_level_ = wire::Level::unknown;
  Picoseconds begin_;
  Picoseconds last_;
  std::uint64_t changes_in_chunk_ = 0;
};

}  // namespace biss::capture
