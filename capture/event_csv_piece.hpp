// The quick way through the rows of an event CSV, for two of its lines; and its cells.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/base/result.hpp"
#include "capture/decimal.hpp"
#include "capture/edge_source.hpp"
#include "capture/event_csv.hpp"
#include "capture/text_piece.hpp"
#include "wire/edge.hpp"

namespace biss::capture {

/// How the rows of an event CSV are written.
struct EventCsvLayout {
  char separator = ',';
  int scale = 12;           ///< a time of 1 is 10^scale picoseconds
  std::size_t columns = 0;  ///< of levels, after the time
  EventCsvRows rows = {};

  /// Where a comma does not separate it may be a decimal mark.
  bool decimal_comma() const { return separator != ','; }
};

/// Whether there is a hole between the times of two rows. \pre from <= to
inline bool is_hole(std::int64_t from, std::int64_t to, const EventCsvRows& rows) {
  return rows.sample_period.count != 0 &&
         static_cast<std::uint64_t>(to) - static_cast<std::uint64_t>(from) >
             static_cast<std::uint64_t>(rows.longest_step.count);
}

/// Whether two rows are too close for samples; rows at the same time are not. \pre from <= to
inline bool is_short(std::int64_t from, std::int64_t to, const EventCsvRows& rows) {
  return rows.shortest_step.count > 0 && to != from &&
         static_cast<std::uint64_t>(to) - static_cast<std::uint64_t>(from) <
             static_cast<std::uint64_t>(rows.shortest_step.count);
}

/// Cells that are not one of the three levels.
inline constexpr std::uint8_t unchanged_cell = no_level + 1;
inline constexpr std::uint8_t wrong_cell = no_level + 2;

/// The level in a cell, or one of these two.
std::uint8_t event_csv_level(std::string_view cell, const EventCsvLayout& layout);
/// The time in a cell, in picoseconds.
Result<std::int64_t, DecimalCause> event_csv_time(std::string_view cell,
                                                  const EventCsvLayout& layout);
/// A row that says nothing: blank, or a comment without a CR, which may have ended it.
bool is_event_csv_comment(std::string_view row);

/// A piece of an event CSV. Regular are whole rows in order of time, whose cells for the two lines
/// are 0, 1 or nothing, and comments.
class EventCsvPiece final : public TextPiece {
 public:
  EventCsvPiece(const EventCsvLayout& layout, wire::LineIndex ma_column, wire::LineIndex slo_column)
      : layout_(layout), ma_column_(ma_column), slo_column_(slo_column) {}

  // Of a regular piece:
  bool timed = false;           ///< it has a row with a time
  std::int64_t first_time = 0;  ///< when timed
  std::int64_t last_time = 0;   ///< when timed

 private:
  bool quick_parse() override;

  EventCsvLayout layout_;
  wire::LineIndex ma_column_;
  wire::LineIndex slo_column_;
};

}  // namespace biss::capture
