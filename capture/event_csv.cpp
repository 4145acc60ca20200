#include "capture/event_csv.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/csv_cells.hpp"
#include "capture/decimal.hpp"
#include "capture/edge_source.hpp"
#include "capture/event_csv_piece.hpp"
#include "capture/text_source.hpp"

namespace biss::capture {
namespace {

struct EventCsvHeader {
  EventCsvLayout layout;
  std::vector<std::string> lines;
};

struct EventCsvHeaderFault {
  std::size_t offset;    ///< byte in the row where the fault lies
  const char* expected;  ///< static text
};

/// Reads the row, without its line end. Cells may be quoted, blanks around them do not count. The
/// separator is a tab or a semicolon where one stands outside quotes, else a comma.
tl::expected<EventCsvHeader, EventCsvHeaderFault> parse_event_csv_header(std::string_view row) {
  EventCsvHeader header;
  const char separator = header.layout.separator = find_separator(row);
  const char* const start = row.data();
  bool last = false;
  const auto scale = event_csv_time_scale(unquote(take_cell(row, separator, last)));
  if (!scale) {
    return tl::unexpected(
        EventCsvHeaderFault{0, "a header such as time_ns,MA,SLO with s, ms, us, ns or ps"});
  }
  header.layout.scale = *scale;
  LineNames names;
  while (!last) {
    const auto offset = static_cast<std::size_t>(row.data() - start);
    const std::string name = unquote(take_cell(row, separator, last));
    if (name.empty())
      return tl::unexpected(EventCsvHeaderFault{offset, "the name of a line in every column"});
    header.lines.push_back(names.claim(name));
  }
  if (header.lines.empty()) {
    return tl::unexpected(EventCsvHeaderFault{static_cast<std::size_t>(row.data() - start),
                                              "a column for each line after the time"});
  }
  header.layout.columns = header.lines.size();
  return header;
}

using wire::Level;

class EventCsvReader final : public TextSource {
 public:
  EventCsvReader(std::unique_ptr<ByteSource> bytes, std::size_t piece_limit,
                 const EventCsvRows& rows)
      : TextSource(std::move(bytes), TextWindow::Cut::lines, piece_limit), rows_(rows) {}

  // Reads the header; the cause when there is none.
  std::optional<CaptureError> open();
  Picoseconds sample_period() const override { return rows_.sample_period; }

 private:
  void parse() override;
  void finish() override {}
  bool choose_pair(wire::LineIndex ma, wire::LineIndex slo) override;
  std::unique_ptr<TextPiece> new_piece() const override;
  bool take_over(TextPiece& piece) override;

  bool stop(const char* place, CaptureCause cause, const char* expected = nullptr);
  bool stop_in_row(const char* place, const char* expected, bool cut);
  bool take_header(const char* row, const char* end);
  bool read_row(const char* row, const char* end);
  bool read_time(const char* cell, const char* cell_end, const char* end);
  bool read_levels(const char* cell, const char* end);
  void commit();

