#include "decode/lines.hpp"

#include <gtest/gtest.h>

#include <string>

#include "decode/test_line.hpp"

namespace biss::decode::test {
namespace lines_test {

using Names = std::vector<std::string>;

CycleReader reader_with_format() { return {*parse_format(usual_format), {}}; }
CycleReader reader_without_format() { return {std::nullopt, {}}; }

// MA and SLO as these lines of a capture. Encoders of another `step` have other positions.
std::vector<wire::Edge> edges_on(wire::LineIndex ma, wire::LineIndex slo,
                                 std::uint64_t step = 0x155'5555) {
  TestLine line;
  for (std::uint64_t k = 0; k < 8; ++k) line.request({}, (1 + step * k) & low_mask(26));
  auto edges = line.edges();
  for (wire::Edge& edge : edges) edge.line = edge.line == 0 ? ma : slo;
  return edges;
}

using Found = tl::expected<std::vector<FoundLines>, LineError>;

void expect_lines(const Found& found, Lines lines, LineOrigin origin) {
  ASSERT_TRUE(found) << static_cast<int>(found.error().problem);
  ASSERT_EQ(found->size(), 1U);
  EXPECT_EQ(found->front().lines, lines);
  EXPECT_EQ(found->front().origin, origin);
}

void expect_problem(const Found& found, LineProblem problem,
                    const std::vector<Lines>& candidates = {}) {
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().problem, problem);
  EXPECT_EQ(found.error().candidates, candidates);
}

// Edges of several encoders in time order.
std::vector<wire::Edge> together(const std::vector<std::vector<wire::Edge>>& captures) {
  std::vector<wire::Edge> all;
  for (const auto& capture : captures) all.insert(all.end(), capture.begin(), capture.end());
  std::stable_sort(all.begin(), all.end(),
                   [](const wire::Edge& a, const wire::Edge& b) { return a.time < b.time; });
  return all;
}

TEST(Lines, NoNamesAndInvertedLines_AreFoundByBehaviour) {
  for (const auto& [ma, slo] : {std::pair{true, false}, {false, true}, {true, true}}) {
    auto edges = edges_on(1, 0);
    for (wire::Edge& edge : edges) {
      if (!(edge.line == 1 ? ma : slo)) continue;
      edge.level = edge.level == wire::Level::low ? wire::Level::high : wire::Level::low;
    }
    for (const auto& reader : {reader_with_format(), reader_without_format()}) {
      expect_lines(find_lines(Names{"D0", "D1"}, edges, {"", ""}, reader), {1, 0, ma, slo},
                   LineOrigin::by_behaviour);
    }
  }
}

TEST(Lines, UsualNames_AreFoundWithoutRegardToCaseAndScope) {
  const auto reader = reader_with_format();
  expect_lines(find_lines(Names{"SLO", "MA"}, {}, {"", ""}, reader), {1, 0}, LineOrigin::by_name);
  expect_lines(find_lines(Names{"top.dut.ma", "top.dut.slo"}, {}, {"", ""}, reader), {0, 1},
               LineOrigin::by_name);
  expect_lines(find_lines(Names{"MA", "SLO", "MA_at_slave", "SLO_at_slave"}, {}, {"", ""}, reader),
               {0, 1}, LineOrigin::by_name);
  expect_lines(find_lines(Names{"Data", "Clock"}, {}, {"", ""}, reader), {1, 0},
               LineOrigin::by_name);
}

TEST(Lines, NamesGiven_WinOverTheUsualOnes) {
  const auto reader = reader_with_format();
  const Names names{"MA", "SLO", "MA_at_slave", "SLO_at_slave"};
  expect_lines(find_lines(names, {}, {"MA_at_slave", "slo_at_slave"}, reader), {2, 3},
               LineOrigin::given);
  expect_lines(find_lines(names, {}, {"", "SLO_at_slave"}, reader), {0, 3}, LineOrigin::by_name);
}

TEST(Lines, NamesThatAreNotThere_AreNamedApart) {
  const auto reader = reader_with_format();
  const Names names{"MA", "SLO"};
  expect_problem(find_lines(names, {}, {"X", ""}, reader), LineProblem::no_such_ma);
  expect_problem(find_lines(names, {}, {"", "X"}, reader), LineProblem::no_such_slo);
  expect_problem(find_lines(names, {}, {"MA", "MA"}, reader), LineProblem::same_line);
}

TEST(Lines, NoNames_AreFoundByBehaviourEitherWayRound) {
  const Names names{"D0", "D1"};
  for (const auto& reader : {reader_with_format(), reader_without_format()}) {
    expect_lines(find_lines(names, edges_on(0, 1), {"", ""}, reader), {0, 1},
                 LineOrigin::by_behaviour);
    expect_lines(find_lines(names, edges_on(1, 0), {"", ""}, reader), {1, 0},
                 LineOrigin::by_behaviour);
  }
}

TEST(Lines, NamesTheWrongWayRound_AreKeptAndSaidToLookSwapped) {
  const auto reader = reader_with_format();
  const auto swapped = find_lines(Names{"MA", "SLO"}, edges_on(1, 0), {"", ""}, reader);
  expect_lines(swapped, {0, 1}, LineOrigin::by_name);
  EXPECT_TRUE(swapped->front().look_swapped);
  const auto right = find_lines(Names{"MA", "SLO"}, edges_on(0, 1), {"", ""}, reader);
  EXPECT_FALSE(right->front().look_swapped);
}

TEST(Lines, OneNameGiven_TheOtherIsFoundByBehaviour) {
  const Names names{"D0", "D1", "D2"};
  const auto reader = reader_with_format();
  expect_lines(find_lines(names, edges_on(2, 0), {"D2", ""}, reader), {2, 0},
               LineOrigin::by_behaviour);
  expect_lines(find_lines(names, edges_on(2, 0), {"", "D0"}, reader), {2, 0},
               LineOrigin::by_behaviour);
}

TEST(Lines, SixteenLines_TheRightTwoAreFound) {
  Names names;
  for (int i = 0; i < 16; ++i) names.push_back("D" + std::to_string(i));
  auto edges = edges_on(11, 6);
  // Other lines: a second clock, a slow toggle, one without changes.
  const Picoseconds end = edges.back().time;
  for (Picoseconds now{}; now < end; now += nanoseconds(700)) {
    edges.push_back({now, 3, now.count % 1'400'000 == 0 ? wire::Level::low : wire::Level::high});
    edges.push_back(
        {now, 9, now.count % 2'800'000 < 700'000 ? wire::Level::low : wire::Level::high});
  }
  std::stable_sort(edges.begin(), edges.end(),
                   [](const wire::Edge& a, const wire::Edge& b) { return a.time < b.time; });
  for (const auto& reader : {reader_with_format(), reader_without_format()}) {
    expect_lines(find_lines(names, edges, {"", ""}, reader), {11, 6}, LineOrigin::by_behaviour);
  }
}

TEST(Lines, FewerThanTwoLinesMove_IsNamed) {
  const auto reader = reader_with_format();
  expect_problem(find_lines(Names{"D0", "D1"}, {}, {"", ""}, reader), LineProblem::too_few_lines);
  expect_problem(find_lines(Names{}, {}, {"", ""}, reader), LineProblem::too_few_lines);
}

TEST(Lines, NothingLikeMaAndSlo_IsNamed) {
  std::vector<wire::Edge> edges;
  for (int i = 0; i < 400; ++i) {
    const auto level = i % 2 == 0 ? wire::Level::low : wire::Level::high;
    edges.push_back({microseconds(100 * i), 0, level});
    edges.push_back({microseconds(100 * i + 30), 1, level});
  }
  expect_problem(find_lines(Names{"D0", "D1"}, edges, {"", ""}, reader_with_format()),
                 LineProblem::nothing_behaves);
}

TEST(Lines, TwoScopes_AreNotPairedCrosswise) {
  const auto reader = reader_with_format();
  // The result does not depend on the order of the lines in the file.
  const Names names{"enc1.MA", "enc2.MA", "enc2.SLO", "enc1.SLO"};
  const auto edges = together({edges_on(0, 3), edges_on(1, 2, 0x12'3457)});
  expect_problem(find_lines(names, edges, {"", ""}, reader), LineProblem::ambiguous,
                 {{0, 3}, {1, 2}});
  expect_lines(find_lines(names, edges, {"enc1.MA", ""}, reader), {0, 3}, LineOrigin::by_name);
  expect_lines(find_lines(names, edges, {"", "enc2.slo"}, reader), {1, 2}, LineOrigin::by_name);
  expect_lines(find_lines(names, edges, {"enc1.MA", "SLO"}, reader), {0, 3}, LineOrigin::given);
  expect_problem(find_lines(names, edges, {"MA", "SLO"}, reader), LineProblem::ambiguous,
                 {{0, 3}, {1, 2}});
}

TEST(Lines, NumberedNames_ArePairedByTheirNumber) {
  const auto reader = reader_with_format();
  const Names names{"MA1", "SLO1", "MA2", "SLO2"};
  const auto edges = together({edges_on(0, 1), edges_on(2, 3, 0x12'3457)});
  expect_problem(find_lines(names, edges, {"", ""}, reader), LineProblem::ambiguous,
                 {{0, 1}, {2, 3}});
  expect_lines(find_lines(names, edges, {"MA2", ""}, reader), {2, 3}, LineOrigin::by_name);
  expect_lines(find_lines(Names{"enc1_MA", "enc1_SLO", "X"}, edges_on(0, 1), {"", ""}, reader),
               {0, 1}, LineOrigin::by_name);
}

TEST(Lines, TwoEncodersWithoutNames_AreRefusedWithTheirCandidates) {
  const auto edges = together({edges_on(0, 1), edges_on(2, 3, 0x12'3457)});
  const Names names{"D0", "D1", "D2", "D3"};
  for (const auto& reader : {reader_with_format(), reader_without_format()}) {
    const auto found = find_lines(names, edges, {"", ""}, reader);
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().problem, LineProblem::ambiguous);
    EXPECT_EQ(found.error().candidates.size(), 4U);  // one clock: pairs of MA and SLO are ambiguous
    EXPECT_FALSE(find_lines(names, edges, {"D0", ""}, reader));
    expect_lines(find_lines(names, edges, {"D0", "D1"}, reader), {0, 1}, LineOrigin::given);
  }
}

TEST(Lines, OneOfTwoScopesIsSilent_TheOtherIsTaken) {
  const Names names{"enc1.MA", "enc1.SLO", "enc2.MA", "enc2.SLO"};
  const auto found = find_lines(names, edges_on(2, 3), {"", ""}, reader_with_format());
  expect_lines(found, {2, 3}, LineOrigin::by_name);
  EXPECT_TRUE(found->front().further_pairs);
}

TEST(Lines, TheSameDataInTwoScopes_IsOneEncoder) {
  const Names names{"tb.MA", "tb.SLO", "tb.dut.MA", "tb.dut.SLO"};
  const auto edges = together({edges_on(0, 1), edges_on(2, 3)});
  expect_lines(find_lines(names, edges, {"", ""}, reader_with_format()), {0, 1},
               LineOrigin::by_name);
}

TEST(Lines, Each_FindsEveryPair) {
  const auto reader = reader_with_format();
  const auto edges = together({edges_on(0, 1), edges_on(2, 3, 0x12'3457)});
  const auto pairs_of = [&](const Names& names, std::string_view ma) {
    std::vector<Lines> pairs;
    const auto found = find_lines(names, edges, {ma, "", true}, reader);
    if (found) {
      for (const FoundLines& each : *found) pairs.push_back(each.lines);
    }
    return pairs;
  };
  const std::vector<Lines> both{{0, 1}, {2, 3}};
  EXPECT_EQ(pairs_of({"MA1", "SLO1", "MA2", "SLO2"}, ""), both);
  EXPECT_EQ(pairs_of({"a.MA", "a.SLO", "b.MA", "b.SLO"}, ""), both);
  EXPECT_EQ(pairs_of({"MA", "SLO", "CLK", "DATA"}, ""), both);
  EXPECT_EQ(pairs_of({"MA", "SLO1", "X", "SLO2"}, ""), (std::vector<Lines>{{0, 1}, {0, 3}}));
  EXPECT_EQ(pairs_of({"MA_A", "SLO_A", "MA_B", "SLO_B"}, ""), both);
  EXPECT_EQ(pairs_of({"D0", "D1", "D2", "D3"}, "D2"), (std::vector<Lines>{{2, 1}, {2, 3}}));
  expect_problem(find_lines({"D0", "D1", "D2", "D3"}, edges, {"", "", true}, reader),
                 LineProblem::ambiguous, {{0, 1}, {0, 3}, {2, 1}, {2, 3}});
}

TEST(Lines, EncodersWithTheSameClocks_ArePairedByNamesOrRefused) {
  const auto reader = reader_with_format();
  const auto edges = together({edges_on(0, 1), edges_on(2, 3, 0x12'3457)});
  const Names files{"ma_a.csv:MA", "slo_a.csv:SLO", "ma_b.csv:MA", "slo_b.csv:SLO"};
  for (const bool each : {false, true}) {
    const auto found = find_lines(files, edges, {"", "", each}, reader);
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().problem, LineProblem::ambiguous);
    EXPECT_FALSE(found.error().each_helps);
  }
  const auto numbered = find_lines({"a.MA", "a.SLO", "b.MA", "b.SLO"}, edges, {}, reader);
  ASSERT_FALSE(numbered);
  EXPECT_TRUE(numbered.error().each_helps);
}

TEST(Lines, MaAlone_IsFoundByNameOrRefused) {
  const auto reader = reader_with_format();
  const auto edges = together({edges_on(0, 1), edges_on(2, 3, 0x12'3457)});
  EXPECT_EQ(find_ma({"X", "top.ma"}, {}, "", reader).value(), 1U);
  EXPECT_EQ(find_ma({"X"}, {}, "", reader).value(), 0U);
  EXPECT_EQ(find_ma({"a.MA", "a.SLO", "b.MA", "b.SLO"}, edges, "b.MA", reader).value(), 2U);
  const auto tie = find_ma({"a.MA", "a.SLO", "b.MA", "b.SLO"}, edges, "", reader);
  ASSERT_FALSE(tie);
  EXPECT_EQ(tie.error().candidates, (std::vector<Lines>{{0, 0}, {2, 2}}));
  EXPECT_EQ(find_ma({"X"}, {}, "MA", reader).error().problem, LineProblem::no_such_ma);
}

}  // namespace lines_test
}  // namespace biss::decode::test
