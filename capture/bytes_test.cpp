#include "capture/bytes.hpp"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <string>

#include "capture/test_folder.hpp"

namespace biss::capture {
namespace bytes_test {

std::string drain(ByteSource& bytes, std::size_t at_most) {
  std::string text;
  std::string block(at_most, '\0');
  for (;;) {
    const auto got = bytes.read(block);
    if (!got.ok() || *got == 0) return text;
    text.append(block, 0, *got);
  }
}

TEST(ByteSource, MissingFile_ReportsCannotOpen) {
  const OpenedBytes opened = open_bytes("no/such/file.vcd");
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().cause, CaptureCause::cannot_open);
}

TEST(ByteSource, Folder_ReportsIsDirectory) {
  const OpenedBytes opened = open_bytes(std::filesystem::temp_directory_path().string());
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().cause, CaptureCause::is_directory);
}

TEST(ByteSource, File_DeliversItsBytes) {
  const test::Folder folder;
  const std::string text = std::string(10'000, 'q') + '\0';
  const OpenedBytes opened = open_bytes(folder.file("bytes.bin", text));
  ASSERT_TRUE(opened);
  EXPECT_EQ(drain(**opened, 777), text);
}

TEST(ByteSource, FileThatCannotBeRead_ReportsReadFailed) {
  // The memory of a process opens like a file, but nothing is mapped at its address 0.
  const OpenedBytes opened = open_bytes("/proc/self/mem");
  if (!opened) GTEST_SKIP() << "no /proc/self/mem on this system";
  std::array<char, 16> block{};
  const auto got = (*opened)->read(block);
  ASSERT_FALSE(got.ok());
  EXPECT_EQ(got.error().cause, CaptureCause::read_failed);
}

TEST(ByteSource, Memory_HandsOutBlocksOfTheSizeAskedFor) {
  const auto bytes = memory_bytes("abcdefgh", 3);
  std::array<char, 16> block{};
  EXPECT_EQ(*bytes->read(block), 3U);
  EXPECT_EQ(drain(*bytes, 2), "defgh");
  EXPECT_EQ(*bytes->read(block), 0U);
}

TEST(ByteSource, Prefixed_DeliversHeadThenRest) {
  const auto bytes = prefixed_bytes("abc", memory_bytes("defg"));
  EXPECT_EQ(drain(*bytes, 2), "abcdefg");
}

}  // namespace bytes_test
}  // namespace biss::capture
