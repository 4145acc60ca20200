#include "draw/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "decode/times.hpp"

namespace biss::draw {

namespace {

using decode::LevelChange;
using wire::Level;

// For a bit and its name, `START` being the longest usual one.
constexpr std::size_t clock_columns_min = 6;
constexpr std::size_t drawing_columns_min = 60;
constexpr std::size_t label_columns = 9;
// The width of a cut, which contains its text.
constexpr std::size_t cut_clocks = 2;

// A row of text by columns: each cell is one character.
class Row {
 public:
  explicit Row(std::size_t columns) : cells_(columns, " ") {}

  void put(std::size_t column, std::string_view character) {
    if (column < cells_.size()) cells_[column] = std::string(character);
  }
  void put_text(std::size_t column, std::string_view text) {
    for (const char character : text) put(column++, std::string_view(&character, 1));
  }
  std::string text(std::size_t first, std::size_t last) const {
    std::string out;
    for (std::size_t i = first; i < std::min(last, cells_.size()); ++i) out += cells_[i];
    return out.substr(0, out.find_last_not_of(' ') + 1);
  }

 private:
  std::vector<std::string> cells_;
};

// A row of words, each centred on a column and never split between blocks.
class Words {
 public:
  // In the order of the columns.
  void put(std::size_t column, std::string text) { words_.emplace_back(column, std::move(text)); }

  std::string text(std::size_t first, std::size_t last) const {
    std::string out;
    for (const auto& [column, word] : words_) {
      if (column < first || column >= last) continue;
      const std::size_t at = column - first;
      const std::size_t begin = at >= word.size() / 2 ? at - word.size() / 2 : 0;
      if (!out.empty() && out.size() >= begin) out += ' ';
      out.resize(std::max(out.size(), begin), ' ');
      out += word;
    }
    return out;
  }

 private:
  std::vector<std::pair<std::size_t, std::string>> words_;
};

// Even, so that a level of half a period has a whole number.
std::size_t clock_columns_of(const CycleDrawing& drawing) {
  std::size_t longest = 0;
  for (const DrawnBit& bit : drawing.bits) longest = std::max(longest, bit.name.size());
  return std::max(clock_columns_min, (longest + 2) / 2 * 2);
}

// A label has a stroke before it.
std::size_t label_width(std::size_t characters) { return characters + 1; }

class Renderer {
 public:
  explicit Renderer(const Layout& layout)
      : layout_(layout),
        drawing_(layout.drawing),
        axis_(drawing_, layout.cuts, clock_columns_of(drawing_), cut_clocks),
        columns_(std::min(axis_.ticks() + 1, last_event() + axis_.clock_ticks() / 2 + 1)) {}

  std::string run(std::size_t width) {
    Row sample(columns_);
    Words clock;
    Words bit;
    Words field;
    Words expected;
    for (const DrawnBit& drawn : drawing_.bits) {
      if (axis_.shows(drawn.time)) clock.put(axis_.at(drawn.time), std::to_string(drawn.clock));
      if (!drawn.sampled_at || !axis_.shows(*drawn.sampled_at)) continue;
      const std::size_t at = axis_.at(*drawn.sampled_at);
      sample.put(at, "▲");
      bit.put(at, !drawn.level ? "x" : *drawn.level ? "1" : "0");
      field.put(at, drawn.name);
      if (drawn.expected && drawn.level && *drawn.expected != *drawn.level) {
        expected.put(at, *drawn.expected ? "1!" : "0!");
      }
    }
    auto ma = wave(drawing_.ma, drawing_.ma_before);
    const auto slo = wave(drawing_.slo, drawing_.slo_before);
    put_cut_texts(ma[0]);
    const std::size_t room = std::max(width, drawing_columns_min) - label_columns - 3;
    // Whole clocks in each block.
    const std::size_t block = room / axis_.clock_ticks() * axis_.clock_ticks();
    for (std::size_t first = 0; first < columns_; first += block) {
      if (first != 0) out_ += '\n';
      const auto line = [&](std::string_view label, const auto& row, bool always) {
        const std::string text = row.text(first, first + block);
        if (!text.empty() || always) put_line(label, text);
      };
      line("clock", clock, false);
      line("MA", ma[0], true);
      line("", ma[1], true);
      line("SLO", slo[0], true);
      line("", slo[1], true);
      line("sample", sample, false);
      line("bit", bit, false);
      line("field", field, false);
      line("expected", expected, false);
      for (const Track& track : layout_.tracks) put_track(track, first, first + block);
      for (const Mark& failure : layout_.failures) put_failure(failure, first, first + block);
    }
    if (axis_.truncated())
      out_ += "\nThe rest of this cycle is not drawn: it has too many clocks.\n";
    return std::move(out_);
  }

