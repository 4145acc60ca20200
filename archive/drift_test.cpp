#include "archive/summary.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

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
  Summary summary;
  summary.parts.done = {1};
  const Day days[] = {11, 10, 11, 11};
  const std::int64_t delays[] = {30, 5, 10, 20};
  for (std::size_t i = 0; i < 4; ++i) {
    FileEntry file;
    file.day = days[i];
    LinkEntry& link = file.links.emplace_back();
    link.counts.cycles = 100;
    link.counts.by_status[static_cast<std::size_t>(CycleStatus::crc)] = i;
    link.ranges[static_cast<std::size_t>(Quantity::line_delay)] = {0, delays[i], 99};
    summary.add(file);
  }
  report::StringSink sink;
  ASSERT_TRUE(write_summary(summary, sink));
  const auto rows = nlohmann::json::parse(sink.text())["encoders"][0]["days"];
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].at("date"), "1970-01-11");
  EXPECT_EQ(rows[1].at("captures"), 3);
  EXPECT_EQ(rows[1].at("cycles"), 300);
  EXPECT_EQ(rows[1].at("faults"), 5);
  EXPECT_EQ(rows[1].at("line_delay_ps"), 20);
  EXPECT_TRUE(rows[1].at("ack_ps").is_null());
  // 10 000, 0, 20 000 and 30 000 in a million.
  EXPECT_EQ(fault_rates_of(captures_of(summary).begin()->second)[3].value, 30'000);
}

}  // namespace drift_test
}  // namespace biss::archive
