// A thousand captures: threads, shards and interruptions change nothing.
#include <gtest/gtest.h>

#include "tests/archive/archive_folder.hpp"

namespace biss::verbs::large_archive_test {

constexpr std::size_t captures = 1'000;

TEST(LargeArchive, KilledAtRandomFiftyTimes_HasTheSummaryOfOneRun) {
  const ArchiveFolder archive(captures);
  EXPECT_GT(kill_and_resume(archive, 50, 1), 25);
}

TEST(LargeArchive, ThreadsAndSevenShards_GiveTheSameSummary) {
  const ArchiveFolder archive(captures);
  const std::string one = summary_of(archive, "1");
  EXPECT_EQ(summary_of(archive, "2"), one);
  EXPECT_EQ(summary_of(archive, "7"), one);
  EXPECT_EQ(merged_summary_of(archive, 7), one);
}

}  // namespace biss::verbs::large_archive_test
