#include "capture/event_csv.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "capture/csv_cells.hpp"
#include "capture/decimal.hpp"
#include "capture/text_source.hpp"

namespace biss::capture {
namespace {

using wire::Level;

/// How the rows of an event CSV are written.
struct EventCsvLayout {
  char separator = ',';
  int scale = 12;           ///< a time of 1 is 10^scale picoseconds
  std::size_t columns = 0;  ///< of levels, after the time
  EventCsvRows rows = {};

  /// If the comma is not the separator, it may be a decimal mark.
  bool decimal_comma() const { return separator != ','; }
};

/// Whether there is a hole between the times of two rows. \pre from <= to
bool is_hole(std::int64_t from, std::int64_t to, const EventCsvRows& rows) {
  return rows.sample_period.count != 0 &&
         static_cast<std::uint64_t>(to) - static_cast<std::uint64_t>(from) >
             static_cast<std::uint64_t>(rows.longest_step.count);
}

/// Whether two rows are too close for samples; rows at the same time are not. \pre from <= to
bool is_short(std::int64_t from, std::int64_t to, const EventCsvRows& rows) {
  return rows.shortest_step.count > 0 && to != from &&
         static_cast<std::uint64_t>(to) - static_cast<std::uint64_t>(from) <
             static_cast<std::uint64_t>(rows.shortest_step.count);
}

// Cells that are not one of the three levels.
constexpr std::uint8_t unchanged_cell = no_level + 1;
constexpr std::uint8_t wrong_cell = no_level + 2;

constexpr std::array<std::uint8_t, 256> make_cell_levels() {
  std::array<std::uint8_t, 256> levels{};
  levels.fill(wrong_cell);
  levels['0'] = static_cast<std::uint8_t>(Level::low);
  levels['1'] = static_cast<std::uint8_t>(Level::high);
  levels[' '] = levels['\r'] = unchanged_cell;
  for (const char c : {'x', 'X', 'z', 'Z'}) {
    levels[static_cast<unsigned char>(c)] = static_cast<std::uint8_t>(Level::unknown);
  }
  return levels;
}

constexpr std::array<std::uint8_t, 256> cell_levels = make_cell_levels();

// The level in a cell, or one of these two.
std::uint8_t event_csv_level(std::string_view cell, const EventCsvLayout& layout) {
  constexpr auto low = static_cast<std::uint8_t>(Level::low);
  constexpr auto high = static_cast<std::uint8_t>(Level::high);
  if (cell.empty()) return unchanged_cell;
  if (cell.size() > 1) {
    cell = without_quotes(trim_cell(cell, layout.separator));
    if (cell.empty() || cell == " " || cell == "\r") return unchanged_cell;
  }
  if (cell.size() == 1) {
    const std::uint8_t level = cell_levels[static_cast<unsigned char>(cell[0])];
    if (level != wrong_cell && (level > high || layout.rows.plain())) return level;
  }
  const auto number = parse_decimal(cell, event_csv_level_scale, layout.decimal_comma());
  if (!number.ok()) {
    return lower_case(cell) == "nan" ? static_cast<std::uint8_t>(Level::unknown) : wrong_cell;
  }
  return *number == layout.rows.low ? low : *number == layout.rows.high ? high : wrong_cell;
}

// The time in a cell, in picoseconds.
Result<std::int64_t, DecimalCause> event_csv_time(std::string_view cell,
                                                  const EventCsvLayout& layout) {
  return parse_decimal(without_quotes(trim_cell(cell, layout.separator)), layout.scale,
                       layout.decimal_comma());
}

bool is_part_of_number(char c) {
  return std::string_view("0123456789+-.,eE").find(c) != std::string_view::npos;
}

struct EventCsvRow {
  std::int64_t time;
  std::uint8_t ma;
  std::uint8_t slo;
};

/// The shape of a row that the parser has understood: the places and numbers of its digits, and the
/// text after the time. A row of the same shape differs in its digits and levels only.
class EventCsvShape {
 public:
  /// Learns the shape of a row, `[row, end)` before its line feed, whose cells are all right.
  /// `time_end` is its first separator.
  void learn(const char* row, const char* time_end, const char* end, const EventCsvLayout& layout,
             wire::LineIndex ma_column, wire::LineIndex slo_column) {
    const bool known = learn_time(row, time_end, layout) &&
                       learn_cells(time_end, end, layout, ma_column, slo_column);
    row_bytes_ = known ? static_cast<std::size_t>(end + 1 - row) : 0;
  }

