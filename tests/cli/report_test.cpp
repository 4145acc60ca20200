// `biss report`: the page with a capture in it.
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/cli/run_command.hpp"

namespace biss::verbs::report_test {

using ReportVerb = InFolder;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

constexpr const char* page = R"(<p>a</p><script type="text/plain" id="biss-core">CORE</script>)";

std::string simulate(const Folder& folder, const std::string& name, const Words& more) {
  const std::string capture = folder.path(name);
  run_ok(Words("simulate -f pos12,nE,nW,crc6 --seed 3 -o {}", capture) + more);
  return capture;
}

Outcome report(const Folder& folder, const std::string& capture, const Words& more = {}) {
  return run(Words("report {} --page {} -o {}", capture, folder.file("page.html", page),
                   folder.path("report.html")) +
             more);
}

TEST_F(ReportVerb, SmallCapture_IsInThePageAsAWhole) {
  const std::string capture = simulate(folder, "line.vcd", "--cycles 6");
  const Outcome made = ok(report(folder, capture, "-f pos12,nE,nW,crc6 --ack-max 16us"));
  EXPECT_THAT(made.err, HasSubstr("the whole capture"));
  const std::string text = content_of(folder.path("report.html"));
  EXPECT_THAT(text, StartsWith(R"(<p>a</p><script type="text/plain" id="biss-capture")"
                               R"( data-name="line.vcd" data-view="format=pos12%2CnE%2CnW%2Ccrc6)"
                               R"(&amp;further=--ack-max%2016us">H4sI)"));
  EXPECT_THAT(text,
              HasSubstr(R"(</script><script type="text/plain" id="biss-core">CORE</script>)"));
  EXPECT_THAT(text, Not(HasSubstr("biss-report")));
}

TEST_F(ReportVerb, LargeCapture_IsInThePageInPartAndTheSameBytesAgain) {
  const std::string capture = simulate(folder, "line.vcd", "--cycles 24000 --fault flip:0.01");
  ASSERT_GT(std::filesystem::file_size(capture), 16U << 20U);
  const Outcome made = ok(report(folder, capture));
  EXPECT_THAT(made.err, HasSubstr("of 24000 request cycles"));
  EXPECT_THAT(made.err, testing::ContainsRegex("All [0-9]+ failed cycles are in it"));
  const std::string text = content_of(folder.path("report.html"));
  EXPECT_LT(text.size(), 1'000'000U);
  EXPECT_THAT(text, HasSubstr(R"(id="biss-report">H4sI)"));
  EXPECT_THAT(text, HasSubstr("ma=MA&amp;slo=SLO"));
  ASSERT_EQ(report(folder, capture).status, 0);
  EXPECT_EQ(content_of(folder.path("report.html")), text);
}

// What the page carries under this name, in a file.
std::string carried(const Folder& folder, const std::string& name) {
  const std::string text = content_of(folder.path("report.html"));
  const std::size_t begin = text.find('>', text.find("id=\"" + name + '"')) + 1;
  const std::string packed =
      folder.file(name + ".txt", text.substr(begin, text.find('<', begin) - begin));
  const std::string file = folder.path(name);
  EXPECT_EQ(std::system(("base64 -d " + packed + " | gzip -dc >" + file).c_str()), 0);
  return file;
}

// The verbs of the panels take part in the reading of the report, and answer as if they were alone.
TEST_F(ReportVerb, LargeCapture_ItsPanelsHaveTheAnswersOfTheVerbs) {
  const std::string capture = folder.path("line.vcd");
  run_ok(
      Words("simulate -f resolute-26 --seed 4 --cycles 16000 --fault flip:0.01 --fault "
            "lost_clock:0.002 -o {}",
            capture));
  const auto without_folder = [&](std::string text) {
    for (std::size_t at = text.find(capture); at != std::string::npos; at = text.find(capture)) {
      text.replace(at, capture.size(), "line.vcd");
    }
    return text;
  };
  const auto expect_panels = [&](const Words& format, const Words& more) {
    ASSERT_EQ(report(folder, capture, format + more).status, 0);
    const auto made = nlohmann::json::parse(content_of(carried(folder, "biss-report")));
    std::map<std::string, Words> panels{{"identify", "identify"},
                                        {"explain", Words("explain") + format}};
    for (const std::string_view limits : {"biss-c", "renishaw", "resolute-26"}) {
      if (format.empty() && limits == "resolute-26") continue;
      panels[fmt::format("check {}", limits)] = Words("check --against {}", limits) + format;
    }
    EXPECT_EQ(made["verbs"].size(), panels.size() + 1);  // and registers
    for (const auto& [panel, words] : panels) {
      const Outcome alone = run(words + more + Words("--to jsonl {}", capture));
      ASSERT_TRUE(made.at("verbs").contains(panel)) << panel;
      const auto& answer = made["verbs"][panel];
      EXPECT_EQ(answer["status"], alone.status) << panel;
      EXPECT_EQ(answer["out"], without_folder(alone.out)) << panel;
      EXPECT_EQ(answer["err"], without_folder(alone.err)) << panel;
    }
  };
  expect_panels({}, {});
  expect_panels("-f resolute-26", {});
  expect_panels("-f resolute-26", "--resolution 40ns --timeout static:20us");
}

// The rows of a capture without their numbers.
std::vector<std::string> rows_of(const std::string& capture, const Words& more = {}) {
  Words words = Words("decode {} -f pos12,nE,nW,crc6 --to csv", capture) + more;
  std::istringstream table(run(words).out);
  std::vector<std::string> rows;
  std::string row;
  std::getline(table, row);
  while (std::getline(table, row)) rows.push_back(row.substr(row.find(',')));
  return rows;
}

TEST_F(ReportVerb, LargeCapture_ItsFirstAndItsFailedCyclesReadInThePartAsInTheWhole) {
  const std::string capture =
      simulate(folder, "line.vcd", "--cycles 24000 --fault flip:0.01 --fault lost_clock:0.002");
  ASSERT_EQ(report(folder, capture, "-f pos12,nE,nW,crc6").status, 0);
  const std::string part = folder.path("part.vcd");
  std::filesystem::rename(carried(folder, "biss-capture"), part);
  const std::vector<std::string> whole = rows_of(capture);
  const std::vector<std::string> shown = rows_of(part, {"--ma", "MA", "--slo", "SLO"});
  const std::set<std::string> in_part(shown.begin(), shown.end());
  std::size_t failed = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const bool is_good = whole[i].find(",ok,") != std::string::npos;
    const bool is_cut = whole[i].find(",cut_") != std::string::npos;
    if (!is_good && !is_cut) ++failed;
    if (i >= 100 && (is_good || is_cut)) continue;
    EXPECT_EQ(in_part.count(whole[i]), 1U) << i << whole[i];
  }
  EXPECT_GT(failed, 200U);
  EXPECT_LT(shown.size(), whole.size() / 4);
}

