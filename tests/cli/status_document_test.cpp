// docs/status.md has every status with its words, docs/axis.md every cause and step of an axis, and
// no others.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "biss/axis/cause.hpp"
#include "biss/frame/status.hpp"
#include "device/words.hpp"

namespace biss::verbs::status_document_test {

// The rows of this document that begin with a name, after the line `head`.
std::string rows_of(const std::string& name, const std::string& head = {}) {
  std::ifstream document(BISS_SOURCE_FOLDER "/docs/" + name);
  std::string rows;
  bool inside = head.empty();
  for (std::string line; std::getline(document, line);) {
    if (!head.empty() && line.starts_with("#")) inside = line == head;
    if (inside && line.starts_with("| `")) rows += line + "\n";
  }
  return rows;
}

TEST(StatusDocument, EveryStatus_HasItsRowWithItsWordsInOrder) {
  std::string wanted;
  for (std::size_t i = 0; i < cycle_status_count; ++i) {
    const auto status = static_cast<CycleStatus>(i);
    wanted += fmt::format("| `{}` | {} |\n", name_of(status), words_of(status).seen);
  }
  EXPECT_EQ(rows_of("status.md"), wanted);
}

TEST(AxisDocument, EveryStepOfAnAxis_IsInTheTable) {
  std::string wanted;
  for (std::size_t i = 0; i < axis_state_names.size(); ++i) {
    wanted += fmt::format("| `{}` |", axis_state_names[i]);
    for (const AxisState next : axis_states[i]) wanted += fmt::format(" {} |", name_of(next));
    wanted += "\n";
  }
  EXPECT_EQ(rows_of("axis.md", "## States"), wanted);
}

TEST(AxisDocument, EveryCause_HasItsRowInOrder) {
  std::string names;
  std::istringstream rows(rows_of("axis.md", "## Causes"));
  for (std::string row; std::getline(rows, row);) names += row.substr(2, row.find(" |") - 2) + "\n";
  std::string wanted;
  for (std::size_t i = 0; i < axis_cause_count; ++i) {
    wanted += fmt::format("`{}`\n", name_of(static_cast<AxisCause>(i)));
  }
  EXPECT_EQ(names, wanted);
}

}  // namespace biss::verbs::status_document_test
