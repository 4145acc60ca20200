// docs/status.md names every status and no other.
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "decode/cycle.hpp"

namespace biss::cli {
namespace status_document_test {

TEST(StatusDocument, EveryStatus_HasItsRowInOrder) {
  std::ifstream document(BISS_SOURCE_FOLDER "/docs/status.md");
  ASSERT_TRUE(document);
  std::vector<std::string> named;
  for (std::string line; std::getline(document, line);) {
    if (!line.starts_with("| `")) continue;
    named.push_back(line.substr(3, line.find('`', 3) - 3));
  }
  std::vector<std::string> statuses;
  for (std::size_t i = 0; i < decode::cycle_status_count; ++i) {
    statuses.emplace_back(name_of(static_cast<decode::CycleStatus>(i)));
  }
  EXPECT_EQ(named, statuses);
}

}  // namespace status_document_test
}  // namespace biss::cli
