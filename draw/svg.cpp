#include "draw/svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

namespace biss::draw {

namespace {

using decode::LevelChange;
using wire::Level;

// Pixels.
constexpr std::size_t margin = 12;
constexpr std::size_t gutter = 56;
constexpr std::size_t clock_pixels_min = 18;
constexpr std::size_t clock_pixels_max = 36;
constexpr std::size_t wave_height = 22;
constexpr std::size_t box_height = 20;
constexpr std::size_t text_height = 14;
constexpr std::size_t wave_distance = 10;
// A character of the title.
constexpr std::size_t title_tenths = 79;

// A label of the monospaced font, and a little space on both sides.
std::size_t label_pixels(std::size_t characters) { return (characters * 66 + 9) / 10 + 6; }

constexpr std::string_view style =
    "text{font:11px ui-monospace,SFMono-Regular,Menlo,Consolas,'DejaVu Sans Mono',monospace;"
    "fill:#1f2328}\n"
    ".paper{fill:#fff}\n"
    ".title{font-size:13px;font-weight:bold}\n"
    ".name{font-weight:bold}\n"
    ".mid{text-anchor:middle}\n"
    ".soft{fill:#59636e}\n"
    ".small{font-size:9px}\n"
    ".bad{fill:#c4141f;font-weight:bold}\n"
    ".wave{fill:none;stroke:#1f2328;stroke-width:1.5}\n"
    ".slo{stroke:#0757c8}\n"
    ".grid{fill:none;stroke:#9aa4af;stroke-width:1}\n"
    ".point{fill:#0757c8}\n"
    ".fail{fill:#c4141f}\n"
    ".box{stroke:#59636e;stroke-width:1;fill:#818b98;fill-opacity:.14}\n"
    ".line{fill:none;stroke-dasharray:3 2}\n"
    ".data{fill:#0757c8;fill-opacity:.16}\n"
    ".flag{fill:#bf8700;fill-opacity:.22}\n"
    ".crc{fill:#1a7f37;fill-opacity:.18}\n"
    ".wrong{stroke:#c4141f;stroke-width:2;fill:#c4141f;fill-opacity:.2}\n"
    "@media (prefers-color-scheme:dark){\n"
    "text{fill:#e6edf3}\n"
    ".paper{fill:#0d1117}\n"
    ".soft{fill:#9aa4af}\n"
    ".bad,.fail{fill:#ff7b72}\n"
    ".wave{stroke:#e6edf3}\n"
    ".slo{stroke:#79c0ff}\n"
    ".point{fill:#79c0ff}\n"
    ".grid{stroke:#59636e}\n"
    ".box{stroke:#9aa4af;fill-opacity:.3}\n"
    ".line{fill:none}\n"
    ".wrong{stroke:#ff7b72;fill-opacity:.4}\n"
    "}\n";

std::string_view class_of(PartKind kind) {
  constexpr std::string_view classes[] = {"box line", "box", "box data", "box flag", "box crc"};
  return classes[static_cast<std::size_t>(kind)];
}

std::size_t cut_clocks_of(const Layout& layout, std::size_t clock_pixels) {
  std::size_t widest = 0;
  for (const std::string& text : layout.cut_texts) widest = std::max(widest, text.size());
  return (label_pixels(widest) + clock_pixels - 1) / clock_pixels;
}

Axis axis_of(const Layout& layout, std::size_t clock_pixels) {
  return {layout.drawing, layout.cuts, clock_pixels, cut_clocks_of(layout, clock_pixels)};
}

// The widest clocks that do not need more rows.
std::size_t clock_pixels_of(const Layout& layout, std::size_t room) {
  const auto rows_with = [&](std::size_t pixels) {
    const std::size_t row = room / pixels * pixels;
    return (axis_of(layout, pixels).ticks() + row - 1) / row;
  };
  const std::size_t rows = rows_with(clock_pixels_min);
  std::size_t pixels = clock_pixels_max;
  while (pixels > clock_pixels_min && rows_with(pixels) > rows) pixels -= 2;
  return pixels;
}

// A panel, drawn from `top` downwards.
class PanelWriter {
 public:
  PanelWriter(const Panel& panel, std::size_t width, std::size_t top, std::string& out)
      : panel_(panel),
        layout_(panel.layout),
        drawing_(panel.layout.drawing),
        axis_(axis_of(layout_, clock_pixels_of(layout_, width - gutter - 2 * margin))),
        room_(width - gutter - 2 * margin),
        y_(top),
        out_(out) {}