  /// Reads the row at `row`. False if the text up to `end` does not begin with a row of this shape.
  bool read(const char* row, const char* end, EventCsvRow& out) {
    if (row_bytes_ == 0 || static_cast<std::size_t>(end - row) < row_bytes_) return false;
    std::uint64_t whole = 0;
    std::uint64_t fraction = 0;
    const char* const tail = row + time_end_;
    if (!whole_.read(row + whole_end_, whole) || !fraction_.read(tail, fraction)) return false;
    if (row[whole_end_] != mark_ || (negative_ && *row != '-')) return false;
    for (std::size_t i = 0; i < tail_words_; ++i) {
      if ((load_eight(tail + 8 * i) & mask_[i]) != tail_[i]) return false;
    }
    if (whole > whole_limit_) return false;
    // Beyond the picosecond, the first digit decides: halves are rounded away from zero.
    const std::uint64_t part =
        divisor_ == 1 ? fraction * factor_ : (fraction + divisor_ / 2) / divisor_;
    const auto time = static_cast<std::int64_t>(whole * unit_ + part);
    out = {negative_ ? -time : time, static_cast<std::uint8_t>(row[ma_at_] - '0'),
           static_cast<std::uint8_t>(row[slo_at_] - '0')};
    return true;
  }

  std::size_t row_bytes() const { return row_bytes_; }

 private:
  static constexpr std::size_t words = 8;

  bool learn_time(const char* row, const char* end, const EventCsvLayout& layout) {
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    negative_ = *row == '-';
    const char* const whole = row + (negative_ ? 1 : 0);
    const char* const whole_end = std::find_if_not(whole, end, is_digit);
    // Without a fraction the separator is in the place of the mark.
    mark_ = *whole_end;
    const bool marked =
        whole_end != end && (mark_ == '.' || (mark_ == ',' && layout.decimal_comma()));
    const char* const fraction = marked ? whole_end + 1 : whole_end;
    if (std::find_if_not(fraction, end, is_digit) != end) return false;
    const auto whole_digits = static_cast<std::size_t>(whole_end - whole);
    const auto fraction_digits = static_cast<std::size_t>(end - fraction);
    if (whole_digits == 0 || whole_digits > FixedDigits::most) return false;
    if (fraction_digits > FixedDigits::most) return false;
    whole_ = FixedDigits(whole_digits);
    fraction_ = FixedDigits(fraction_digits);
    whole_end_ = static_cast<std::size_t>(whole_end - row);
    time_end_ = static_cast<std::size_t>(end - row);
    const auto scale = static_cast<std::size_t>(layout.scale);
    unit_ = powers_of_ten[scale];
    whole_limit_ =
        (static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()) - unit_) / unit_;
    factor_ = fraction_digits < scale ? powers_of_ten[scale - fraction_digits] : 1;
    divisor_ = fraction_digits > scale ? powers_of_ten[fraction_digits - scale] : 1;
    return true;
  }

  bool learn_cells(const char* from, const char* end, const EventCsvLayout& layout,
                   wire::LineIndex ma_column, wire::LineIndex slo_column) {
    if (static_cast<std::size_t>(end + 1 - from) > 8 * words || !layout.rows.plain()) return false;
    tail_.fill(0);
    mask_.fill(0);
    ma_at_ = slo_at_ = 0;
    std::size_t column = 0;  // of levels, from 1
    bool seen = false;       // the level of this cell
    for (const char* p = from; p <= end; ++p) {
      if (*p == layout.separator) {
        ++column;
        seen = false;
      }
      const bool level = !seen && (*p == '0' || *p == '1');
      // In a longer number one digit does not show the level.
      if (!level && *p != layout.separator && is_part_of_number(*p)) return false;
      seen = seen || level;
      keep(static_cast<std::size_t>(p - from), *p, level ? 0xFE : 0xFF);
      const std::size_t at = time_end_ + static_cast<std::size_t>(p - from);
      if (level && column == ma_column + std::size_t{1}) ma_at_ = at;
      if (level && column == slo_column + std::size_t{1}) slo_at_ = at;
    }
    tail_words_ = (static_cast<std::size_t>(end + 1 - from) + 7) / 8;
    return ma_at_ != 0 && slo_at_ != 0;
  }

