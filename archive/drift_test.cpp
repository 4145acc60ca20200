#include "archive/summary.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace biss::archive {
namespace drift_test {

using Values = std::vector<DatedValue>;

TEST(Drift, ValuesOnALine_HaveItsSlope) {
  EXPECT_EQ(change_per_year(Values{{0, 100}, {365, 350}}), 250);
  EXPECT_EQ(change_per_year(Values{{20'000, 500}, {20'073, 400}, {20'146, 300}}), -500);
  EXPECT_EQ(change_per_year(Values{{5, 7}, {6, 7}, {7, 7}}), 0);
}

TEST(Drift, Order_DoesNotMatter) {
  EXPECT_EQ(change_per_year(Values{{9, 3}, {1, 8}, {4, 4}, {4, 9}}),
            change_per_year(Values{{4, 9}, {4, 4}, {9, 3}, {1, 8}}));
}

TEST(Drift, OneDay_HasNone) {
  EXPECT_FALSE(change_per_year({}));
  EXPECT_FALSE(change_per_year(Values{{3, 1}, {3, 9}}));
}

TEST(Drift, LargestValues_DoNotOverflow) {
  const auto most = std::numeric_limits<std::int64_t>::max();
  EXPECT_EQ(change_per_year(Values{{0, 0}, {365, most}}), std::int64_t{1} << 53U);
  EXPECT_EQ(change_per_year(Values{{-100'000, most}, {100'000, most}}), 0);
}

TEST(Drift, Days_HaveTheMedianOfTheirCaptures) {
  std::vector<FileEntry> files(4);
  std::vector<LinkEntry> links(4);
  std::vector<PlacedLink> captures;
  const Day days[] = {11, 10, 11, 11};
  const std::int64_t delays[] = {30, 5, 10, 20};
  for (std::size_t i = 0; i < 4; ++i) {
    files[i].day = days[i];
    links[i].counts.cycles = 100;
    links[i].counts.by_status[static_cast<std::size_t>(CycleStatus::crc)] = i;
    links[i].ranges[static_cast<std::size_t>(Quantity::line_delay)] = {0, delays[i], 99};
    captures.push_back({&files[i], &links[i]});
  }
  const auto rows = days_of(captures);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].day, 10);
  EXPECT_EQ(rows[1].captures, 3U);
  EXPECT_EQ(rows[1].counts.cycles, 300U);
  EXPECT_EQ(rows[1].counts.faults(), 5U);
  EXPECT_EQ(rows[1].medians[static_cast<std::size_t>(Quantity::line_delay)], 20);
  EXPECT_FALSE(rows[1].medians[static_cast<std::size_t>(Quantity::ack)]);
  // 10 000, 0, 20 000 and 30 000 in a million.
  EXPECT_EQ(fault_rates_of(captures)[3].value, 30'000);
}

}  // namespace drift_test
}  // namespace biss::archive
