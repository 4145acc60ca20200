#include "capture/event_csv_reader.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "capture/decimal.hpp"
#include "capture/event_csv_header.hpp"
#include "capture/text_source.hpp"

namespace biss::capture {
namespace {

using wire::Level;

// Cells that are not one of the three levels.
constexpr std::uint8_t unchanged = no_level + 1;
constexpr std::uint8_t no_cell = no_level + 2;

constexpr std::array<std::uint8_t, 256> make_levels() {
  std::array<std::uint8_t, 256> levels{};
  levels.fill(no_cell);
  levels['0'] = static_cast<std::uint8_t>(Level::low);
  levels['1'] = static_cast<std::uint8_t>(Level::high);
  for (const char c : {'x', 'X', 'z', 'Z'}) {
    levels[static_cast<unsigned char>(c)] = static_cast<std::uint8_t>(Level::unknown);
  }
  return levels;
}

constexpr std::array<std::uint8_t, 256> levels = make_levels();

std::string_view text_between(const char* from, const char* to) {
  return {from, static_cast<std::size_t>(to - from)};
}

std::string_view without_quotes(std::string_view cell) {
  if (cell.size() < 2 || !cell.starts_with('"') || !cell.ends_with('"')) return cell;
  return cell.substr(1, cell.size() - 2);
}

const char* find_or_end(const char* from, const char* end, char wanted) {
  const void* const found = std::memchr(from, wanted, static_cast<std::size_t>(end - from));
  return found == nullptr ? end : static_cast<const char*>(found);
}

class EventCsvReader final : public TextSource {
 public:
  explicit EventCsvReader(std::unique_ptr<ByteSource> bytes)
      : TextSource(std::move(bytes), TextWindow::Cut::lines) {}

  // Reads the header; the cause when there is none.
  std::optional<CaptureError> open();

 private:
  void parse() override;
  void finish() override {}

  bool is_comment(std::string_view row) const { return row.empty() || row.front() == '#'; }
  bool stop(const char* place, CaptureCause cause, const char* expected = nullptr);
  bool stop_in_row(const char* place, const char* expected, bool cut);
  bool take_header(const char* row, const char* end);
  bool read_row(const char* row, const char* end);
  bool read_time(const char* cell, const char* cell_end, const char* end);
  bool read_levels(const char* cell, const char* end);
  void commit();

  EventCsvHeader header_;
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
      if (end - row <= static_cast<std::ptrdiff_t>(max_token_bytes) && is_comment(text)) continue;
      if (!take_header(row, end)) return error();
      return std::nullopt;
    }
  }
}

bool EventCsvReader::take_header(const char* row, const char* end) {
  const std::string_view text = text_between(row, end);
  if (text.size() > max_token_bytes) return stop(row, CaptureCause::token_too_long);
  const auto parsed = parse_event_csv_header(text);
  if (const auto* fault = std::get_if<EventCsvHeaderFault>(&parsed)) {
    return stop_in_row(row + fault->offset, fault->expected, looks_like_event_csv(text));
  }
  header_ = std::get<EventCsvHeader>(parsed);
  lines_ = header_.lines;
  row_levels_.assign(lines_.size(), unchanged);
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
  if (row == end || *row < '-' || *row > '9') {
    if (is_comment(trim_cell(text_between(row, end), ','))) return true;
  }
  const char* const time_end = find_or_end(row, end, header_.separator);
  if (!read_time(row, time_end, end)) return false;
  if (time_end == end) return stop_in_row(end, "a level for every line", true);
  if (!read_levels(time_end + 1, end)) return false;
  commit();
  return true;
}

bool EventCsvReader::read_time(const char* cell, const char* cell_end, const char* end) {
  const std::string_view text =
      without_quotes(trim_cell(text_between(cell, cell_end), header_.separator));
  const auto time = parse_decimal(text, header_.scale, header_.decimal_comma());
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
  row_time_ = {*time};
  any_row_ = true;
  return true;
}

bool EventCsvReader::read_levels(const char* cell, const char* end) {
  for (std::size_t line = 0; line < row_levels_.size(); ++line) {
    const char* cell_end = cell;
    // The common cell is one character; memchr would cost more than it saves.
    while (cell_end != end && *cell_end != header_.separator) ++cell_end;
    std::string_view text = text_between(cell, cell_end);
    if (text.size() > 1) text = without_quotes(trim_cell(text, header_.separator));
    std::uint8_t level = text.size() == 1 ? levels[static_cast<unsigned char>(text[0])] : no_cell;
    if (text.empty() || text == " " || text == "\r") level = unchanged;
    if (level == no_cell) return stop_in_row(cell, "a level: 0, 1, x, z or nothing", false);
    row_levels_[line] = level;
    const bool last = line + 1 == row_levels_.size();
    if (last && cell_end != end) return stop_in_row(cell_end, "no more columns than names", false);
    if (cell_end == end && (!last || (level == unchanged && window_.unterminated()))) {
      return stop_in_row(end, "a level for every line", true);
    }
    cell = cell_end + 1;
  }
  return true;
}

void EventCsvReader::commit() {
  end_time_ = row_time_;
  for (std::size_t line = 0; line < row_levels_.size(); ++line) {
    const std::uint8_t level = row_levels_[line];
    if (level == unchanged || level == last_levels_[line]) continue;
    last_levels_[line] = level;
    block_.push({row_time_, static_cast<wire::LineIndex>(line), static_cast<Level>(level)});
  }
}

}  // namespace

Opened open_event_csv(std::unique_ptr<ByteSource> bytes) {
  auto reader = std::make_unique<EventCsvReader>(std::move(bytes));
  if (const auto error = reader->open()) return {nullptr, *error};
  return {std::move(reader), {}};
}

}  // namespace biss::capture
