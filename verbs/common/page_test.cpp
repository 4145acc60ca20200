// The page that a report or a server gives to the browser.
#include "verbs/common/page.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "draw/svg.hpp"

namespace biss::verbs::page_test {
namespace {

const std::string page = R"(<body><script type="text/plain" id="biss-core">CORE</script></body>)";

class PageFile {
 public:
  explicit PageFile(const std::string& text)
      : path_(testing::TempDir() + "biss-page-" + std::to_string(getpid()) + ".html") {
    std::ofstream(path_) << text;
  }
  ~PageFile() { std::filesystem::remove(path_); }
  PageFile(const PageFile&) = delete;
  PageFile& operator=(const PageFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

TEST(Page, FileWithCore_IsRead) {
  const PageFile file(page);
  const auto read = read_page(file.path());
  ASSERT_TRUE(read.has_value()) << read.error().text;
  EXPECT_EQ(*read, page);
}

TEST(Page, OtherFile_IsNamedAsNoPage) {
  const PageFile file("<body></body>");
  const auto read = read_page(file.path());
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().status, ExitStatus::io);
  EXPECT_EQ(read.error().text, file.path() + ": is not the page of biss, which make view builds");
}

TEST(Page, FileThatIsNotThere_IsNamed) {
  const auto read = read_page("/nonexistent/biss.html");
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().text, "/nonexistent/biss.html: cannot open it: No such file or directory");
}

TEST(Page, Folder_IsNamed) {
  const auto read = read_page(testing::TempDir());
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().text, testing::TempDir() + ": it is a directory");
}

TEST(Page, CaptureInThePage_StandsBeforeTheCore) {
  EXPECT_EQ(
      page_with(page, "biss-capture", {{"name", "a.vcd"}, {"view", "row=1&panel=eds"}}, "H4sI"),
      R"(<body><script type="text/plain" id="biss-capture" data-name="a.vcd")"
      R"( data-view="row=1&amp;panel=eds">H4sI</script>)"
      R"(<script type="text/plain" id="biss-core">CORE</script></body>)");
}

TEST(Page, ReportInThePage_StandsBeforeTheCore) {
  EXPECT_EQ(page_with(page, "biss-report", {}, "H4sI"),
            R"(<body><script type="text/plain" id="biss-report">H4sI</script>)"
            R"(<script type="text/plain" id="biss-core">CORE</script></body>)");
}

TEST(Page, HostileName_StaysAnAttribute) {
  EXPECT_EQ(draw::markup_text("\"><script>alert('&')\n\r"),
            "&quot;&gt;&lt;script&gt;alert('&amp;')&#10;&#13;");
}

}  // namespace
}  // namespace biss::verbs::page_test