  /// \return the place at which the next panel begins
  std::size_t write() {
    y_ += margin;
    put_title();
    const std::size_t row = room_ / axis_.clock_ticks() * axis_.clock_ticks();
    for (first_ = 0; first_ == 0 || first_ < axis_.ticks(); first_ += row) {
      last_ = std::min(first_ + row, axis_.ticks());
      write_row();
    }
    if (axis_.truncated()) {
      y_ += text_height;
      put_text(margin, y_, "soft", "The rest of this cycle is not drawn: it has too many clocks.");
    }
    return y_;
  }

 private:
  static constexpr std::size_t left = margin + gutter;

  template <class... Arguments>
  void put(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    out_ += fmt::format(format, std::forward<Arguments>(arguments)...);
    out_ += '\n';
  }
  // \param y of the base line
  void put_text(std::size_t x, std::size_t y, std::string_view kind, std::string_view text) {
    put("<text x=\"{}\" y=\"{}\"{}>{}</text>", x, y,
        kind.empty() ? "" : fmt::format(" class=\"{}\"", kind), markup_text(text));
  }
  // In lines, broken between words.
  void put_title() {
    const std::size_t most = (room_ + gutter) * 10 / title_tenths;
    std::string_view rest = panel_.title;
    while (!rest.empty()) {
      std::size_t length = rest.size();
      if (length > most) {
        const std::size_t space = rest.rfind(' ', most);
        length = space == std::string_view::npos || space == 0 ? most : space;
      }
      y_ += text_height + 2;
      put_text(margin, y_, "title", rest.substr(0, length));
      rest.remove_prefix(length);
      rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
    }
  }
  bool in_row(std::size_t tick) const { return tick >= first_ && tick < last_; }
  std::size_t x_of(std::size_t tick) const { return left + tick - first_; }

  void write_row() {
    y_ += text_height + 4;
    put_clocks();
    y_ += 6;
    put_cut_texts();
    put_wave("MA", "wave", drawing_.ma, drawing_.ma_before);
    y_ += wave_height + wave_distance;
    const std::size_t slo_top = y_;
    put_wave("SLO", "wave slo", drawing_.slo, drawing_.slo_before);
    y_ += wave_height;
    put_bits(slo_top);
    for (const Track& track : layout_.tracks) put_track(track);
    for (const Mark& failure : layout_.failures) put_failure(failure);
    y_ += margin / 2;
  }

  void put_clocks() {
    std::size_t free = 0;
    for (const DrawnBit& bit : drawing_.bits) {
      const std::size_t tick = axis_.at(bit.time);
      const std::string text = std::to_string(bit.clock);
      const std::size_t half = text.size() * 3 + 1;
      if (!axis_.shows(bit.time) || !in_row(tick) || x_of(tick) < free + half) continue;
      put_text(x_of(tick), y_, "soft small mid", text);
      free = x_of(tick) + half;
    }
  }

  // In the middle of both lines.
  void put_cut_texts() {
    const std::size_t y = y_ + wave_height + wave_distance / 2 + 4;
    for (std::size_t cut = 0; cut < layout_.cuts.size() && !axis_.truncated(); ++cut) {
      const std::size_t tick = axis_.cut_at(cut) + axis_.cut_ticks() / 2;
      if (in_row(tick)) put_text(x_of(tick), y, "soft mid", layout_.cut_texts[cut]);
    }
  }

