// docs/safety.md has every parameter with its default, every verdict and every fault;
// docs/safety-matrix.md names tests that there are.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "biss/frame/frame.hpp"
#include "biss/safety/setup.hpp"
#include "biss/safety/verdict.hpp"

namespace biss::cli {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string source(const std::string& path) { return text_of(fs::path(BISS_SOURCE_FOLDER) / path); }

// Names that the first group of the expression finds.
std::vector<std::string> all_of(const std::string& text, const std::string& expression) {
  const std::regex pattern(expression, std::regex::ECMAScript | std::regex::multiline);
  std::vector<std::string> found;
  for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at) {
    found.push_back((*at)[1]);
  }
  return found;
}

// What stands between `struct NAME {`, or `enum class NAME …{`, and its closing brace.
std::string body_of(const std::string& header, const std::string& name) {
  const std::size_t at = header.find(name);
  if (at == std::string::npos) return {};
  return header.substr(at, header.find("\n}", at) - at);
}

std::vector<std::string> fields_of(const std::string& header, const std::string& name) {
  const std::string body = body_of(source(header), "struct " + name + " {");
  return all_of(body, R"(^  (?!constexpr)[A-Za-z_:0-9]+ ([a-z_]+)(?: = [^;]*|\{\})?;)");
}

std::vector<std::string> enumerators_of(const std::string& header, const std::string& name) {
  return all_of(body_of(source(header), "enum class " + name + " "), R"(^  ([a-z_0-9]+),)");
}

// Field and default of the rows below a heading.
using Rows = std::vector<std::pair<std::string, std::string>>;
Rows rows_below(const std::string& page, const std::string& heading) {
  const std::size_t at = page.find("\n### " + heading + "\n");
  EXPECT_NE(at, std::string::npos) << heading;
  if (at == std::string::npos) return {};
  const std::string part = page.substr(at + 1, page.find("\n##", at + 1) - at);
  const std::regex row(R"(^\| `([a-z_]+)` \| ([^|]*)\|)",
                       std::regex::ECMAScript | std::regex::multiline);
  Rows rows;
  for (std::sregex_iterator each(part.begin(), part.end(), row), end; each != end; ++each) {
    std::string value = (*each)[2];
    while (value.ends_with(' ')) value.pop_back();
    rows.emplace_back((*each)[1], value);
  }
  return rows;
}

std::string micro(Picoseconds time) {
  return time.count == 0 ? "0 s" : fmt::format("{} us", static_cast<double>(time.count) * 1e-6);
}

// As the page writes them; a struct of its own has none.
std::map<std::string, Rows> defaults() {
  const SafetySetup setup;
  const FrameBounds& bounds = setup.bounds;
  const auto number = [](unsigned value) { return std::to_string(value); };
  return {{"SafetySetup",
           {{"cpw", number(setup.cpw)},
            {"spw", number(setup.spw)},
            {"start_frames", number(setup.start_frames)},
            {"latch", setup.latch ? "on" : "off"},
            {"comparison", ""},
            {"counter", ""},
            {"cycle_min", micro(setup.cycle_min)},
            {"frame_gap_max", micro(setup.frame_gap_max)},
            {"frame_gap_min", micro(setup.frame_gap_min)},
            {"budget", ""},
            {"bounds", ""}}},
          {"SafetyComparison",
           {{"compare_bits", number(setup.comparison.compare_bits)},
            {"tolerance_lsb", number(setup.comparison.tolerance_lsb)},
            {"multiturn", enumerators_of("biss/safety/setup.hpp", "MultiturnRule")
                              .at(static_cast<std::size_t>(setup.comparison.multiturn))}}},
          {"SafetyCounter",
           {{"mode", enumerators_of("biss/safety/setup.hpp", "CounterMode")
                         .at(static_cast<std::size_t>(setup.counter.mode))},
            {"missed", enumerators_of("biss/safety/setup.hpp", "MissedFrames")
                           .at(static_cast<std::size_t>(setup.counter.missed))},
            {"near_frames", number(setup.counter.near_frames)},
            {"learn_rollovers", number(setup.counter.learn_rollovers)}}},
          {"SafetyBudget",
           {{"faults", number(setup.budget.faults)}, {"window", micro(setup.budget.window)}}},
          {"FrameBounds",
           {{"lead_min_clocks", number(bounds.lead_min_clocks)},
            {"lead_max_clocks", number(bounds.lead_max_clocks)},
            {"ack_min_clocks", number(bounds.ack_min_clocks)},
            {"ack_max_clocks", number(bounds.ack_max_clocks)},
            {"late_max_clocks", number(bounds.late_max_clocks)}}}};
}

