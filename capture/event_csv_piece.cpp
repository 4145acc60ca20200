#include "capture/event_csv_piece.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "capture/csv_cells.hpp"
#include "capture/text_source.hpp"

namespace biss::capture {
namespace {

using wire::Level;

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

std::uint64_t power_of_ten(std::size_t exponent) {
  std::uint64_t power = 1;
  for (; exponent != 0; --exponent) power *= 10;
  return power;
}

bool is_part_of_number(char c) {
  return std::string_view("0123456789+-.,eE").find(c) != std::string_view::npos;
}

struct EventCsvRow {
  std::int64_t time;
  std::uint8_t ma;
  std::uint8_t slo;
};

/// The shape of a row that the parser has understood: how many digits are where, and what follows
/// the time. A row of the same shape differs in its digits and levels only.
class EventCsvShape {
 public:
  /// Learns the shape of a row, `[row, end)` before its line feed, whose cells are all right.
  /// `time_end` is where its first separator is.
  void learn(const char* row, const char* time_end, const char* end, const EventCsvLayout& layout,
             wire::LineIndex ma_column, wire::LineIndex slo_column);

  /// Reads the row at `row` when the text up to `end` holds one of this shape; else false.
  bool read(const char* row, const char* end, EventCsvRow& out);

  std::size_t row_bytes() const { return row_bytes_; }

 private:
  static constexpr std::size_t words = 8;

