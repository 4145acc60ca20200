#include "archive/entry.hpp"

#include <gtest/gtest.h>

#include "archive/test_entry.hpp"

namespace biss::archive {
namespace entry_test {

TEST(Entry, JournalLine_IsReadBack) {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const StampedEntry stamped{{random() >> 3U, static_cast<std::int64_t>(random())},
                               random_entry(random, "folder/file " + std::to_string(i))};
    const std::string line = journal_line(stamped);
    EXPECT_EQ(line.find('\n'), std::string::npos);
    const auto read = read_journal_line(line);
    ASSERT_TRUE(read) << read.error() << '\n' << line;
    EXPECT_EQ(read->stamp, stamped.stamp);
    EXPECT_EQ(read->entry, stamped.entry);
  }
}

TEST(Entry, DamagedJournalLine_IsRefused) {
  Random random(2);
  const std::string line = journal_line({{1, 2}, random_entry(random, "a")});
  for (std::size_t bytes = 0; bytes < line.size(); bytes += 1 + bytes / 50) {
    EXPECT_FALSE(read_journal_line(std::string_view(line).substr(0, bytes))) << bytes;
  }
  for (std::size_t at = 0; at < line.size(); at += 1 + at / 50) {
    std::string flipped = line;
    flipped[at] = static_cast<char>(flipped[at] ^ 1);
    EXPECT_FALSE(read_journal_line(flipped)) << at;
  }
}

FileEntry entry_with(const std::string& path, std::uint64_t crc, std::uint64_t ok,
                     std::uint64_t unchecked = 0) {
  FileEntry entry;
  entry.path = path;
  entry.reading = Reading::whole;
  LinkEntry& link = entry.links.emplace_back();
  link.counts.cycles = crc + ok + unchecked;
  link.counts.by_status[static_cast<std::size_t>(CycleStatus::crc)] = crc;
  link.counts.by_status[static_cast<std::size_t>(CycleStatus::ok)] = ok;
  link.counts.by_status[static_cast<std::size_t>(CycleStatus::unchecked)] = unchecked;
  return entry;
}

FileEntry unread(const std::string& path, const std::string& cause) {
  FileEntry entry;
  entry.path = path;
  entry.cause = cause;
  return entry;
}

TEST(Entry, OrderOfTheWorst_IsByShareOfFaults) {
  FileEntry cut = entry_with("cut", 0, 9);
  cut.cause = "truncated";
  cut.reading = Reading::part;
  const std::vector<FileEntry> sorted{entry_with("half", 5, 5),     entry_with("many", 40, 160),
                                      entry_with("few", 1, 99),     cut,
                                      unread("bad", "damaged"),     entry_with("still", 0, 0, 10),
                                      entry_with("good", 0, 10),    entry_with("good 2", 0, 1),
                                      unread("a", "unknown_format")};
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    for (std::size_t k = 0; k < sorted.size(); ++k) {
      EXPECT_EQ(is_worse(sorted[i], sorted[k]), i < k) << sorted[i].path << ' ' << sorted[k].path;
    }
  }
}

TEST(Entry, TextThatIsNoUtf8_StaysDifferent) {
  EXPECT_EQ(utf8_text("caf\xC3\xA9 \\ x"), "caf\xC3\xA9 \\ x");
  EXPECT_EQ(utf8_text("a\xE9"), "a\\xE9");
  EXPECT_EQ(utf8_text("a\\xE9"), "a\\x5CxE9");
  EXPECT_EQ(utf8_text("\\\xE9"), "\\x5C\\xE9");
  EXPECT_EQ(utf8_text(std::string_view("\0", 1)), std::string_view("\0", 1));
}

}  // namespace entry_test
}  // namespace biss::archive
