// docs/safety.md has every parameter with its default, every verdict and every transmission error;
// docs/safety-matrix.md and docs/assessor.md name tests that exist, and figures that are calculated.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "biss/safety/configurations.hpp"
#include "biss/safety/verdict.hpp"
#include "lab/pair.hpp"
#include "verbs/safety/evidence.hpp"
#include "verbs/safety/setup_fields.hpp"

namespace biss::verbs {
namespace documents_test {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string source(const std::string& path) { return text_of(fs::path(BISS_SOURCE_FOLDER) / path); }

// The names matched by the first group of the expression.
std::vector<std::string> all_of(const std::string& text, const std::string& expression) {
  const std::regex pattern(expression, std::regex::ECMAScript | std::regex::multiline);
  std::vector<std::string> found;
  for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at) {
    found.push_back((*at)[1]);
  }
  return found;
}

// Prints the parameter tables of docs/safety.md.
class Tables {
 public:
  void number(SetupField field, bool value) const { row(field, value ? "on" : "off"); }
  template <class Number>
  void number(SetupField field, Number value) const {
    row(field, std::to_string(value));
  }
  void time(SetupField field, Picoseconds value) const {
    row(field,
        value.count == 0 ? "0 s" : fmt::format("{} us", static_cast<double>(value.count) / 1e6));
  }
  template <class Choice>
  void choice(SetupField field, Choice value, std::span<const std::string_view> names) const {
    row(field, std::string(names[static_cast<std::size_t>(value)]));
  }

  const std::map<std::string, std::string>& text() const { return text_; }

 private:
  void row(SetupField field, const std::string& value) const {
    std::string& table = text_[field.group];
    if (table.empty()) {
      table = fmt::format("### {}\n| field | default | meaning |\n|---|---|---|\n", field.group);
    }
    table += fmt::format("| `{}` | {} | {} |\n", field.name, value, field.meaning);
  }