  // A path from one cut to the next, with two slanted strokes at each end.
  void put_wave(std::string_view name, std::string_view kind,
                const std::vector<LevelChange>& changes, Level level) {
    put_text(margin, y_ + wave_height / 2 + 4, "name", name);
    std::string path;
    std::size_t next = 0;
    // The levels before this row, and in the cuts.
    const auto pass = [&](std::size_t tick) {
      for (; next < changes.size() && axis_.at(changes[next].time) < tick; ++next) {
        level = changes[next].level;
      }
    };
    pass(first_);
    std::size_t from = first_;
    for (std::size_t cut = 0; cut <= layout_.cuts.size(); ++cut) {
      const bool is_cut = cut < layout_.cuts.size() && !axis_.truncated();
      const std::size_t to = is_cut ? std::min(axis_.cut_at(cut), last_) : last_;
      if (from < to) {
        add_stretch(path, changes, next, level, from, to);
        if (is_cut && to < last_) put_break(x_of(to));
      }
      if (!is_cut || to == last_) break;
      // An event within the cut is drawn at its beginning.
      pass(to + axis_.cut_ticks());
      from = std::max(first_, to + axis_.cut_ticks());
      if (from < last_ && from > first_) put_break(x_of(from));
    }
    put("<path class=\"{}\" d=\"{}\"/>", kind, path);
  }

  void put_break(std::size_t x) {
    put("<path class=\"grid\" d=\"M{} {}l6 -{}\"/>", x - 3, y_ + wave_height / 2 + 8, 16);
  }

  std::size_t level_y(Level level) const {
    return level == Level::high  ? y_
           : level == Level::low ? y_ + wave_height
                                 : y_ + wave_height / 2;
  }

  void add_stretch(std::string& path, const std::vector<LevelChange>& changes, std::size_t& next,
                   Level& level, std::size_t from, std::size_t to) const {
    path += fmt::format("M{} {}", x_of(from), level_y(level));
    std::size_t at = from;
    std::size_t strokes = 0;
    for (; next < changes.size() && axis_.at(changes[next].time) < to; ++next) {
      const std::size_t tick = axis_.at(changes[next].time);
      if (tick != at) path += fmt::format("H{}", x_of(tick));
      // Pulses within a pixel are one stroke up and down, however many there are.
      strokes = tick == at ? strokes + 1 : 0;
      at = tick;
      level = changes[next].level;
      if (strokes < 3) path += fmt::format("V{}", level_y(level));
    }
    if (strokes >= 3) path += fmt::format("V{}", level_y(level));
    path += fmt::format("H{}", x_of(to));
  }

  void put_bits(std::size_t slo_top) {
    std::vector<std::pair<std::size_t, const DrawnBit*>> shown;  // with its x
    for (const DrawnBit& bit : drawing_.bits) {
      if (!bit.sampled_at || !axis_.shows(*bit.sampled_at)) continue;
      const std::size_t tick = axis_.at(*bit.sampled_at);
      if (in_row(tick)) shown.emplace_back(x_of(tick), &bit);
    }
    y_ += 6;
    if (shown.empty()) return;
    y_ += text_height;
    std::string grid;
    std::string points;
    for (const auto& [x, bit] : shown) {
      const std::size_t below_high = !bit->level ? wave_height / 2 : *bit->level ? 0 : wave_height;
      grid += fmt::format("M{} {}V{}", x, slo_top + below_high + 4, y_ - 10);
      points += fmt::format("M{} {}l4 4l-4 4l-4 -4z", x, slo_top + below_high - 4);
    }
    put("<path class=\"grid\" stroke-dasharray=\"1 2\" d=\"{}\"/>", grid);
    put("<path class=\"point\" d=\"{}\"/>", points);
    bool wrong = false;
    for (const auto& [x, bit] : shown) {
      const bool differs = bit->expected && bit->level && *bit->expected != *bit->level;
      put_text(x, y_, differs ? "bad mid" : "mid", !bit->level ? "x" : *bit->level ? "1" : "0");
      if (differs) put_text(x, y_ + text_height, "soft mid", *bit->expected ? "1" : "0");
      wrong = wrong || differs;
    }
    put_text(margin, y_, "soft", "bit");
    if (!wrong) return;
    y_ += text_height;
    put_text(margin, y_, "soft", "expected");
  }

