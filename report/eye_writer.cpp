// Writes a table in columns for a reader at a terminal.
#include <algorithm>
#include <vector>

#include "report/text.hpp"
#include "report/writers.hpp"

namespace biss::report {
namespace {

constexpr std::string_view gap = "  ";
constexpr std::string_view absent = "-";
constexpr std::string_view dim = "\x1b[2m";
constexpr std::string_view yellow = "\x1b[33m";
constexpr std::string_view plain = "\x1b[0m";

bool right_aligned(const Column& column) {
  return column.kind != Kind::text && column.kind != Kind::bits;
}

void append_shown(std::string& out, const Cell& cell, const Column& column) {
  const std::size_t before = out.size();
  const bool is_time = cell.kind() == Kind::nanoseconds;
  const unsigned shift = column.shift + (is_time ? 3 : 0);
  const unsigned places = column.places.value_or(shift);
  if (is_time) {
    append_fixed(out, magnitude_of(cell.time().count), shift, places);
  } else if (cell.kind() == Kind::unsigned_integer) {
    append_fixed(out, {cell.unsigned_value()}, shift, places);
  } else if (cell.kind() == Kind::signed_integer) {
    append_fixed(out, magnitude_of(cell.signed_value()), shift, places);
  } else if (cell.kind() == Kind::text) {
    append_printable(out, cell.text());
  } else {
    append_plain(out, cell);
  }
  if (out.size() == before) out.append(absent);
}

void trim_end(std::string& out) {
  while (!out.empty() && out.back() == ' ') out.pop_back();
}

// Holds the first rows back to find the widths, then writes each as it comes. A wider cell in a
// later row widens its column from there on: rows stay aligned with their neighbours.
class EyeWriter final : public TableWriter {
 public:
  EyeWriter(std::span<const Column> columns, TextSink& sink, TableOptions options)
      : columns_(columns.begin(), columns.end()), writer_(sink, true), options_(options) {
    for (Column& column : columns_) {
      std::string heading;
      append_printable(heading, column.heading.empty() ? column.name : column.heading);
      column.heading = std::move(heading);
      widths_.push_back(std::max(display_width(column.heading), display_width(column.unit)));
    }
    shown_.assign(columns_.size(), true);
    has_values_.assign(columns_.size(), false);
  }

  bool row(std::span<const Cell> cells) override {
    if (!writer_.good()) return false;
    if (!streaming_ && held_rows() >= options_.rows_measured) release();
    if (streaming_) texts_.resize(columns_.size());
    const std::size_t first = streaming_ ? 0 : texts_.size();
    texts_.resize(first + columns_.size());
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      std::string& text = texts_[first + i];
      text.clear();
      append_shown(text, i < cells.size() ? cells[i] : Cell(), columns_[i]);
      has_values_[i] = has_values_[i] || text != absent;
      widths_[i] = std::max(widths_[i], display_width(text));
    }
    if (streaming_) write_line(texts_);
    return writer_.good();
  }

  bool finish() override {
    if (!streaming_) release();
    return writer_.flush();
  }

 private:
  std::size_t held_rows() const { return columns_.empty() ? 0 : texts_.size() / columns_.size(); }

  void release() {
    if (options_.width != 0) fit();
    write_head();
    const std::size_t rows = held_rows();
    const std::span<const std::string> held(texts_);
    for (std::size_t i = 0; i < rows; ++i) {
      write_line(held.subspan(i * columns_.size(), columns_.size()));
    }
    texts_.clear();
    streaming_ = true;
  }

  std::size_t line_width() const {
    std::size_t width = 0;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (shown_[i]) width += widths_[i] + (width == 0 ? 0 : gap.size());
    }
    return width;
  }

  // Leaves out columns until a line fits.
  void fit() {
    const auto leave_out = [this](auto may_go) {
      for (std::size_t i = columns_.size(); i-- > 1;) {
        if (line_width() <= options_.width) return;
        if (may_go(i)) shown_[i] = false;
      }
    };
    leave_out([this](std::size_t i) { return !has_values_[i]; });
    leave_out([this](std::size_t i) { return columns_[i].kind == Kind::bits; });
    leave_out([](std::size_t) { return true; });
    std::vector<std::string> left_out;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (!shown_[i]) left_out.push_back(columns_[i].heading);
    }
    if (!left_out.empty() && options_.on_left_out) options_.on_left_out(left_out);
  }

  void write_head() {
    writer_.write_line(title_line(&Column::heading));
    const bool units = std::any_of(columns_.begin(), columns_.end(),
                                   [](const Column& column) { return !column.unit.empty(); });
    std::string out;
    if (options_.colour) out.append(dim);
    if (units) out.append(title_line(&Column::unit));
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (!shown_[i]) continue;
      if (i != 0) out.append(gap);
      for (std::size_t n = 0; n < widths_[i]; ++n) out.append("─");
    }
    if (options_.colour) out.append(plain);
    out.push_back('\n');
    writer_.write_line(out);
  }

  std::string title_line(std::string Column::*title) const {
    std::string out;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (!shown_[i]) continue;
      if (i != 0) out.append(gap);
      append_padded(out, columns_[i].*title, widths_[i], right_aligned(columns_[i]));
    }
    trim_end(out);
    out.push_back('\n');
    return out;
  }

  void write_line(std::span<const std::string> texts) {
    std::string& out = line_;
    out.clear();
    for (std::size_t i = 0; i < texts.size(); ++i) {
      if (!shown_[i]) continue;
      if (i != 0) out.append(gap);
      const bool marked = options_.colour && columns_[i].role == Role::status && texts[i] != "ok";
      if (marked) out.append(yellow);
      append_padded(out, texts[i], widths_[i], right_aligned(columns_[i]));
      if (marked) out.append(plain);
    }
    trim_end(out);
    out.push_back('\n');
    writer_.write_line(out);
  }

  std::vector<Column> columns_;
  std::vector<std::size_t> widths_;
  std::vector<bool> shown_;
  std::vector<bool> has_values_;
  std::vector<std::string> texts_;  // all rows while they are held back, later the current row
  std::string line_;
  BlockWriter writer_;
  TableOptions options_;
  bool streaming_ = false;
};

}  // namespace

std::unique_ptr<TableWriter> make_eye_writer(std::span<const Column> columns, TextSink& sink,
                                             TableOptions options) {
  return std::make_unique<EyeWriter>(columns, sink, options);
}

}  // namespace biss::report