  mutable std::map<std::string, std::string> text_;
};

TEST(SafetyDocuments, EveryParameter_HasItsRowAndDefault) {
  // An introduction may stand between a heading and its table.
  const std::regex introduction("(### \\w+\n)[^|#]+\n\n(?=\\|)");
  const std::string page = std::regex_replace(source("docs/safety.md"), introduction, "$1");
  SafetySetup setup;
  const Tables tables;
  for_each_field(setup, tables);
  EXPECT_EQ(tables.text().size(), 7U);
  for (const auto& [group, table] : tables.text()) {
    EXPECT_NE(page.find(table + "\n"), std::string::npos) << "docs/safety.md needs this table:\n"
                                                          << table;
  }
}

TEST(SafetyDocuments, EveryName_IsOnThePage) {
  const std::string page = source("docs/safety.md");
  const auto has = [&](std::string_view begin, std::string_view name, std::string_view end) {
    EXPECT_NE(page.find(fmt::format("{}`{}`{}", begin, name, end)), std::string::npos) << name;
  };
  for (std::size_t i = 0; i < safety_verdict_count; ++i) {
    has("\n| ", name_of(verdict_of(i)), " |");
  }
  for (std::size_t i = 0; i < transmission_error_count; ++i) {
    has("\n| ", name_of(static_cast<TransmissionError>(i)), " |");
  }
  for (std::size_t i = 0; i < safety_state_count; ++i) has("\n| ", name_of(state_of(i)), " |");
  for (std::size_t i = 0; i < safety_setup_error_count; ++i) {
    has("", name_of(static_cast<SafetySetupError>(i)), "");
  }
  for (const auto names : {std::span<const std::string_view>(counter_mode_names),
                           std::span<const std::string_view>(missed_names),
                           std::span<const std::string_view>(multiturn_names)}) {
    for (const std::string_view name : names) has("", name, "");
  }
}

TEST(SafetyDocuments, TableOfTransitions_IsTheMonitors) {
  std::string table = "| event |";
  for (std::size_t i = 0; i < safety_state_count; ++i) {
    table += fmt::format(" `{}` |", name_of(state_of(i)));
  }
  table += "\n|---|---|---|---|---|---|\n";
  for (std::size_t event = 0; event < safety_event_count; ++event) {
    table += fmt::format("| `{}` |", safety_event_names[event]);
    for (std::size_t i = 0; i < safety_state_count; ++i) {
      table +=
          fmt::format(" {} |", name_of(next_state(state_of(i), static_cast<SafetyEvent>(event))));
    }
    table += "\n";
  }
  EXPECT_NE(source("docs/safety.md").find(table + "\n"), std::string::npos)
      << "docs/safety.md needs this table:\n"
      << table;
}

// The verdict of each measure is in the row of its error.
TEST(SafetyDocuments, EveryMeasure_IsInTheTableOfErrors) {
  const std::string page = source("docs/safety.md");
  for (const SafetyMeasure& measure : safety_measures) {
    const std::size_t at = page.find("\n| `" + std::string(name_of(measure.error)) + "` |");
    ASSERT_NE(at, std::string::npos);
    const std::string row = page.substr(at + 1, page.find('\n', at + 1) - at);
    EXPECT_NE(row.find("`" + std::string(name_of(measure.verdict)) + "`"), std::string::npos)
        << row;
  }
}

// Suite.Name of every test in the sources of a build list, or in a folder of which it takes all.
std::set<std::string> tests_of_the_build() {
  std::set<std::string> tests;
  for (const auto& entry : fs::recursive_directory_iterator(BISS_SOURCE_FOLDER)) {
    const fs::path& path = entry.path();
    if (!path.filename().string().ends_with("_test.cpp")) continue;
    if (fs::relative(path, BISS_SOURCE_FOLDER).string().starts_with("build")) continue;
    std::string list;
    for (const fs::path& folder : {path.parent_path(), path.parent_path().parent_path()}) {
      for (const char* name : {"CMakeLists.txt", "sources.cmake"}) {
        if (fs::exists(folder / name)) list += text_of(folder / name);
      }
    }
    if (list.find(path.filename().string()) == std::string::npos &&
        list.find("${folder}/*.cpp") == std::string::npos) {
      continue;
    }
    const std::regex pattern(R"((?:BISS_TEST|TEST|TEST_P|TEST_F)\((\w+),\s+(\w+)\))");
    const std::string text = text_of(path);
    for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at) {
      tests.insert((*at)[1].str() + "." + (*at)[2].str());
    }
  }
  // A test that is a command of its own.
  const std::string list = source("tests/core/CMakeLists.txt");
  for (const std::string& name : all_of(list, R"(add_test\(NAME (\w+\.\w+))")) tests.insert(name);
  return tests;
}

// The section of that title, up to the next one.
std::string section_of(const std::string& page, const std::string& title) {
  const std::size_t at = page.find("\n## " + title + "\n");
  EXPECT_NE(at, std::string::npos) << title;
  return at == std::string::npos ? "" : page.substr(at + 1, page.find("\n## ", at + 1) - at);
}

// The tests in the last column of a table, without `Each/`. All of them exist.
std::set<std::string> tests_of_table(const std::string& section) {
  const std::set<std::string> tests = tests_of_the_build();
  std::set<std::string> named;
  for (const std::string& name :
       all_of(section, "^\\|[^|]*\\| `(?:Each/)?([A-Z]\\w+\\.\\w+)` \\|$")) {
    EXPECT_TRUE(tests.contains(name)) << name;
    named.insert(name);
  }
  return named;
}

std::set<std::string> suites_of(const std::set<std::string>& tests) {
  std::set<std::string> suites;
  for (const std::string& test : tests) suites.insert(test.substr(0, test.find('.')));
  return suites;
}

TEST(SafetyDocuments, EveryPointOfTheReview_HasTestsThatExist) {
  const std::string part = section_of(source("docs/safety-matrix.md"), "Points of the review");
  EXPECT_EQ(all_of(part, "^\\| ([^|]+) \\| `").size(), 14U);
  const std::set<std::string> named = tests_of_table(part);
  EXPECT_GT(named.size(), 40U);
  const std::set<std::string> suites = suites_of(named);
  for (const char* suite : {"SafetyStates", "SafetyMemory", "SafetyCodes", "SafetyRating",
                            "SafetyRatings", "SafetyClock", "SafetyDelay", "SafePosition"}) {
    EXPECT_TRUE(suites.contains(suite)) << suite;
  }
}

