// A thousand captures of other protocols and five hundred of BiSS C; docs/identify.md has the table.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <string>

#include "tests/other_lines/score.hpp"

namespace biss::other_lines {
namespace confusion_test {

using identify::Protocol;

class Confusion : public testing::TestWithParam<std::uint64_t> {};

TEST_P(Confusion, OtherProtocols_AreNamedAndNeverTakenForBissC) {
  const Score result = score(GetParam(), 1000, 500);
  RecordProperty("seed", fmt::format("{}", GetParam()));
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
}

// 1 was used to find the rules, 1001 was not.
INSTANTIATE_TEST_SUITE_P(Seeds, Confusion, testing::Values(1, 1001));

TEST(ConfusionTable, Document_IsUpToDate) {
  std::ifstream file(BISS_IDENTIFY_DOCUMENT);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(text.find(table_of(score(1001, 1000, 500))), std::string::npos)
      << "run `make identify-tables`";
}

}  // namespace confusion_test
}  // namespace biss::other_lines