 private:
  void put_line(std::string_view label, std::string_view text) {
    std::string padded(label);
    padded.resize(label_columns, ' ');
    padded += text;
    out_ += padded.substr(0, padded.find_last_not_of(' ') + 1) + '\n';
  }

  // Nothing changes and nothing is sampled after this column.
  std::size_t last_event() const {
    std::size_t last = 0;
    if (!drawing_.ma.empty()) last = std::max(last, axis_.at(drawing_.ma.back().time));
    if (!drawing_.slo.empty()) last = std::max(last, axis_.at(drawing_.slo.back().time));
    for (const DrawnBit& bit : drawing_.bits) {
      if (bit.sampled_at) last = std::max(last, axis_.at(*bit.sampled_at));
    }
    return last;
  }

  // How far a column is from the beginning of the cut that it is in.
  std::optional<std::size_t> place_in_cut(std::size_t column) const {
    for (std::size_t cut = 0; cut < layout_.cuts.size() && !axis_.truncated(); ++cut) {
      const std::size_t begin = axis_.cut_at(cut);
      if (column >= begin && column < begin + axis_.cut_ticks()) return column - begin;
    }
    return std::nullopt;
  }

  // The upper and the lower half of a line.
  std::array<Row, 2> wave(const std::vector<LevelChange>& changes, Level level) const {
    std::array<Row, 2> rows{Row(columns_), Row(columns_)};
    std::size_t next = 0;
    for (std::size_t column = 0; column < columns_; ++column) {
      const Level before = level;
      std::size_t count = 0;
      for (; next < changes.size() && axis_.at(changes[next].time) <= column; ++next) {
        level = changes[next].level;
        ++count;
      }
      if (const auto place = place_in_cut(column)) {
        if (*place % 2 == 1) rows[1].put(column, "·");
      } else {
        put_wave(rows, column, before, level, count);
      }
    }
    return rows;
  }

  static void put_wave(std::array<Row, 2>& rows, std::size_t column, Level before, Level after,
                       std::size_t changes) {
    const auto put = [&](std::string_view upper, std::string_view lower) {
      rows[0].put(column, upper);
      rows[1].put(column, lower);
    };
    if (after == Level::unknown || before == Level::unknown) return put("x", "x");
    // More than one change within a column.
    if (changes > 1) return put("╥", "╨");
    if (before == after) return after == Level::high ? put("─", " ") : put(" ", "─");
    after == Level::high ? put("┌", "┘") : put("┐", "└");
  }

  void put_cut_texts(Row& row) const {
    for (std::size_t cut = 0; cut < layout_.cuts.size() && !axis_.truncated(); ++cut) {
      const std::string& text = layout_.cut_texts[cut];
      const std::size_t room = axis_.cut_ticks() - std::min(axis_.cut_ticks(), text.size());
      row.put_text(axis_.cut_at(cut) + room / 2, text);
    }
  }

