// Event CSV: a row a change, `time_ns,MA,SLO`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"
#include "capture/edge_writer.hpp"
#include "capture/pair_source.hpp"

namespace biss::capture {

/// The scale of a time column by its name, in upper or lower case: `time` (seconds), `time_ns`,
/// `time [us]`, `Time (ms)`. Nothing for any other name.
std::optional<int> event_csv_time_scale(std::string_view name);

/// Levels that are numbers are compared as whole numbers of 10^-9.
inline constexpr int event_csv_level_scale = 9;

/// The properties of all rows of an event CSV, taken from its first rows.
struct EventCsvRows {
  /// The numbers that are the levels 0 and 1, times 10^9.
  std::int64_t low = 0;
  std::int64_t high = 1'000'000'000;
  /// The rows are samples at this step; 0: they are changes.
  Picoseconds sample_period = {};
  /// A longer time between two samples is a hole, and a shorter one is malformed.
  Picoseconds longest_step = {};
  Picoseconds shortest_step = {};

  /// Levels are written 0 and 1.
  bool plain() const { return low == 0 && high == 1'000'000'000; }
};

/// Whether the row begins like the header of an event CSV: with a cell that begins with `time`.
bool looks_like_event_csv(std::string_view row);

/// Opens an event CSV: reads its header, then delivers the changes of each row.
///
/// The header is `time` with its unit and a name a line; see event_csv_header.hpp. A row holds a
/// time and the levels from then on: 0, 1, x, z or nan (all Level::unknown), or nothing if a level
/// does not change. Levels may be written as other numbers that are 0 and 1, or as the two numbers
/// of `rows`. In a hole between samples every level is unknown. Times are decimal numbers, with or
/// without exponent, rounded exactly to the picosecond; they may be negative and never fall. A byte
/// order mark, CRLF, blanks around cells, blank rows and rows that begin with `#` are allowed.
///
/// Fails with `empty`, `read_failed`, `malformed` (header, number, level, count of columns),
/// `token_too_long` (a row of more than 64 KiB), `time_backwards`, `time_out_of_range` and
/// `truncated`. A row counts whole or not at all. A missing line feed at the end is not a fault,
/// but a last row without one is `truncated` when columns are missing or its last cell is empty.
///
/// \param piece_limit the most text of a piece of pairs()
Opened open_event_csv(std::unique_ptr<ByteSource> bytes,
                      std::size_t piece_limit = default_piece_bytes, const EventCsvRows& rows = {});

/// How rows are written.
enum class CsvDialect : std::uint8_t {
  nanoseconds,  ///< `time_ns,MA,SLO`: three decimals, unknown is x, empty before the first level
  saleae,  ///< `Time [s],MA,SLO` as Logic 2 exports: twelve decimals, unknown is X, also before
};

/// Writes `time_ns,<names>` and a row a time at which something changes: nanoseconds with three
/// decimals, then every line's level as 0, 1 or x, empty before its first. Edges with the same time
/// share a row as long as their lines come in order, so that reading gives the same edges in the
/// same order; or the same in the dialect of Saleae Logic 2. Names are quoted if necessary; line
/// ends in them become `_`.
class EventCsvWriter final : public EdgeWriter {
 public:
  EventCsvWriter(std::vector<std::string> lines, ByteSink& sink,
                 CsvDialect dialect = CsvDialect::nanoseconds);

 private:
  void put(const wire::Edge& edge, bool new_time) override;
  void put_end(Picoseconds end_time, bool later) override;
  bool negative_times() const override { return true; }
  void put_row();
  void put_time(Picoseconds time);

  CsvDialect dialect_;

  // The row under way: its time, and the line that changed last in it.
  std::optional<Picoseconds> row_time_;
  wire::LineIndex row_line_ = 0;
  std::string cells_;
};

}  // namespace biss::capture