  void keep(std::size_t at, char c, unsigned char mask) {
    const auto byte = static_cast<std::uint64_t>(static_cast<unsigned char>(c) & mask);
    tail_[at / 8] |= byte << (8 * (at % 8));
    mask_[at / 8] |= std::uint64_t{mask} << (8 * (at % 8));
  }

  std::size_t row_bytes_ = 0;  // 0 until a shape is known
  FixedDigits whole_{0};
  FixedDigits fraction_{0};
  std::size_t whole_end_ = 0;  // places in the row
  std::size_t time_end_ = 0;
  bool negative_ = false;
  char mark_ = '.';
  std::uint64_t unit_ = 1;  // picoseconds of a whole one
  std::uint64_t whole_limit_ = 0;
  std::uint64_t factor_ = 1;  // picoseconds of the last digit, or how many of them are one
  std::uint64_t divisor_ = 1;
  std::size_t tail_words_ = 0;  // the text after the time, for the bits that are 1 in the mask
  std::array<std::uint64_t, words> tail_{};
  std::array<std::uint64_t, words> mask_{};
  std::size_t ma_at_ = 0;  // places in the row
  std::size_t slo_at_ = 0;
};

/// A piece of an event CSV. Whole rows in order of time are regular if their cells for the two
/// lines are 0, 1 or empty; so are comments. Any other row ends the piece.
class EventCsvPiece final : public TextPiece {
 public:
  EventCsvPiece(const EventCsvLayout& layout, wire::LineIndex ma_column, wire::LineIndex slo_column)
      : layout_(layout), ma_column_(ma_column), slo_column_(slo_column) {}

  // In a regular piece:
  bool timed = false;           ///< it has a row with a time
  std::int64_t first_time = 0;  ///< when timed
  std::int64_t last_time = 0;   ///< when timed

 private:
  enum class Read : std::uint8_t { row, comment, wrong };

  bool quick_parse() override {
    const char* row = begin();
    const char* const text_end = end();
    EventCsvRow read{};
    EventCsvShape shape;
    timed = false;
    ma_.restart();
    slo_.restart();
    last_time = std::numeric_limits<std::int64_t>::min();
    for (line_feeds = 0; row != text_end; ++line_feeds) {
      if (shape.read(row, text_end, read)) {
        if (!add(read)) return false;
        row += shape.row_bytes();
        continue;
      }
      const char* const row_end = find_or_end(row, text_end, '\n');
      const Read what = read_row(row, row_end, shape, read);
      if (what == Read::wrong || (what == Read::row && !add(read))) return false;
      row = row_end + 1;
    }
    take_batches();
    return true;
  }

  Read read_row(const char* row, const char* end, EventCsvShape& shape, EventCsvRow& out) {
    if (end - row > static_cast<std::ptrdiff_t>(max_token_bytes)) return Read::wrong;
    if (is_csv_comment(text_between(row, end))) return Read::comment;
    const char* const time_end = find_or_end(row, end, layout_.separator);
    if (time_end == end) return Read::wrong;
    const auto time = event_csv_time(text_between(row, time_end), layout_);
    if (!time.ok() || !read_cells(time_end + 1, end, out)) return Read::wrong;
    out.time = *time;
    shape.learn(row, time_end, end, layout_, ma_column_, slo_column_);
    return Read::row;
  }

  bool read_cells(const char* cell, const char* end, EventCsvRow& out) const {
    out.ma = out.slo = unchanged_cell;
    for (std::size_t column = 0; column < layout_.columns; ++column) {
      const char* const cell_end = std::find(cell, end, layout_.separator);
      const std::uint8_t level = event_csv_level(text_between(cell, cell_end), layout_);
      const bool last = column + 1 == layout_.columns;
      if (level == wrong_cell || last != (cell_end == end)) return false;
      if (column == ma_column_) out.ma = level;
      if (column == slo_column_) out.slo = level;
      cell = cell_end + 1;
    }
    return true;
  }

