// The first row of an event CSV: unit of the time, separator, names of the lines.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace biss::capture {

struct EventCsvHeader {
  char separator = ',';
  int scale = 12;  ///< a time of 1 is 10^scale picoseconds
  std::vector<std::string> lines;

  /// Where a comma does not separate it may be a decimal mark.
  bool decimal_comma() const { return separator != ','; }
};

struct EventCsvHeaderFault {
  std::size_t offset;    ///< byte in the row where the fault lies
  const char* expected;  ///< static text
};

/// Reads the row, without its line end. Cells may be quoted, blanks around them do not count. The
/// separator is a tab or a semicolon where one stands outside quotes, else a comma.
std::variant<EventCsvHeader, EventCsvHeaderFault> parse_event_csv_header(std::string_view row);

/// The scale of a time column by its name, upper and lower case alike: `time` (seconds), `time_ns`,
/// `time [us]`, `Time (ms)`. Nothing for any other name.
std::optional<int> event_csv_time_scale(std::string_view name);

/// Whether the row begins like the header of an event CSV: with a cell that begins with `time`.
bool looks_like_event_csv(std::string_view row);

/// `text` without blanks, carriage returns and (when not the separator) tabs around it.
std::string_view trim_cell(std::string_view text, char separator);

}  // namespace biss::capture
