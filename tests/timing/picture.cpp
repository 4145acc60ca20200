#include <algorithm>
#include <optional>

#include "tests/timing/feature.hpp"

namespace timing_test {

namespace {

using oracle::Time;

constexpr std::size_t name_width = 7;
constexpr const char* between_pieces = " … ";
constexpr std::size_t between_width = 3;

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

// The character that a moment is drawn at.
std::optional<std::size_t> column_of(Time time, const std::vector<Piece>& pieces) {
  std::size_t column = name_width;
  for (const Piece& piece : pieces) {
    if (time >= piece.from && time < piece.to) {
      return column + static_cast<std::size_t>((time - piece.from) / piece.step);
    }
    column += static_cast<std::size_t>((piece.to - piece.from + piece.step - 1) / piece.step) +
              between_width;
  }
  return std::nullopt;
}

// Each name stands on the lowest row that has room, above a stroke where its moment is.
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
  std::string text;
  for (auto row = rows.rbegin(); row != rows.rend(); ++row) text += *row + "\n";
  return text + strokes + "\n";
}

std::string picture_of(const Feature& feature) {
  std::string text = names_of(feature.marks, feature.pieces);
  text += wave_of("MA", feature.scenario.ma, feature.pieces);
  for (const auto& [k, slo] : feature.slo) {
    const bool alone = feature.slo.size() == 1;
    text += wave_of(alone ? "SLO" : "SLO " + std::to_string(k), slo, feature.pieces);
  }
  return text;
}

}  // namespace

std::string document_of(const std::vector<Feature>& features) {
  std::string text =
      "# The slave in time\n\n"
      "What an encoder does with the edges of MA, a feature a section. Each picture is drawn from "
      "a\n"
      "file of `tests/timing/features/`, which holds the times of all edges; the tests put the "
      "same\n"
      "file before the slave of `biss/slave/` and before a second reading of the protocol. "
      "Written\n"
      "by `biss_timing_document`.\n";
  for (const Feature& feature : features) {
    text += "\n## " + feature.heading + "\n" + feature.text + "\n```text\n" + picture_of(feature) +
            "```\n`" + feature.file + "`\n";
  }
  return text;
}

}  // namespace timing_test