  // False when arrays cannot represent it, or time runs backwards.
  bool add(const EventCsvRow& row) {
    constexpr auto unknown = static_cast<std::uint8_t>(Level::unknown);
    if (row.time < last_time || row.ma == unknown || row.slo == unknown) return false;
    if (!timed) first_time = last_time = row.time;
    timed = true;
    if (is_hole(last_time, row.time, layout_.rows) || is_short(last_time, row.time, layout_.rows)) {
      return false;
    }
    last_time = row.time;
    if (row.ma != unchanged_cell) ma_.add(row.time, row.ma);
    if (row.slo != unchanged_cell) slo_.add(row.time, row.slo);
    if (ma_.full() || slo_.full()) take_batches();
    return true;
  }

  void take_batches() {
    const auto as_is = [](std::int64_t time) { return time; };
    ma_.take(ma, as_is);
    slo_.take(slo, as_is);
  }

  EventCsvLayout layout_;
  wire::LineIndex ma_column_;
  wire::LineIndex slo_column_;
  ChangeBatch ma_;
  ChangeBatch slo_;
};

class EventCsvReader final : public TextSource {
 public:
  EventCsvReader(std::unique_ptr<ByteSource> bytes, std::size_t piece_limit,
                 const EventCsvRows& rows)
      : TextSource(std::move(bytes), TextWindow::Cut::lines, piece_limit) {
    layout_.rows = rows;
  }

  // Reads the header; the cause when there is none.
  std::optional<CaptureError> open() {
    bool any_text = false;
    for (;;) {
      if (window_.begin() == window_.end()) {
        const auto more = window_.next();
        if (!more) return more.error();
        if (!*more && !any_text) return CaptureError{.cause = CaptureCause::empty};
        if (!*more) {
          return window_.error_at(window_.end(), CaptureCause::truncated, "a header and rows");
        }
      }
      const char* const row = window_.begin();
      const char* const end = find_or_end(row, window_.end(), '\n');
      window_.advance(end + 1);
      const std::string_view text = trim_cell(text_between(row, end), ',');
      any_text = any_text || !text.empty();
      const bool fits = end - row <= static_cast<std::ptrdiff_t>(max_token_bytes);
      if (fits && is_csv_comment(text)) continue;
      if (!take_header(row, end)) return error();
      return std::nullopt;
    }
  }
  Picoseconds sample_period() const override { return layout_.rows.sample_period; }

 private:
  void parse() override {
    const char* row = window_.begin();
    const char* const end = window_.end();
    while (row != end && !block_.full()) {
      const char* const row_end = find_or_end(row, end, '\n');
      if (!read_row(row, row_end)) return;
      row = row_end + 1;
    }
    window_.advance(row);
  }

  void finish_text() override {}
  bool choose_pair(wire::LineIndex ma, wire::LineIndex slo) override {
    ma_ = ma;
    slo_ = slo;
    return ma != slo;
  }

  std::unique_ptr<TextPiece> new_piece() const override {
    return std::make_unique<EventCsvPiece>(layout_, ma_, slo_);
  }