TEST(SafetyDocuments, EveryParameter_HasItsRowAndDefault) {
  const std::string page = source("docs/safety.md");
  for (const auto& [name, rows] : defaults()) {
    SCOPED_TRACE(name);
    std::vector<std::string> listed;
    for (const auto& [field, value] : rows) listed.push_back(field);
    const std::string header =
        name == "FrameBounds" ? "biss/frame/frame.hpp" : "biss/safety/setup.hpp";
    EXPECT_EQ(fields_of(header, name), listed) << "a field that this test does not know";
    EXPECT_EQ(rows_below(page, name), rows) << "docs/safety.md";
  }
}

TEST(SafetyDocuments, EveryName_StandsOnThePage) {
  const std::string page = source("docs/safety.md");
  const auto stands = [&](const std::string& name) {
    EXPECT_NE(page.find("`" + name + "`"), std::string::npos) << name;
  };
  const auto has_row = [&](const std::string& name) {
    EXPECT_NE(page.find("\n| `" + name + "` |"), std::string::npos) << name;
  };
  for (std::size_t i = 0; i < safety_verdict_count; ++i) {
    has_row(std::string(name_of(static_cast<SafetyVerdict>(i))));
  }
  for (std::size_t i = 0; i < transmission_error_count; ++i) {
    has_row(std::string(name_of(static_cast<TransmissionError>(i))));
  }
  const auto states = enumerators_of("biss/safety/verdict.hpp", "SafetyState");
  EXPECT_EQ(states.size(), 4U);
  for (const std::string& name : states) has_row(name);
  for (const char* name : {"CounterMode", "MissedFrames", "MultiturnRule", "SafetySetupError"}) {
    const auto enumerators = enumerators_of("biss/safety/setup.hpp", name);
    EXPECT_GE(enumerators.size(), 2U) << name;
    for (const std::string& each : enumerators) stands(each);
  }
}

// Each measure's verdict stands in the row of its kind.
TEST(SafetyDocuments, EveryMeasure_IsInTheTableOfFaults) {
  const std::string page = source("docs/safety.md");
  for (const SafetyMeasure& measure : safety_measures) {
    const std::size_t at = page.find("\n| `" + std::string(name_of(measure.error)) + "` |");
    ASSERT_NE(at, std::string::npos);
    const std::string row = page.substr(at + 1, page.find('\n', at + 1) - at);
    EXPECT_NE(row.find("`" + std::string(name_of(measure.verdict)) + "`"), std::string::npos)
        << row;
  }
}

// Suite.Name of every test in a source that a build lists.
std::set<std::string> tests_of_the_build() {
  std::set<std::string> tests;
  for (const auto& entry : fs::recursive_directory_iterator(BISS_SOURCE_FOLDER)) {
    const fs::path& path = entry.path();
    if (!path.filename().string().ends_with("_test.cpp")) continue;
    if (fs::relative(path, BISS_SOURCE_FOLDER).string().starts_with("build")) continue;
    std::string list;
    for (const char* name : {"CMakeLists.txt", "sources.cmake"}) {
      const fs::path file = path.parent_path() / name;
      if (fs::exists(file)) list += text_of(file);
    }
    if (list.find(path.filename().string()) == std::string::npos) continue;
    const std::regex pattern(R"((?:BISS_TEST|TEST|TEST_P|TEST_F)\((\w+),\s+(\w+)\))");
    const std::string text = text_of(path);
    for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at) {
      tests.insert((*at)[1].str() + "." + (*at)[2].str());
    }
  }
  return tests;
}

TEST(SafetyDocuments, EveryTestOfTheMatrix_Exists) {
  const std::set<std::string> tests = tests_of_the_build();
  EXPECT_GT(tests.size(), 500U);
  const std::string page = source("docs/safety-matrix.md");
  const std::size_t at = page.find("| requirement | source | test |");
  ASSERT_NE(at, std::string::npos);
  const std::string table = page.substr(at, page.find("\n\n", at) - at);
  std::set<std::string> named;
  std::set<std::string> suites;
  for (const std::string& name : all_of(table, "`((?:Each/)?[A-Z]\\w+\\.\\w+)`")) {
    const std::string plain = name.starts_with("Each/") ? name.substr(5) : name;
    EXPECT_TRUE(tests.contains(plain)) << name;
    named.insert(plain);
    suites.insert(plain.substr(0, plain.find('.')));
  }
  EXPECT_GT(named.size(), 60U);
  // Each row has one.
  for (const std::string& cell : all_of(table, R"(^\|[^|]*\|[^|]*\| (.*) \|$)")) {
    EXPECT_TRUE(cell == "test" || cell == "---" || cell.find('`') != std::string::npos) << cell;
  }
  // Each suite about the monitor has a say.
  for (const char* suite :
       {"SafetyMonitor", "SafetyCounter", "SafetyWords", "SafetyComparison", "SafetyFinding",
        "SafetySelfTest", "SafetySetup", "SafetyTime", "SafetyVerdicts", "SafetyConfigurations"}) {
    EXPECT_TRUE(suites.contains(suite)) << suite;
  }
}

}  // namespace
}  // namespace biss::cli
