#include "capture/text_source.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "capture/test_capture.hpp"

namespace biss::capture {
namespace text_source_test {

std::vector<std::string> windows_of(std::string_view text, TextWindow::Cut cut, std::size_t block) {
  TextWindow window(memory_bytes(text, block), cut);
  std::vector<std::string> windows;
  while (window.next() == true) {
    windows.emplace_back(window.begin(), window.end());
  }
  return windows;
}

TEST(TextWindow, AnyBlockSize_GivesWholeWordsAndAllOfTheText) {
  const std::string text = "a bc\tdef \n ghij  k";
  for (std::size_t block = 1; block <= text.size() + 1; ++block) {
    std::string all;
    for (const std::string& window : windows_of(text, TextWindow::Cut::words, block)) {
      EXPECT_TRUE(is_space(window.back())) << "block " << block;
      all += window;
    }
    EXPECT_EQ(all, text + '\n') << "block " << block;
  }
}

TEST(TextWindow, CutAtLines_GivesWholeLines) {
  EXPECT_EQ(windows_of("a b\nc d\ne", TextWindow::Cut::lines, 2),
            (std::vector<std::string>{"a b\n", "c d\n", "e\n"}));
}

TEST(TextWindow, MissingLastDelimiter_IsAddedAndSaid) {
  TextWindow window(memory_bytes("ab cd"), TextWindow::Cut::words);
  ASSERT_TRUE(window.next() == true);
  EXPECT_FALSE(window.unterminated());
  ASSERT_TRUE(window.next() == true);
  EXPECT_EQ(std::string(window.begin(), window.end()), "cd\n");
  EXPECT_TRUE(window.unterminated());
  EXPECT_TRUE(window.next() == false);
}

TEST(TextWindow, ByteOrderMark_IsLeftOutAndNotCountedInColumns) {
  for (const std::size_t block : {std::size_t{1}, one_block}) {
    TextWindow window(memory_bytes("\xEF\xBB\xBFxy z", block), TextWindow::Cut::words);
    ASSERT_TRUE(window.next() == true);
    EXPECT_EQ(std::string(window.begin(), window.end()), "xy ");
    EXPECT_EQ(window.error_at(window.begin(), CaptureCause::malformed).column, 1U);
  }
}

TEST(TextWindow, Error_NamesLineAndColumnWhateverTheBlockSize) {
  const std::string text = "one\n two\n\n  three four";
  for (const std::size_t block : {std::size_t{1}, std::size_t{2}, std::size_t{7}, one_block}) {
    TextWindow window(memory_bytes(text, block), TextWindow::Cut::words);
    bool found = false;
    while (!found && window.next() == true) {
      const std::string_view view(window.begin(),
                                  static_cast<std::size_t>(window.end() - window.begin()));
      const std::size_t at = view.find("three");
      if (at == std::string_view::npos) continue;
      found = true;
      const CaptureError error = window.error_at(window.begin() + at, CaptureCause::malformed);
      EXPECT_EQ(error.line, 4U) << "block " << block;
      EXPECT_EQ(error.column, 3U) << "block " << block;
    }
    EXPECT_TRUE(found);
  }
}

TEST(TextWindow, WordWithoutEnd_FailsAfterBoundedReading) {
  const std::string text = "ab " + std::string(10 * max_token_bytes, 'x');
  for (const std::size_t block : {std::size_t{997}, one_block}) {
    TextWindow window(memory_bytes(text, block), TextWindow::Cut::words);
    ASSERT_TRUE(window.next() == true);
    const auto failed = window.next();
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().cause, CaptureCause::token_too_long);
    EXPECT_EQ(failed.error().line, 1U);
    EXPECT_EQ(failed.error().column, 4U);
  }
}

TEST(TextWindow, DroppedLongWord_GoesOnBehindItWithRightColumns) {
  const std::string text = "ab " + std::string(5 * max_token_bytes, 'x') + " cd ";
  for (const std::size_t block : {std::size_t{1'000}, std::size_t{4'096}}) {
    TextWindow window(memory_bytes(text, block), TextWindow::Cut::words);
    std::string all;
    CaptureError last;
    while (window.next(true) == true) {
      all.append(window.begin(), window.end());
      last = window.error_at(window.end() - 1, CaptureCause::malformed);
    }
    EXPECT_EQ(all.substr(0, 3), "ab ");
    EXPECT_EQ(all.substr(all.size() - 4), " cd ");
    EXPECT_LT(all.size(), 2 * max_token_bytes);
    EXPECT_EQ(last.column, text.size());
  }
}

}  // namespace text_source_test
}  // namespace biss::capture