  bool learn_time(const char* row, const char* end, const EventCsvLayout& layout);
  bool learn_cells(const char* from, const char* end, const EventCsvLayout& layout,
                   wire::LineIndex ma_column, wire::LineIndex slo_column);
  void keep(std::size_t at, char c, unsigned char mask);

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
  std::size_t tail_words_ = 0;  // what follows the time, as it is where the mask has ones
  std::array<std::uint64_t, words> tail_{};
  std::array<std::uint64_t, words> mask_{};
  std::size_t ma_at_ = 0;  // places in the row
  std::size_t slo_at_ = 0;
};

inline bool EventCsvShape::read(const char* row, const char* end, EventCsvRow& out) {
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
  // Of digits beyond the picosecond, the first decides: halves away from zero.
  const std::uint64_t part =
      divisor_ == 1 ? fraction * factor_ : (fraction + divisor_ / 2) / divisor_;
  const auto time = static_cast<std::int64_t>(whole * unit_ + part);
  out = {negative_ ? -time : time, static_cast<std::uint8_t>(row[ma_at_] - '0'),
         static_cast<std::uint8_t>(row[slo_at_] - '0')};
  return true;
}

void EventCsvShape::keep(std::size_t at, char c, unsigned char mask) {
  const auto byte = static_cast<std::uint64_t>(static_cast<unsigned char>(c) & mask);
  tail_[at / 8] |= byte << (8 * (at % 8));
  mask_[at / 8] |= std::uint64_t{mask} << (8 * (at % 8));
}

bool EventCsvShape::learn_time(const char* row, const char* end, const EventCsvLayout& layout) {
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
  unit_ = power_of_ten(scale);
  whole_limit_ =
      (static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()) - unit_) / unit_;
  factor_ = fraction_digits < scale ? power_of_ten(scale - fraction_digits) : 1;
  divisor_ = fraction_digits > scale ? power_of_ten(fraction_digits - scale) : 1;
  return true;
}

bool EventCsvShape::learn_cells(const char* from, const char* end, const EventCsvLayout& layout,
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
    // In a longer number one digit does not say the level.
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

void EventCsvShape::learn(const char* row, const char* time_end, const char* end,
                          const EventCsvLayout& layout, wire::LineIndex ma_column,
                          wire::LineIndex slo_column) {
  const bool known = learn_time(row, time_end, layout) &&
                     learn_cells(time_end, end, layout, ma_column, slo_column);
  row_bytes_ = known ? static_cast<std::size_t>(end + 1 - row) : 0;
}

/// Reads the rows of a piece. What it does not know ends it.
class EventCsvQuickParser {
 public:
  EventCsvQuickParser(const EventCsvLayout& layout, wire::LineIndex ma_column,
                      wire::LineIndex slo_column, EventCsvPiece& piece)
      : layout_(layout), ma_column_(ma_column), slo_column_(slo_column), piece_(piece) {}

  bool parse();

 private:
  enum class Read : std::uint8_t { row, comment, wrong };

  Read read_row(const char* row, const char* end, EventCsvRow& out);
  bool read_cells(const char* cell, const char* end, EventCsvRow& out) const;
  bool add(const EventCsvRow& row);
  void take_batches();

  EventCsvLayout layout_;
  wire::LineIndex ma_column_;
  wire::LineIndex slo_column_;
  EventCsvPiece& piece_;
  EventCsvShape shape_;
  std::int64_t time_ = std::numeric_limits<std::int64_t>::min();
  ChangeBatch ma_;
  ChangeBatch slo_;
};

void EventCsvQuickParser::take_batches() {
  const auto as_is = [](std::int64_t time) { return time; };
  ma_.take(piece_.ma, as_is);
  slo_.take(piece_.slo, as_is);
}

// False when arrays cannot say it, or time runs backwards.
inline bool EventCsvQuickParser::add(const EventCsvRow& row) {
  constexpr auto unknown = static_cast<std::uint8_t>(Level::unknown);
  if (row.time < time_ || row.ma == unknown || row.slo == unknown) return false;
  if (!piece_.timed) piece_.first_time = time_ = row.time;
  piece_.timed = true;
  if (is_hole(time_, row.time, layout_.rows) || is_short(time_, row.time, layout_.rows)) {
    return false;
  }
  time_ = row.time;
  if (row.ma != unchanged_cell) ma_.add(row.time, row.ma);
  if (row.slo != unchanged_cell) slo_.add(row.time, row.slo);
  if (ma_.full() || slo_.full()) take_batches();
  return true;
}

bool EventCsvQuickParser::read_cells(const char* cell, const char* end, EventCsvRow& out) const {
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

EventCsvQuickParser::Read EventCsvQuickParser::read_row(const char* row, const char* end,
                                                        EventCsvRow& out) {
  if (end - row > static_cast<std::ptrdiff_t>(max_token_bytes)) return Read::wrong;
  if (is_event_csv_comment(text_between(row, end))) return Read::comment;
  const char* const time_end = find_or_end(row, end, layout_.separator);
  if (time_end == end) return Read::wrong;
  const auto time = event_csv_time(text_between(row, time_end), layout_);
  if (!time.ok() || !read_cells(time_end + 1, end, out)) return Read::wrong;
  out.time = *time;
  shape_.learn(row, time_end, end, layout_, ma_column_, slo_column_);
  return Read::row;
}

bool EventCsvQuickParser::parse() {
  const char* row = piece_.begin();
  const char* const end = piece_.end();
  EventCsvRow read{};
  piece_.timed = false;
  for (piece_.line_feeds = 0; row != end; ++piece_.line_feeds) {
    if (shape_.read(row, end, read)) {
      if (!add(read)) return false;
      row += shape_.row_bytes();
      continue;
    }
    const char* const row_end = find_or_end(row, end, '\n');
    const Read what = read_row(row, row_end, read);
    if (what == Read::wrong || (what == Read::row && !add(read))) return false;
    row = row_end + 1;
  }
  take_batches();
  piece_.last_time = time_;
  return true;
}

}  // namespace

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

Result<std::int64_t, DecimalCause> event_csv_time(std::string_view cell,
                                                  const EventCsvLayout& layout) {
  return parse_decimal(without_quotes(trim_cell(cell, layout.separator)), layout.scale,
                       layout.decimal_comma());
}

bool is_event_csv_comment(std::string_view row) {
  if (!row.empty() && row.front() >= '-' && row.front() <= '9') return false;
  row = trim_cell(row, ',');
  return row.empty() || (row.front() == '#' && row.find('\r') == std::string_view::npos);
}

bool EventCsvPiece::quick_parse() {
  return EventCsvQuickParser(layout_, ma_column_, slo_column_, *this).parse();
}

}  // namespace biss::capture