  void put_track(const Track& track) {
    const std::vector<Piece> pieces = pieces_of(track, axis_, first_, last_);
    if (pieces.empty()) return;
    const std::size_t top = y_ + 8;
    for (const Piece& piece : pieces) {
      put("<rect class=\"{}{}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>",
          class_of(piece.part->kind), piece.part->wrong ? " wrong" : "", left + piece.begin, top,
          piece.end - piece.begin, box_height);
    }
    std::size_t lines = 0;
    for (const Label& label : labels_of(pieces, label_pixels, room_)) {
      lines = std::max(lines, label.line);
      if (label.line == 0) {
        put_text(left + (label.part_begin + label.part_end) / 2, top + 14, "mid", label.text);
        continue;
      }
      const std::size_t y = top + box_height + label.line * text_height;
      const std::size_t stroke = left + label.part_begin + 1;
      // A label that ends with the row is below its stroke, and not next to it.
      const bool beside = label.begin == label.part_begin;
      put("<path class=\"grid\" d=\"M{} {}V{}\"/>", stroke, top + box_height, beside ? y : y - 9);
      put_text(left + label.begin + 4, y, "", label.text);
    }
    put_text(margin, top + 14, "soft", track.name);
    y_ = top + box_height + lines * text_height;
  }

  void put_failure(const Mark& failure) {
    const std::size_t tick = std::min(axis_.at(failure.time), axis_.ticks() - 1);
    if (!in_row(tick)) return;
    y_ += text_height + 4;
    const std::size_t x = x_of(tick);
    put("<path class=\"fail\" d=\"M{} {}l5 9h-10z\"/>", x, y_ - 10);
    put_text(margin, y_, "soft", "failure");
    const std::size_t width = label_pixels(failure.text.size());
    const bool fits = x + 8 + width <= left + room_;
    const bool fits_before = x >= left + 8 + width;
    const std::size_t text_x = fits          ? x + 9
                               : fits_before ? x - 2 - width
                                             : left + room_ - std::min(room_, width);
    put_text(text_x, y_, "bad", failure.text);
  }

  const Panel& panel_;
  const Layout& layout_;
  const CycleDrawing& drawing_;
  Axis axis_;
  std::size_t room_;
  std::size_t y_;
  std::size_t first_ = 0;
  std::size_t last_ = 0;
  std::string& out_;
};

// A description in words, for readers who cannot see the picture.
std::string description_of(const Panel& panel) {
  std::string text = panel.title + '.';
  for (const Track& track : panel.layout.tracks) {
    text += ' ' + track.name + ':';
    for (const Part& part : track.parts)
      text += (&part == &track.parts[0] ? " " : "; ") + part.text;
    text += '.';
  }
  for (const Mark& failure : panel.layout.failures) text += " Failure: " + failure.text + '.';
  return text;
}

std::string title_of(std::span<const Panel> panels) {
  if (panels.size() == 1) return panels.front().title;
  return fmt::format("{} request cycles, from {} on", panels.size(),
                     panels.empty() ? 0 : panels.front().layout.drawing.number);
}

}  // namespace

std::string markup_text(std::string_view text) {
  constexpr std::string_view special = "&<>\"\n\r";
  constexpr std::string_view escaped[] = {"&amp;", "&lt;", "&gt;", "&quot;", "&#10;", "&#13;"};
  std::string out;
  for (const char character : text) {
    const std::size_t at = special.find(character);
    at == std::string_view::npos ? out += character : out += escaped[at];
  }
  return out;
}

std::string svg_text(std::span<const Panel> panels, std::size_t width) {
  std::string body;
  std::string description;
  std::size_t height = 0;
  for (const Panel& panel : panels) {
    height = PanelWriter(panel, width, height, body).write();
    description += (description.empty() ? "" : " ") + description_of(panel);
  }
  height += margin;
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\" role=\"img\" aria-labelledby=\"title description\">\n"
      "<title id=\"title\">{2}</title>\n<desc id=\"description\">{3}</desc>\n"
      "<style>\n{4}</style>\n"
      "<rect class=\"paper\" width=\"{0}\" height=\"{1}\" rx=\"6\"/>\n{5}</svg>\n",
      width, height, markup_text(title_of(panels)), markup_text(description), style, body);
}

}  // namespace biss::draw
