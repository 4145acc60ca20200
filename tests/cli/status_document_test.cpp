// docs/status.md has every status with its words, and no other.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "biss/frame/status.hpp"
#include "device/words.hpp"

namespace biss::verbs::status_document_test {

TEST(StatusDocument, EveryStatus_HasItsRowWithItsWordsInOrder) {
  std::ifstream document(BISS_SOURCE_FOLDER "/docs/status.md");
  ASSERT_TRUE(document);
  std::string rows;
  for (std::string line; std::getline(document, line);) {
    if (line.starts_with("| `")) rows += line + "\n";
  }
  std::string wanted;
  for (std::size_t i = 0; i < cycle_status_count; ++i) {
    const auto status = static_cast<CycleStatus>(i);
    wanted += fmt::format("| `{}` | {} |\n", name_of(status), words_of(status).seen);
  }
  EXPECT_EQ(rows, wanted);
}

}  // namespace biss::verbs::status_document_test