  EventCsvRows rows_;
  EventCsvLayout layout_;
  wire::LineIndex ma_ = 0;
  wire::LineIndex slo_ = 0;
  Picoseconds row_time_;
  bool any_row_ = false;
  std::vector<std::uint8_t> row_levels_;
  std::vector<std::uint8_t> last_levels_;
};

bool EventCsvReader::stop(const char* place, CaptureCause cause, const char* expected) {
  fail(window_.error_at(place, cause, expected));
  return false;
}

// `cut`: the fault may come from the text having been cut off, if the text ends here.
bool EventCsvReader::stop_in_row(const char* place, const char* expected, bool cut) {
  const bool truncated = cut && window_.unterminated();
  return stop(place, truncated ? CaptureCause::truncated : CaptureCause::malformed, expected);
}

std::optional<CaptureError> EventCsvReader::open() {
  bool any_text = false;
  for (;;) {
    switch (window_.next()) {
      case TextWindow::Fill::failed:
        return window_.error();
      case TextWindow::Fill::ended:
        if (!any_text) return CaptureError{.cause = CaptureCause::empty};
        return window_.error_at(window_.end(), CaptureCause::truncated, "a header and rows");
      case TextWindow::Fill::ready:
        break;
    }
    while (window_.begin() != window_.end()) {
      const char* const row = window_.begin();
      const char* const end = find_or_end(row, window_.end(), '\n');
      window_.advance(end + 1);
      const std::string_view text = trim_cell(text_between(row, end), ',');
      any_text = any_text || !text.empty();
      if (end - row <= static_cast<std::ptrdiff_t>(max_token_bytes) && is_event_csv_comment(text))
        continue;
      if (!take_header(row, end)) return error();
      return std::nullopt;
    }
  }
}

bool EventCsvReader::take_header(const char* row, const char* end) {
  const std::string_view text = text_between(row, end);
  if (text.size() > max_token_bytes || has_cr_inside(text)) {
    return stop(row, CaptureCause::token_too_long);
  }
  auto parsed = parse_event_csv_header(text);
  if (!parsed) {
    const EventCsvHeaderFault& fault = parsed.error();
    return stop_in_row(row + fault.offset, fault.expected, looks_like_event_csv(text));
  }
  layout_ = parsed->layout;
  layout_.rows = rows_;
  lines_ = std::move(parsed->lines);
  row_levels_.assign(lines_.size(), unchanged_cell);
  last_levels_.assign(lines_.size(), no_level);
  return true;
}

void EventCsvReader::parse() {
  const char* row = window_.begin();
  const char* const end = window_.end();
  while (row != end && !block_.full()) {
    const char* const row_end = find_or_end(row, end, '\n');
    if (!read_row(row, row_end)) return;
    row = row_end + 1;
  }
  window_.advance(row);
}

bool EventCsvReader::read_row(const char* row, const char* end) {
  if (end - row > static_cast<std::ptrdiff_t>(max_token_bytes)) {
    return stop(row, CaptureCause::token_too_long);
  }
  if (is_event_csv_comment(text_between(row, end))) return true;
  const char* const time_end = find_or_end(row, end, layout_.separator);
  if (!read_time(row, time_end, end)) return false;
  if (time_end == end) return stop_in_row(end, "a level for every line", true);
  if (!read_levels(time_end + 1, end)) return false;
  commit();
  return true;
}

bool EventCsvReader::read_time(const char* cell, const char* cell_end, const char* end) {
  const auto time = event_csv_time(text_between(cell, cell_end), layout_);
  if (!time.ok()) {
    if (time.error() == DecimalCause::out_of_range) {
      return stop(cell, CaptureCause::time_out_of_range);
    }
    return stop_in_row(cell, "a decimal number as the time", cell_end == end);
  }
  if (any_row_ && *time < row_time_.count) {
    // A number cut off is smaller than it was.
    if (cell_end == end) return stop_in_row(end, "a level for every line", true);
    return stop(cell, CaptureCause::time_backwards);
  }
  if (any_row_ && is_short(row_time_.count, *time, rows_)) {
    return stop(cell, CaptureCause::malformed,
                "samples at the constant step of the first rows, or a row for each change only");
  }
  row_time_ = Picoseconds{*time};
  any_row_ = true;
  return true;
}

bool EventCsvReader::read_levels(const char* cell, const char* end) {
  for (std::size_t line = 0; line < row_levels_.size(); ++line) {
    const char* cell_end = cell;
    // The common cell is one character; memchr would cost more than it saves.
    while (cell_end != end && *cell_end != layout_.separator) ++cell_end;
    const std::uint8_t level = event_csv_level(text_between(cell, cell_end), layout_);
    if (level == wrong_cell) {
      return stop_in_row(cell,
                         "a level: 0 and 1, or two other numbers, x, z or nothing; voltages need a "
                         "constant step",
                         false);
    }
    row_levels_[line] = level;
    const bool last = line + 1 == row_levels_.size();
    if (last && cell_end != end) return stop_in_row(cell_end, "no more columns than names", false);
    if (cell_end == end && (!last || (level == unchanged_cell && window_.unterminated()))) {
      return stop_in_row(end, "a level for every line", true);
    }
    cell = cell_end + 1;
  }
  return true;
}

void EventCsvReader::commit() {
  constexpr auto unknown = static_cast<std::uint8_t>(Level::unknown);
  const bool hole = row_time_ > end_time_ && is_hole(end_time_.count, row_time_.count, rows_);
  for (std::size_t line = 0; hole && line < last_levels_.size(); ++line) {
    if (last_levels_[line] >= unknown) continue;
    last_levels_[line] = unknown;
    block_.push({end_time_, static_cast<wire::LineIndex>(line), Level::unknown});
  }
  end_time_ = row_time_;
  for (std::size_t line = 0; line < row_levels_.size(); ++line) {
    const std::uint8_t level = row_levels_[line];
    if (level == unchanged_cell || level == last_levels_[line]) continue;
    last_levels_[line] = level;
    block_.push({row_time_, static_cast<wire::LineIndex>(line), static_cast<Level>(level)});
  }
}

bool EventCsvReader::choose_pair(wire::LineIndex ma, wire::LineIndex slo) {
  ma_ = ma;
  slo_ = slo;
  return ma != slo;
}

std::unique_ptr<TextPiece> EventCsvReader::new_piece() const {
  return std::make_unique<EventCsvPiece>(layout_, ma_, slo_);
}

bool EventCsvReader::take_over(TextPiece& text) {
  const auto& piece = static_cast<EventCsvPiece&>(text);
  if (!piece.timed) return true;
  if (any_row_ &&
      (piece.first_time < row_time_.count || is_hole(row_time_.count, piece.first_time, rows_) ||
       is_short(row_time_.count, piece.first_time, rows_))) {
    return false;
  }
  row_time_ = end_time_ = Picoseconds{piece.last_time};
  any_row_ = true;
  const auto note = [this](wire::LineIndex line, const LineChanges& changes) {
    if (const auto level = last_level(changes)) {
      last_levels_[line] = static_cast<std::uint8_t>(*level);
    }
  };
  note(ma_, piece.ma);
  note(slo_, piece.slo);
  return true;
}

constexpr char no_level_yet = ' ';

std::string cell_of(std::string_view name) {
  std::string cell;
  bool quote = name.empty() || name.front() == ' ' || name.back() == ' ';
  for (const char c : name) {
    if (c == ',' || c == ';' || c == '\t' || c == '"') quote = true;
    if (c == '"') cell += '"';
    cell += c == '\n' || c == '\r' ? '_' : c;
  }
  if (cell.empty()) cell.push_back('_');
  return quote ? '"' + cell + '"' : cell;
}

}  // namespace

std::optional<int> event_csv_time_scale(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, int>, 8> units{{{"", 12},
                                                                   {"s", 12},
                                                                   {"ms", 9},
                                                                   {"us", 6},
                                                                   {"\xC2\xB5s", 6},
                                                                   {"\xCE\xBCs", 6},
                                                                   {"ns", 3},
                                                                   {"ps", 0}}};
  const std::string lower = lower_case(name);
  std::string_view unit = lower;
  if (!unit.starts_with("time")) return std::nullopt;
  unit.remove_prefix(4);
  unit.remove_prefix(std::min(unit.find_first_not_of(" _/(["), unit.size()));
  while (!unit.empty() && std::string_view(" )]").find(unit.back()) != std::string_view::npos) {
    unit.remove_suffix(1);
  }
  for (const auto& [text, scale] : units) {
    if (unit == text) return scale;
  }
  return std::nullopt;
}

bool looks_like_event_csv(std::string_view row) {
  bool last = false;
  const std::string_view cell = take_cell(row, find_separator(row), last);
  return lower_case(unquote(cell)).starts_with("time");
}

Opened open_event_csv(std::unique_ptr<ByteSource> bytes, std::size_t piece_limit) {
  return open_event_csv(std::move(bytes), piece_limit, EventCsvRows());
}

Opened open_event_csv(std::unique_ptr<ByteSource> bytes, std::size_t piece_limit,
                      const EventCsvRows& rows) {
  auto reader = std::make_unique<EventCsvReader>(std::move(bytes), piece_limit, rows);
  if (const auto error = reader->open()) return tl::unexpected(*error);
  return reader;
}

EventCsvWriter::EventCsvWriter(std::vector<std::string> lines, ByteSink& sink, CsvDialect dialect)
    : EdgeWriter(std::move(lines), sink),
      dialect_(dialect),
      cells_(this->lines().size(), dialect == CsvDialect::saleae ? 'X' : no_level_yet) {
  text() += dialect == CsvDialect::saleae ? "Time [s]" : "time_ns";
  for (const std::string& name : this->lines()) text() += ',' + cell_of(name);
  text() += '\n';
}

void EventCsvWriter::put_time(Picoseconds time) {
  if (time < Picoseconds{}) text() += '-';
  const auto count = static_cast<std::uint64_t>(time.count);
  const std::uint64_t magnitude = time < Picoseconds{} ? std::uint64_t{0} - count : count;
  const std::uint64_t unit =
      dialect_ == CsvDialect::saleae ? std::uint64_t{picoseconds_per_second} : 1'000;
  append_number(magnitude / unit);
  text() += '.';
  for (std::uint64_t place = unit / 10; place != 0; place /= 10) {
    text() += static_cast<char>('0' + magnitude / place % 10);
  }
}

void EventCsvWriter::put_row() {
  put_time(*row_time_);
  for (const char cell : cells_) {
    text() += ',';
    if (cell != no_level_yet) text() += cell;
  }
  text() += '\n';
}

void EventCsvWriter::put(const wire::Edge& edge, bool new_time) {
  if (row_time_ && (new_time || edge.line <= row_line_)) put_row();
  row_time_ = edge.time;
  row_line_ = edge.line;
  cells_[edge.line] =
      (dialect_ == CsvDialect::saleae ? "01X" : "01x")[static_cast<std::size_t>(edge.level)];
}

void EventCsvWriter::put_end(Picoseconds end_time, bool later) {
  if (row_time_) put_row();
  row_time_ = end_time;
  if (later && !cells_.empty()) put_row();
}

}  // namespace biss::capture
