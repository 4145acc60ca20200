// A thousand captures of other protocols and five hundred of BiSS C; lab/reports/identify.md has the table.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "tests/other_lines/score.hpp"

namespace biss::other_lines::confusion_test {

using identify::Protocol;

// The captures of this seed were not used to find the rules.
TEST(Confusion, OtherProtocols_AreNamedAndNeverTakenForBissCAsTheDocumentSays) {
  const Score result = score(1001, 1000, 500);
  for (const Row& row : result.rows) {
    if (row.protocol == Protocol::biss_c) {
      EXPECT_EQ(row.right(), row.all) << result.wrong;
      EXPECT_GE(row.least_biss, 0.9) << result.wrong;
      continue;
    }
    EXPECT_EQ(row.taken_for_biss, 0U) << row.name << "\n" << result.wrong;
    if (row.protocol == Protocol::noise || row.protocol == Protocol::unknown) continue;
    EXPECT_GE(10 * row.right(), 9 * row.all) << row.name << "\n" << result.wrong;
  }
  std::ifstream file(BISS_IDENTIFY_DOCUMENT);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(text.find(table_of(result)), std::string::npos) << "run `make identify-tables`";
}

}  // namespace biss::other_lines::confusion_test
