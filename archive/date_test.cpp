#include "archive/entry.hpp"

#include <gtest/gtest.h>

namespace biss::archive {
namespace date_test {

std::string day_text_in(std::string_view path) {
  const auto day = day_in(path);
  return day ? day_text(*day) : "";
}

TEST(Date, DateInThePath_IsFound) {
  EXPECT_EQ(day_text_in("m1/2024-03-17.vcd"), "2024-03-17");
  EXPECT_EQ(day_text_in("m1/2024_03_17 axis.vcd"), "2024-03-17");
  EXPECT_EQ(day_text_in("m1/2024.03.17.vcd"), "2024-03-17");
  EXPECT_EQ(day_text_in("2024/03/17/a.vcd"), "2024-03-17");
  EXPECT_EQ(day_text_in("a20240317.vcd"), "2024-03-17");
  EXPECT_EQ(day_text_in("a_20240317_093000.vcd"), "2024-03-17");
  EXPECT_EQ(day_text_in("a_20240317093000.vcd"), "2024-03-17");
  EXPECT_EQ(day_text_in("2024-02-29"), "2024-02-29");
}

TEST(Date, LastDate_Counts) {
  EXPECT_EQ(day_text_in("backup-2025-01-01/2024-03-17/a.vcd"), "2024-03-17");
}

TEST(Date, OtherDigits_AreNoDate) {
  for (const char* path :
       {"", "a.vcd", "2024-03", "2024-3-17", "2023-02-29", "2024-13-01", "2024-00-10", "2024-03-32",
        "1889-03-17", "2150-03-17", "12024-03-17", "2024-03_17", "202403171", "serial 1234567890",
        "20241317", "2024-03-171"}) {
    EXPECT_FALSE(day_in(path)) << path;
  }
}

TEST(Date, TimeOfAFile_IsItsDayInUtc) {
  constexpr std::int64_t day_ns = std::int64_t{86'400} * 1'000'000'000;
  EXPECT_EQ(day_text(day_of(0)), "1970-01-01");
  EXPECT_EQ(day_text(day_of(-1)), "1969-12-31");
  EXPECT_EQ(day_text(day_of(day_ns - 1)), "1970-01-01");
  EXPECT_EQ(day_text(day_of(19'799 * day_ns)), "2024-03-17");
}

TEST(Date, Text_IsReadBack) {
  for (const Day day : {-100'000, -1, 0, 19'799, 100'000}) {
    EXPECT_EQ(day_from(day_text(day)), day);
  }
  EXPECT_FALSE(day_from("2024-02-30"));
  EXPECT_FALSE(day_from("2024-3-17"));
  EXPECT_FALSE(day_from("today"));
}

}  // namespace date_test
}  // namespace biss::archive
