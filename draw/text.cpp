#include "draw/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
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
// The longest request has some 700 clocks; what is longer is no request.
constexpr std::int64_t columns_max = 8192;

// A row of text by columns: each cell is one character.
class Row {
 public:
  explicit Row(std::size_t columns) : cells_(columns, " ") {}

  void put(std::size_t column, std::string_view character) {
    if (column < cells_.size()) cells_[column] = character;
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

class Renderer {
 public:
  explicit Renderer(const CycleDrawing& drawing) : drawing_(drawing) {
    std::size_t longest = 0;
    for (const DrawnBit& bit : drawing.bits) longest = std::max(longest, bit.name.size());
    // Even, so that a level of half a period has a whole number.
    clock_columns_ = std::max(clock_columns_min, (longest + 2) / 2 * 2);
    const auto clock_columns = static_cast<std::int64_t>(clock_columns_);
    step_ = drawing.cycle.period.value_or(microseconds(1)) / clock_columns;
    step_ = std::max(step_, picoseconds(1));
    begin_ = decode::shifted(drawing.cycle.time, -clock_columns / 2 * step_);
    const std::int64_t wanted =
        decode::elapsed(begin_, std::max(begin_, drawing.end)).count / step_.count + 1;
    columns_ = static_cast<std::size_t>(std::min(wanted, columns_max));
    columns_ = std::min(columns_, last_event() + clock_columns_ / 2 + 1);
  }

  std::string run(std::size_t width) {
    Row sample(columns_);
    Words clock;
    Words bit;
    Words field;
    Words expected;
    for (const DrawnBit& drawn : drawing_.bits) {
      clock.put(column_of(drawn.time), std::to_string(drawn.clock));
      if (!drawn.sampled_at) continue;
      const std::size_t at = column_of(*drawn.sampled_at);
      sample.put(at, "▲");
      bit.put(at, !drawn.level ? "x" : *drawn.level ? "1" : "0");
      field.put(at, drawn.name);
      if (drawn.expected && drawn.level && *drawn.expected != *drawn.level) {
        expected.put(at, *drawn.expected ? "1!" : "0!");
      }
    }
    const auto ma = wave(drawing_.ma, drawing_.ma_before);
    const auto slo = wave(drawing_.slo, drawing_.slo_before);
    std::string out;
    const std::size_t room = std::max(width, drawing_columns_min) - label_columns - 3;
    // Whole clocks in each block.
    const std::size_t block = room / clock_columns_ * clock_columns_;
    for (std::size_t first = 0; first < columns_; first += block) {
      if (first != 0) out += '\n';
      const auto line = [&](std::string_view label, const auto& row, bool always) {
        const std::string text = row.text(first, first + block);
        if (text.empty() && !always) return;
        std::string padded(label);
        padded.resize(label_columns, ' ');
        padded += text;
        out += padded.substr(0, padded.find_last_not_of(' ') + 1) + '\n';
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
    }
    return out;
  }

 private:
  std::size_t column_of(Picoseconds time) const {
    if (time <= begin_) return 0;
    return static_cast<std::size_t>(decode::elapsed(begin_, time).count / step_.count);
  }

  // Nothing changes and nothing is sampled after this column.
  std::size_t last_event() const {
    std::size_t last = 0;
    if (!drawing_.ma.empty()) last = std::max(last, column_of(drawing_.ma.back().time));
    if (!drawing_.slo.empty()) last = std::max(last, column_of(drawing_.slo.back().time));
    for (const DrawnBit& bit : drawing_.bits) {
      if (bit.sampled_at) last = std::max(last, column_of(*bit.sampled_at));
    }
    return last;
  }

  // The upper and the lower half of a line.
  std::array<Row, 2> wave(const std::vector<LevelChange>& changes, Level level) const {
    std::array<Row, 2> rows{Row(columns_), Row(columns_)};
    std::size_t next = 0;
    for (std::size_t column = 0; column < columns_; ++column) {
      const Level before = level;
      std::size_t count = 0;
      for (; next < changes.size() && column_of(changes[next].time) <= column; ++next) {
        level = changes[next].level;
        ++count;
      }
      put_wave(rows, column, before, level, count);
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

  const CycleDrawing& drawing_;
  Picoseconds step_{};
  Picoseconds begin_{};
  std::size_t clock_columns_ = clock_columns_min;
  std::size_t columns_ = 0;
};

// One line for each, the label before the first.
std::string flips_text(const CycleDrawing& drawing, std::string_view label,
                       const std::vector<Flips>& all) {
  std::string text;
  for (const Flips& flips : all) {
    fmt::format_to(std::back_inserter(text), "  {:<20}", text.empty() ? label : "");
    for (std::size_t i = 0; i < flips.size(); ++i) {
      fmt::format_to(std::back_inserter(text), "{}{} (bit {})", i == 0 ? "" : " with ",
                     drawing.name_of(flips[i]), flips[i]);
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
                                : flips_text(drawing, "a flip that mends it", check.singles);
  text += flips_text(
      drawing, fmt::format("{} pair{} would", check.pair_count, check.pair_count == 1 ? "" : "s"),
      check.pairs);
  if (check.pair_count > check.pairs.size()) text += fmt::format("  {:<20}…\n", "");
  return text;
}

}  // namespace

std::string drawing_text(const CycleDrawing& drawing, std::size_t columns) {
  std::string text = Renderer(drawing).run(columns);
  if (!drawing.checks.empty()) text += '\n';
  for (const DrawnCheck& check : drawing.checks) text += check_text(drawing, check);
  return text;
}

}  // namespace biss::draw
