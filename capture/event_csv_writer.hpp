// Edges as an event CSV.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "capture/edge_writer.hpp"

namespace biss::capture {

/// How rows are written.
enum class CsvDialect : std::uint8_t {
  nanoseconds,  ///< `time_ns,MA,SLO`: three decimals, unknown is x, empty before the first level
  saleae,  ///< `Time [s],MA,SLO` as Logic 2 exports: twelve decimals, unknown is X, also before
};

/// Writes `time_ns,<names>` and a row a time at which something changes: nanoseconds with three
/// decimals, then every line's level as 0, 1 or x, empty before its first. Edges of one time share
/// a row as long as their lines come in order, so that reading gives the same edges in the same
/// order; or the same in the dialect of Saleae Logic 2. Names are quoted where need be; line ends
/// in them become `_`.
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