  // The parts between strokes, and below them the labels that are too long.
  void put_track(const Track& track, std::size_t first, std::size_t last) {
    const std::vector<Piece> pieces = pieces_of(track, axis_, first, std::min(last, columns_));
    if (pieces.empty()) return;
    const std::vector<Label> labels = labels_of(pieces, label_width, last - first);
    std::vector<Row> lines{Row(last - first)};
    for (const Label& label : labels) {
      if (label.line >= lines.size()) lines.resize(label.line + 1, Row(last - first));
    }
    for (const Piece& piece : pieces) {
      if (!piece.continued) lines[0].put(piece.begin, "│");
      if (piece.part->to > piece.part->from) lines[0].put(piece.end, "│");
    }
    for (const Label& label : labels) {
      for (std::size_t line = 1; line < label.line; ++line) lines[line].put(label.part_begin, "│");
      const std::size_t stroke = label.line == 0 ? 1 : 0;
      lines[label.line].put_text(label.begin + stroke, label.text);
    }
    put_line(track.name, lines[0].text(0, last - first));
    for (std::size_t line = 1; line < lines.size(); ++line) {
      put_line("", lines[line].text(0, last - first));
    }
  }

  // The text ends with the block if it is too long for the rest of it.
  void put_failure(const Mark& failure, std::size_t first, std::size_t last) {
    const std::size_t place = std::min(axis_.at(failure.time), columns_ - 1);
    if (place < first || place >= last) return;
    Row row(last - first);
    const std::size_t column = place - first;
    const std::size_t width = failure.text.size() + 2;
    const bool fits_before = column + width > last - first && column >= width;
    if (fits_before) row.put_text(column - width, failure.text);
    row.put(column, "▲");
    put_line("failure", row.text(0, last - first));
    if (fits_before) return;
    const std::size_t room = last - first - std::min(last - first, failure.text.size());
    put_line("", std::string(std::min(column, room), ' ') + failure.text);
  }

  const Layout& layout_;
  const CycleDrawing& drawing_;
  Axis axis_;
  std::size_t columns_ = 0;
  std::string out_;
};

// One line for each, the label before the first.
std::string flips_text(const CycleDrawing& drawing, std::string_view label,
                       const std::vector<Flips>& all) {
  std::string text;
  for (const Flips& flips : all) {
    text += fmt::format("  {:<20}", text.empty() ? label : "");
    for (std::size_t i = 0; i < flips.size(); ++i) {
      text +=
          fmt::format("{}{} (bit {})", i == 0 ? "" : " with ", drawing.name_of(flips[i]), flips[i]);
    }
    text += '\n';
  }
  return text;
}

std::string check_text(const CycleDrawing& drawing, const DrawnCheck& check) {
  std::string text = fmt::format("CRC{} received 0x{:X}, expected 0x{:X}: {}\n",
                                 check.channel == 0 ? "" : fmt::format(" {}", check.channel + 1),
                                 check.received, check.expected, check.right() ? "right" : "wrong");
  if (check.right()) return text;
  text += check.singles.empty() ? "  no flip of one bit mends it\n"
                                : flips_text(drawing, "flip that mends it", check.singles);
  text += flips_text(
      drawing, fmt::format("{} pair{} would", check.pair_count, check.pair_count == 1 ? "" : "s"),
      check.pairs);
  if (check.pair_count > check.pairs.size()) text += fmt::format("  {:<20}…\n", "");
  return text;
}

std::string checks_text(const CycleDrawing& drawing) {
  std::string text;
  if (!drawing.checks.empty()) text += '\n';
  for (const DrawnCheck& check : drawing.checks) text += check_text(drawing, check);
  return text;
}

}  // namespace

std::string drawing_text(const CycleDrawing& drawing, std::size_t columns) {
  const Layout plain{drawing, {}, {}, {}, {}};
  return Renderer(plain).run(columns) + checks_text(drawing);
}

std::string layout_text(const Layout& layout, std::size_t columns) {
  return Renderer(layout).run(columns) + checks_text(layout.drawing);
}

}  // namespace biss::draw
