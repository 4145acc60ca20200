// The pictures and the document of the timing features.
#include <algorithm>
#include <optional>

#include "tests/timing/feature.hpp"

namespace timing_test {

namespace {

using oracle::Time;

constexpr std::size_t name_width = 7;
constexpr const char* between_pieces = " … ";
constexpr std::size_t between_width = 3;
// Columns of time in a row of a picture: 100 without the names of the line and of a mark.
constexpr std::size_t row_width = 86;

std::string padded(std::string name) {
  name.resize(name_width, ' ');
  return name;
}

std::string wave_of(const std::string& name, const oracle::Line& line,
                    const std::vector<Piece>& pieces) {
  std::string wave = padded(name);
  for (const Piece& piece : pieces) {
    if (&piece != &pieces.front()) wave += between_pieces;
    std::size_t edge = 0;
    for (Time time = piece.from; time < piece.to; time += piece.step) {
      while (edge < line.size() && line[edge].time <= time) ++edge;
      const bool level = edge == 0 || line[edge - 1].level;
      wave += level ? "▔" : "▁";
    }
  }
  return wave + "\n";
}

std::size_t width_of(const Piece& piece) {
  return static_cast<std::size_t>((piece.to - piece.from + piece.step - 1) / piece.step);
}

// The character at which a time is drawn.
std::optional<std::size_t> column_of(Time time, const std::vector<Piece>& pieces) {
  std::size_t column = name_width;
  for (const Piece& piece : pieces) {
    if (time >= piece.from && time < piece.to) {
      return column + static_cast<std::size_t>((time - piece.from) / piece.step);
    }
    column += width_of(piece) + between_width;
  }
  return std::nullopt;
}

// Each name is in the lowest row with room for it, above a mark at its time.
std::string names_of(const std::vector<Mark>& marks, const std::vector<Piece>& pieces) {
  std::vector<std::string> rows;
  std::string strokes;
  for (const Mark& mark : marks) {
    const auto column = column_of(mark.time, pieces);
    if (!column) continue;
    auto row = std::find_if(rows.begin(), rows.end(),
                            [&](const std::string& text) { return text.size() < *column; });
    if (row == rows.end()) row = rows.insert(rows.end(), "");
    row->resize(*column, ' ');
    *row += mark.name;
    strokes.resize(std::max(strokes.size(), *column + 1), ' ');
    strokes[*column] = '|';
  }
  if (rows.empty()) return "";
  std::string text;
  for (auto row = rows.rbegin(); row != rows.rend(); ++row) text += *row + "\n";
  return text + strokes + "\n";
}

// The pieces in rows that fit the page; a piece that is too wide is continued in the next row.
std::vector<std::vector<Piece>> rows_of(const std::vector<Piece>& pieces) {
  std::vector<std::vector<Piece>> rows{{}};
  std::size_t used = 0;
  for (Piece piece : pieces) {
    while (used + between_width + width_of(piece) > row_width) {
      if (used == 0) {
        const Time cut = piece.from + static_cast<Time>(row_width - between_width) * piece.step;
        rows.back().push_back({piece.from, cut, piece.step});
        piece.from = cut;
      }
      rows.emplace_back();
      used = 0;
    }
    rows.back().push_back(piece);
    used += between_width + width_of(piece);
  }
  return rows;
}

std::string picture_of(const Feature& feature) {
  std::string text;
  for (const std::vector<Piece>& row : rows_of(feature.pieces)) {
    if (!text.empty()) text += "\n";
    text += names_of(feature.marks, row) + wave_of("MA", feature.scenario.ma, row);
    for (const auto& [k, slo] : feature.slo) {
      const bool alone = feature.slo.size() == 1;
      text += wave_of(alone ? "SLO" : "SLO " + std::to_string(k), slo, row);
    }
  }
  return text;
}

}  // namespace

std::string document_of(const std::vector<Feature>& features) {
  std::string text =
      "# Timing diagrams of the encoder\n\n"
      "How an encoder answers the edges of MA; each section shows one feature. Each picture is "
      "drawn\n"
      "from a file in `tests/timing/features/` with the times of all edges. The tests compare the\n"
      "encoder of `biss/slave/` and a second, independent reading of the protocol with these "
      "files.\n"
      "`biss_timing_document` writes this page; the pictures are drawn by [biss draw](draw.md)\n"
      "(`make pictures`).\n\n"
      "LAT is the first rising edge of MA, ACK the time in which SLO is low before START.\n";
  for (const Feature& feature : features) {
    const std::string stem = feature.file.substr(0, feature.file.rfind('.'));
    text += "\n## " + feature.heading + "\n" + feature.text + "\n![" + feature.heading +
            "](pictures/" + stem + ".svg)\n\n<details><summary>The same as text</summary>\n\n" +
            "```text\n" + picture_of(feature) + "```\n</details>\n\n`" + feature.file + "`\n";
  }
  return text;
}

}  // namespace timing_test