TEST(SafetyDocuments, EveryStatementForTheAssessor_HasTestsThatExist) {
  const std::string page = source("docs/assessor.md");
  const std::string part = section_of(page, "Tests");
  EXPECT_GT(tests_of_table(part).size(), 60U);
  for (const std::string& statement : all_of(page, "^\\| ([EMFSDX]\\d+) \\|")) {
    // What no test can show: how the encoder is installed.
    if (statement == "D15") continue;
    const std::string any = statement.front() == 'E' ? "E1…E8" : statement;
    EXPECT_FALSE(all_of(part, "^\\|[^|`]*\\b(" + any + ")[ ,]").empty()) << statement;
  }
}

// The figures of the named configurations, without those that have the words of another one.
TEST(SafetyDocuments, FiguresForTheAssessor_AreThoseOfTheAnalysis) {
  std::string table =
      "| configuration | ACC_MIN | bits | frames/s | safe, CPW | safe, SPW | control | "
      "`check_safety()` |\n|---|---:|---:|---:|---:|---:|---:|---:|\n";
  for (const SafetyConfiguration& each : safety_configurations) {
    if (each.name.starts_with("fortis")) continue;
    const SafetyFormat monitored{each.frame_format(), each.setup, {}};
    const auto shares = lab::undetected_shares(monitored.format, monitored.setup.comparison);
    ASSERT_TRUE(shares) << each.name;
    const SafetyComparison& comparison = each.setup.comparison;
    const auto rate = rate_of_cycle(each.setup).count;
    const auto frames = 3600 * static_cast<long double>(rate);
    const long double most = 3600e12L / static_cast<long double>(each.setup.frame_gap_min.count);
    table +=
        fmt::format("| `{}` | {} | {} | {} | {:.3g} | {:.3g} | {:.0f} | {:.3g} |\n", each.name,
                    comparison.compare_bits == 0 ? "all" : std::to_string(comparison.compare_bits),
                    safety_detail::alignment_of(monitored.cpw(), monitored.spw(), comparison).bits,
                    rate, shares->by_cpw * frames, shares->by_spw * frames,
                    shares->control_position * frames, shares->safe_position() * most);
  }
  EXPECT_NE(source("docs/assessor.md").find(table + "\n"), std::string::npos)
      << "docs/assessor.md needs this table:\n"
      << table;
}

TEST(SafetyDocuments, EveryTestOfTheMatrix_Exists) {
  const std::set<std::string> tests = tests_of_the_build();
  EXPECT_GT(tests.size(), 500U);
  const std::string page = source("docs/safety-matrix.md");
  const std::string part = section_of(page, "Requirements and tests");
  std::set<std::string> named;
  for (const std::string& name : all_of(part, "^\\* `((?:Each/)?[A-Z]\\w+\\.\\w+)`$")) {
    const std::string plain = name.starts_with("Each/") ? name.substr(5) : name;
    EXPECT_TRUE(tests.contains(plain)) << name;
    named.insert(plain);
  }
  EXPECT_GT(named.size(), 60U);
  // Each requirement has a source and a test.
  const std::size_t requirements = all_of(part, "^(### )").size();
  EXPECT_EQ(all_of(part, "^### .*\nSource: .*\n(\\* `)").size(), requirements);
  EXPECT_GT(requirements, 30U);
  // Each suite about the monitor is mentioned.
  const std::set<std::string> suites = suites_of(named);
  for (const char* suite :
       {"SafetyMonitor", "SafetyCounter", "SafetyWords", "SafetyComparison", "SafetyFinding",
        "SafetySelfTest", "SafetySetup", "SafetyTime", "SafetyVerdicts", "SafetyConfigurations",
        "SafetyStates", "SafetyMemory", "SafetyCodes", "SafetyRating", "SafetyRatings",
        "SafetyClock", "SafetyDelay", "SafePosition"}) {
    EXPECT_TRUE(suites.contains(suite)) << suite;
  }
}

}  // namespace documents_test
}  // namespace biss::verbs
