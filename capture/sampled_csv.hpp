// CSV of samples: oscilloscopes, sigrok, DSView, and the analog export of Saleae Logic 2.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "capture/analog.hpp"
#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"
#include "capture/event_csv.hpp"

namespace biss::capture {

/// The result for the beginning of a file; `not_yet` if more of the file is needed.
enum class Likeness : std::uint8_t { no, yes, not_yet };

/// Whether a file that begins in this way is a CSV of samples. A header of event CSV is one too
/// when its first rows hold voltages: more than two numbers in half of the rows or more, or two
/// other numbers than 0 and 1 at a constant step, with rows that repeat the row before. Once it is
/// given, the answer does not change when more of the file is seen.
/// \param whole `head` is the complete file
Likeness looks_like_sampled_csv(std::string_view head, bool whole);

/// The meaning of the rows of an event CSV that begins in this way. \pre looks_like_sampled_csv()
/// gives `no`
EventCsvRows event_csv_rows(std::string_view head);

/// A row that sigrok-cli writes among the samples: `A0: 3.0902 V DC`.
bool is_sigrok_remark(std::string_view row);

/// A column of the file that is a channel.
struct CsvChannel {
  std::size_t cell = 0;  ///< counted from 0
  AnalogChannel channel;
  int scale = 9;  ///< a cell of 1 is 10^scale nanovolts; without meaning for logic
};

/// The layout of a CSV of samples. The time of a row is the cell `time_cell` times 10^time_scale
/// picoseconds. With a rate or a step the row has an index instead, from `time_cell`, or the number
/// of the row if there is no such cell; its time is start + index × step, or index / rate.
struct SampledCsvLayout {
  char separator = ',';
  /// Rows that are remarks of sigrok-cli are skipped.
  bool skips_remarks = false;
  std::size_t header_rows = 0;
  std::optional<std::size_t> time_cell;
  int time_scale = 12;
  Picoseconds start;
  std::int64_t step_femtoseconds = 0;
  Hertz rate;
  /// The cell `time_cell` is this times the index.
  std::int64_t index_step = 1;
  Picoseconds sample_period;
  /// The rate in the file, also if the times are a column; 0 Hz if the file has no rate.
  Hertz sample_rate;
  std::vector<CsvChannel> channels;

  bool by_index() const { return step_femtoseconds != 0 || rate.count != 0; }
};

/// Reads the rows before the samples, and a few of the samples. If the layout is not valid, it
/// returns static text with a description of a valid one.
/// \param rows of the file, without line feeds
tl::expected<SampledCsvLayout, const char*> parse_sampled_csv_layout(
    const std::vector<std::string_view>& rows);

/// Opens a CSV of samples. Values become levels by AnalogOptions.
///
/// Cells of samples are decimal numbers, with a decimal comma if the separator is `;` or a tab; an
/// empty cell is not a sample; `nan` is an unknown level; `inf` and the sign for infinity are
/// beyond the range. Rows have at least the cells of the channels and the time, else they are
/// `truncated` at the end of the file and `malformed` elsewhere. A byte order mark, CRLF, blanks
/// around cells, blank rows and rows that begin with `#` are allowed.
///
/// A row that is missing in the constant step of the times makes a hole, in which every level is
/// unknown. Rows of logic channels alone may be changes instead (sigrok, DSView): their levels hold.
///
/// Fails with `empty`, `read_failed`, `malformed` (header, number; voltages without a constant step;
/// more than two rows of the same time: it has too few digits), `token_too_long` (a row of more than 64 KiB), `too_many_lines`,
/// `time_backwards`, `time_out_of_range`, `truncated`, and as open_analog().
Opened open_sampled_csv(std::unique_ptr<ByteSource> bytes, const AnalogOptions& options);

}  // namespace biss::capture