  bool take_over(TextPiece& text) override {
    const auto& piece = static_cast<EventCsvPiece&>(text);
    if (!piece.timed) return true;
    if (any_row_ && (piece.first_time < row_time_.count ||
                     is_hole(row_time_.count, piece.first_time, layout_.rows) ||
                     is_short(row_time_.count, piece.first_time, layout_.rows))) {
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

  bool stop(const char* place, CaptureCause cause, const char* expected = nullptr) {
    fail(window_.error_at(place, cause, expected));
    return false;
  }

  // `cut`: the fault may exist only because the text was cut off here.
  bool stop_in_row(const char* place, const char* expected, bool cut) {
    const bool truncated = cut && window_.unterminated();
    return stop(place, truncated ? CaptureCause::truncated : CaptureCause::malformed, expected);
  }

  // Cells may be quoted, blanks around them do not count. The separator is a tab or a semicolon if
  // there is one outside quotes, else a comma.
  bool take_header(const char* row, const char* end) {
    std::string_view rest = text_between(row, end);
    if (rest.size() > max_token_bytes || has_cr_inside(rest)) {
      return stop(row, CaptureCause::token_too_long);
    }
    const bool cut = looks_like_event_csv(rest);
    const char separator = layout_.separator = find_separator(rest);
    bool last = false;
    const auto scale = event_csv_time_scale(unquote(take_cell(rest, separator, last)));
    if (!scale) {
      return stop_in_row(row, "a header such as time_ns,MA,SLO with s, ms, us, ns or ps", cut);
    }
    layout_.scale = *scale;
    std::vector<std::string> lines;
    while (!last) {
      const char* const cell = rest.data();
      lines.push_back(unquote(take_cell(rest, separator, last)));
      if (lines.back().empty()) {
        return stop_in_row(cell, "the name of a line in every column", cut);
      }
    }
    if (lines.empty())
      return stop_in_row(rest.data(), "a column for each line after the time", cut);
    layout_.columns = lines.size();
    row_levels_.assign(lines.size(), unchanged_cell);
    last_levels_.assign(lines.size(), no_level);
    set_lines(std::move(lines));
    return true;
  }

  bool read_row(const char* row, const char* end) {
    if (end - row > static_cast<std::ptrdiff_t>(max_token_bytes)) {
      return stop(row, CaptureCause::token_too_long);
    }
    if (is_csv_comment(text_between(row, end))) return true;
    const char* const time_end = find_or_end(row, end, layout_.separator);
    if (!read_time(row, time_end, end)) return false;
    if (time_end == end) return stop_in_row(end, "a level for every line", true);
    if (!read_levels(time_end + 1, end)) return false;
    commit();
    return true;
  }

  bool read_time(const char* cell, const char* cell_end, const char* end) {
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
    if (any_row_ && is_short(row_time_.count, *time, layout_.rows)) {
      return stop(cell, CaptureCause::malformed,
                  "samples at the constant step of the first rows, or a row for each change only");
    }
    row_time_ = Picoseconds{*time};
    any_row_ = true;
    return true;
  }

  bool read_levels(const char* cell, const char* end) {
    for (std::size_t line = 0; line < row_levels_.size(); ++line) {
      const char* cell_end = cell;
      // The common cell is one character; memchr would cost more than it saves.
      while (cell_end != end && *cell_end != layout_.separator) ++cell_end;
      const std::uint8_t level = event_csv_level(text_between(cell, cell_end), layout_);
      if (level == wrong_cell) {
        return stop_in_row(
            cell,
            "a level: 0 and 1, or two other numbers, x, z or nothing; voltages need a "
            "constant step",
            false);
      }
      row_levels_[line] = level;
      const bool last = line + 1 == row_levels_.size();
      if (last && cell_end != end)
        return stop_in_row(cell_end, "no more columns than names", false);
      if (cell_end == end && (!last || (level == unchanged_cell && window_.unterminated()))) {
        return stop_in_row(end, "a level for every line", true);
      }
      cell = cell_end + 1;
    }
    return true;
  }

  void commit() {
    constexpr auto unknown = static_cast<std::uint8_t>(Level::unknown);
    const bool hole =
        row_time_ > end_time_ && is_hole(end_time_.count, row_time_.count, layout_.rows);
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

  EventCsvLayout layout_;
  wire::LineIndex ma_ = 0;
  wire::LineIndex slo_ = 0;
  Picoseconds row_time_;
  bool any_row_ = false;
  std::vector<std::uint8_t> row_levels_;
  std::vector<std::uint8_t> last_levels_;
};

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

Opened open_event_csv(std::unique_ptr<ByteSource> bytes, std::size_t piece_limit,
                      const EventCsvRows& rows) {
  auto reader = std::make_unique<EventCsvReader>(std::move(bytes), piece_limit, rows);
  if (const auto error = reader->open()) return tl::unexpected(*error);
  return reader;
}

namespace {

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
