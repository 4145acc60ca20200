// docs/guide-firmware.md has the mistakes of tests/core/mistakes.hpp and the figures of
// docs/firmware.md, and no others.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "tests/core/mistakes.hpp"

namespace biss::verbs::guide_document_test {

std::vector<std::string> lines_of(const std::string& name) {
  std::ifstream file(BISS_SOURCE_FOLDER "/" + name);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

// The cells of a row of a table; none for another line.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::size_t from = 2;
  for (std::size_t to = 0; line.starts_with("| ") && (to = line.find(" |", from)) != line.npos;) {
    cells.push_back(line.substr(from, to - from));
    from = to + 3;
  }
  return cells;
}

TEST(GuideDocument, EveryMistake_HasItsRowWithItsResultInOrder) {
  std::string rows;
  bool inside = false;
  for (const std::string& line : lines_of("docs/guide-firmware.md")) {
    if (line.starts_with("#")) inside = line == "## Mistakes";
    const auto cells = cells_of(line);
    if (!inside || cells.size() != 3 || cells[0] == "mistake") continue;
    EXPECT_FALSE(cells[2].empty()) << line;
    rows += fmt::format("| {} | {} |\n", cells[0], cells[1]);
  }
  std::string wanted;
  for (const mistakes::Mistake& mistake : mistakes::list) {
    const char* const format = !mistake.compiles()      ? "| {} | does not compile: `{}` |\n"
                               : mistake.result.empty() ? "| {} | not detected |\n"
                                                        : "| {} | `{}` |\n";
    wanted += fmt::format(fmt::runtime(format), mistake.name, mistake.result);
  }
  EXPECT_EQ(rows, wanted);
}

TEST(GuideDocument, EveryMistakeThatDoesNotCompile_IsTriedInOrder) {
  std::string tried;
  for (const std::string& line : lines_of("tests/core/wrong_mistakes.cpp")) {
    if (line.starts_with("// Mistake: ")) tried += line.substr(12) + ": ";
    if (line.starts_with("// says: ")) tried += line.substr(9) + "\n";
  }
  std::string wanted;
  for (const mistakes::Mistake& mistake : mistakes::list) {
    if (!mistake.compiles()) wanted += fmt::format("{}: {}\n", mistake.name, mistake.result);
  }
  EXPECT_EQ(tried, wanted);
}

// The number of a cell `A + B`, from 0.
std::string part(const std::string& cell, std::size_t number) {
  const std::size_t plus = cell.find(" + ");
  return number == 0 ? cell.substr(0, plus) : cell.substr(plus + 3);
}

TEST(GuideDocument, Bounds_AreThoseOfTheMeasurement) {
  const auto measured = lines_of("docs/firmware.md");
  unsigned rows = 0;
  bool inside = false;
  for (const std::string& line : lines_of("docs/guide-firmware.md")) {
    if (line == "<!-- firmware-bounds -->") inside = !inside;
    const auto cells = cells_of(line);
    if (!inside || cells.size() != 5 || cells[0].starts_with("Cortex")) continue;
    ++rows;
    std::vector<std::vector<std::string>> both;
    for (const std::string& row : measured) {
      if (row.starts_with("| " + cells[0] + " | ")) both.push_back(cells_of(row));
    }
    ASSERT_EQ(both.size(), 2U) << line;
    const auto& m4 = both[0];
    const auto& m0 = both[1];
    EXPECT_EQ(cells[1], m4[3] + " / " + m0[3]);
    EXPECT_EQ(cells[2], part(m4[2], 1) + " / " + part(m0[2], 1));
    EXPECT_EQ(cells[3], m4[1] + " / " + m0[1]);
    EXPECT_EQ(cells[4], part(m4[2], 0) + " / " + part(m0[2], 0));
  }
  EXPECT_EQ(rows, 5U);
}

}  // namespace biss::verbs::guide_document_test
