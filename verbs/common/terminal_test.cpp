#include "verbs/common/terminal.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <limits>

#include "capture/test_folder.hpp"
#include "verbs/common/capture_input.hpp"

namespace biss::verbs {
namespace terminal_test {

TEST(ProgressLine, Rates_HaveAPrefixThatFits) {
  EXPECT_EQ(rate_text(85.34, "files"), ", 85.3 files/s");
  EXPECT_EQ(rate_text(1'250'000, "cycles"), ", 1.25 M cycles/s");
  EXPECT_EQ(rate_text(364e6, "B"), ", 364.00 MB/s");
  EXPECT_EQ(rate_text(2.1e9, "B"), ", 2.10 GB/s");
  EXPECT_EQ(rate_text(0, "cycles"), "");
  EXPECT_EQ(rate_text(std::numeric_limits<double>::quiet_NaN(), "cycles"), "");
  EXPECT_EQ(rate_text(std::numeric_limits<double>::infinity(), "cycles"), "");
}

TEST(ProgressLine, TimeLeft_IsRoundedToSeconds) {
  EXPECT_EQ(left_text(0), ", 0:00 left");
  EXPECT_EQ(left_text(12.4), ", 0:12 left");
  EXPECT_EQ(left_text(3'599.4), ", 59:59 left");
  EXPECT_EQ(left_text(3'599.5), ", 1:00:00 left");
  EXPECT_EQ(left_text(90'061), ", 25:01:01 left");
  EXPECT_EQ(left_text(1e9), "");
  EXPECT_EQ(left_text(std::numeric_limits<double>::infinity()), "");
  EXPECT_EQ(left_text(std::numeric_limits<double>::quiet_NaN()), "");
}

TEST(ProgressLine, OfACount_HasRateAndTimeLeft) {
  EXPECT_EQ(progress_text({.done = 300, .all = 1'000}, "frames", 3.0),
            "300 of 1000 frames, 100.0 frames/s, 0:07 left");
  EXPECT_EQ(progress_text({.done = 900, .all = 1'000, .before = 800}, "frames", 10.0),
            "900 of 1000 frames, 10.0 frames/s, 0:10 left");
  EXPECT_EQ(progress_text({.done = 5'000'000}, "cycles", 4.0), "5000000 cycles, 1.25 M cycles/s");
  EXPECT_EQ(progress_text({.done = 0, .all = 10}, "faults", 2.0), "0 of 10 faults");
}

TEST(CutOff, TextEndsWithAWholeCharacter) {
  EXPECT_EQ(cut_off("abc", 2), "ab");
  EXPECT_EQ(cut_off("abc", 9), "abc");
  EXPECT_EQ(cut_off("1 \xC2\xB1 2", 3), "1 \xC2\xB1");
  EXPECT_EQ(cut_off("1 \xC2\xB1 2", 2), "1 ");
  EXPECT_EQ(cut_off("a\x1B[2J", 2), "a\xEF\xBF\xBD");
  EXPECT_EQ(cut_off("a", 0), "");
}

TEST(ReadAmount, OfAFileThatIsReadByAnotherDescriptor_IsFound) {
  const test::Folder folder;
  const std::string path = folder.file("file", std::string(1'000, 'x'));
  const int first = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_GE(first, 0);
  EXPECT_FALSE(read_amount(path));
  const int again = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_EQ(::lseek(again, 250, SEEK_SET), 250);
  const auto amount = read_amount(path);
  ASSERT_TRUE(amount);
  EXPECT_EQ(amount->read, 250U);
  EXPECT_EQ(amount->all, 1'000U);
  ::close(again);
  ::close(first);
  std::filesystem::remove(path);
  EXPECT_FALSE(read_amount(path));
}

}  // namespace terminal_test
}  // namespace biss::verbs