TEST_F(ReportVerb, HostileFileName_StaysAnAttribute) {
  const std::string capture = simulate(folder, "\"><b>&.vcd", "--cycles 3");
  ASSERT_EQ(report(folder, capture).status, 0);
  EXPECT_THAT(content_of(folder.path("report.html")),
              HasSubstr(R"(data-name="&quot;&gt;&lt;b&gt;&amp;.vcd")"));
}

TEST_F(ReportVerb, HostileFileNameOfALargeCapture_IsNotInThePageAsItIs) {
  const std::string first = simulate(folder, "a.vcd", "--cycles 24000");
  std::filesystem::rename(first, folder.path("x<b>y.vcd"));
  ASSERT_EQ(report(folder, folder.path("x<b>y.vcd")).status, 0);
  EXPECT_THAT(content_of(folder.path("report.html")), Not(HasSubstr("<b>")));
}

TEST_F(ReportVerb, StandardInput_IsRefusedWithItsReason) {
  EXPECT_THAT(report(folder, "-"), fails(2, "a report reads a capture several times; give a file"));
}

TEST_F(ReportVerb, SeveralCaptures_AreRefused) {
  const std::string a = simulate(folder, "a.vcd", "--cycles 3");
  const std::string b = simulate(folder, "b.vcd", "--cycles 3");
  EXPECT_THAT(report(folder, a, {b}),
              fails(2, testing::AllOf(HasSubstr("one capture"),
                                      HasSubstr("give one file, or one for each line"))));
}

TEST_F(ReportVerb, Each_IsNotOffered) {
  EXPECT_THAT(report(folder, simulate(folder, "a.vcd", "--cycles 3"), {"--each"}),
              fails(2, "unknown option '--each'"));
  EXPECT_THAT(run("report --help").out, Not(HasSubstr("--each")));
}

TEST_F(ReportVerb, NoCapture_LeavesTheOldReport) {
  folder.file("report.html", "old");
  EXPECT_EQ(report(folder, folder.file("a.vcd", "no capture")).status, 3);
  EXPECT_EQ(content_of(folder.path("report.html")), "old");
}

}  // namespace biss::verbs::report_test
