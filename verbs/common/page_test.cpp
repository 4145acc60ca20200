// The page that a report or a server gives to the browser.
#include "verbs/common/page.hpp"

#include <gtest/gtest.h>

#include <string>

#include "capture/test_folder.hpp"
#include "draw/svg.hpp"

namespace biss::verbs::page_test {
namespace {

const std::string page = R"(<body><script type="text/plain" id="biss-core">CORE</script></body>)";

// Why a file is not the page.
std::string refused(const std::string& path) {
  try {
    read_page(path);
  } catch (const VerbError& error) {
    EXPECT_EQ(error.status, ExitStatus::io);
    return error.text;
  }
  ADD_FAILURE() << path << " is read";
  return {};
}

TEST(Page, FileWithCore_IsRead) {
  const test::Folder folder;
  EXPECT_EQ(read_page(folder.file("biss.html", page)), page);
}

TEST(Page, OtherFile_IsNamedAsNoPage) {
  const test::Folder folder;
  const std::string path = folder.file("biss.html", "<body></body>");
  EXPECT_EQ(refused(path), path + ": is not the page of biss, which make view builds");
}

TEST(Page, FileThatIsNotThere_IsNamed) {
  EXPECT_EQ(refused("/nonexistent/biss.html"),
            "/nonexistent/biss.html: cannot open it: No such file or directory");
}

TEST(Page, Folder_IsNamed) {
  EXPECT_EQ(refused(testing::TempDir()), testing::TempDir() + ": it is a directory");
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
