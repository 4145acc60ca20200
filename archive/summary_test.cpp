#include "archive/summary.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "archive/test_entry.hpp"

namespace biss::archive {
namespace summary_test {

std::string text_of_summary(Summary summary) {
  std::sort(summary.files.begin(), summary.files.end(), is_worse);
  report::StringSink sink;
  EXPECT_TRUE(write_summary(summary, sink));
  return sink.text();
}

tl::expected<Summary, std::string> read(const std::string& text) {
  std::istringstream stream(text);
  return read_summary(stream);
}

// The files of one list, in `count` parts.
std::vector<NamedSummary> parts_of(const std::vector<FileEntry>& files, std::size_t count) {
  std::vector<NamedSummary> parts;
  for (std::size_t part = 0; part < count; ++part) {
    Summary summary;
    summary.setup = {"biss", {"--format x"}};
    summary.parts = {.count = count, .done = {part + 1}};
    for (std::size_t i = 0; i < files.size(); ++i) {
      summary.list.add(files[i].path);
      if (i % count == part) summary.add(files[i]);
    }
    parts.emplace_back(fmt::format("part {}", part + 1), std::move(summary));
  }
  return parts;
}

std::vector<FileEntry> random_files(Random& random, std::size_t count) {
  std::vector<FileEntry> files;
  for (std::size_t i = 0; i < count; ++i) {
    files.push_back(random_entry(random, fmt::format("m{}/{:04}", random() % 3, i)));
  }
  return files;
}

TEST(Summary, Text_IsReadBackAndWrittenTheSame) {
  Random random(1);
  for (int round = 0; round < 10; ++round) {
    const std::string text = text_of_summary(parts_of(random_files(random, 30), 1).front().second);
    const auto summary = read(text);
    ASSERT_TRUE(summary) << summary.error();
    EXPECT_EQ(text_of_summary(*summary), text);
  }
}

TEST(Summary, PartsInAnyOrder_AddUpToTheWhole) {
  Random random(2);
  for (const std::size_t count : {1U, 2U, 7U, 50U}) {
    const auto files = random_files(random, 40);
    const std::string whole = text_of_summary(parts_of(files, 1).front().second);
    auto parts = parts_of(files, count);
    std::shuffle(parts.begin(), parts.end(), random);
    // As through files.
    for (auto& [name, part] : parts) part = *read(text_of_summary(part));
    const auto sum = merge(std::move(parts));
    ASSERT_TRUE(sum) << sum.error();
    EXPECT_EQ(text_of_summary(*sum), whole) << count;
  }
}

TEST(Summary, SomeParts_AddUpAndNameTheOthers) {
  Random random(3);
  const auto files = random_files(random, 40);
  auto parts = parts_of(files, 20);
  const NamedSummary last = parts.back();
  parts.pop_back();
  parts.erase(parts.begin(), parts.begin() + 10);
  auto sum = merge(std::move(parts));
  ASSERT_TRUE(sum) << sum.error();
  EXPECT_FALSE(sum->parts.complete());
  EXPECT_EQ(sum->parts.missing(), "1, 2, 3, 4, 5, 6, 7, 8, ...");
  sum = merge({{"sum", std::move(*sum)}, last});
  ASSERT_TRUE(sum) << sum.error();
  EXPECT_EQ(sum->parts.done.size(), 10U);
}

TEST(Summary, EachByteChanged_IsRefused) {
  Random random(5);
  const std::string text = text_of_summary(parts_of(random_files(random, 2), 1).front().second);
  ASSERT_TRUE(read(text));
  for (std::size_t at = 0; at < text.size(); ++at) {
    std::string changed = text;
    const unsigned mask = at % 2 == 0 ? 1U : 0x20U;
    changed[at] = static_cast<char>(static_cast<unsigned char>(changed[at]) ^ mask);
    EXPECT_FALSE(read(changed)) << at << ": " << text.substr(at, 40);
  }
}

TEST(Summary, DamagedText_IsRefused) {
  Random random(4);
  const std::string text = text_of_summary(parts_of(random_files(random, 6), 1).front().second);
  for (int round = 0; round < 1'000; ++round) {
    std::string damaged = text;
    const std::size_t at = random() % damaged.size();
    switch (random() % 3) {
      case 0:
        damaged[at] = static_cast<char>(random());
        break;
      case 1:
        damaged.erase(at, random() % 40);
        break;
      default:
        damaged.insert(at, damaged.substr(random() % damaged.size(), random() % 40));
    }
    const auto summary = read(damaged);
    EXPECT_EQ(summary.has_value(), damaged == text) << at;
  }
}

TEST(Summary, LargeNumbers_AreStrings) {
  FileEntry entry;
  entry.path = "a";
  entry.bytes = (std::uint64_t{1} << 53U) + 1;
  entry.cause = "empty";
  Summary summary;
  summary.list.add("a");
  summary.parts.done = {1};
  summary.add(entry);
  const std::string text = text_of_summary(summary);
  EXPECT_NE(text.find("\"bytes\":\"9007199254740993\""), std::string::npos) << text;
  const auto again = read(text);
  ASSERT_TRUE(again) << again.error();
  EXPECT_EQ(again->files[0].bytes, entry.bytes);
}

}  // namespace summary_test
}  // namespace biss::archive
