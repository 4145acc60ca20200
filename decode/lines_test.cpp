#include "decode/lines.hpp"

#include <gtest/gtest.h>

#include <string>

#include "decode/test_line.hpp"

namespace biss::decode::test {
namespace {

using Names = std::vector<std::string>;

CycleReader reader_with_format() { return {*parse_format(usual_format), {}}; }
CycleReader reader_without_format() { return {std::nullopt, {}}; }

// MA and SLO as these lines of a capture.
std::vector<wire::Edge> edges_on(wire::LineIndex ma, wire::LineIndex slo,
                                 std::uint64_t requests = 8) {
  Line line;
  for (std::uint64_t k = 0; k < requests; ++k) line.request({}, 0x155'5555 * k & low_mask(26));
  auto edges = line.edges();
  for (wire::Edge& edge : edges) edge.line = edge.line == 0 ? ma : slo;
  return edges;
}

void expect_lines(const Result<FoundLines, LineProblem>& found, Lines lines, LineChoice how) {
  ASSERT_TRUE(found.ok()) << static_cast<int>(found.error());
  EXPECT_EQ(found->lines.ma, lines.ma);
  EXPECT_EQ(found->lines.slo, lines.slo);
  EXPECT_EQ(found->how, how);
}

TEST(Lines, UsualNames_AreFoundWithoutRegardToCaseAndScope) {
  const auto reader = reader_with_format();
  expect_lines(find_lines(Names{"SLO", "MA"}, {}, "", "", reader), {1, 0}, LineChoice::by_name);
  expect_lines(find_lines(Names{"top.dut.ma", "top.dut.slo"}, {}, "", "", reader), {0, 1},
               LineChoice::by_name);
  expect_lines(find_lines(Names{"MA", "SLO", "MA_at_slave", "SLO_at_slave"}, {}, "", "", reader),
               {0, 1}, LineChoice::by_name);
  expect_lines(find_lines(Names{"Data", "Clock"}, {}, "", "", reader), {1, 0}, LineChoice::by_name);
}

TEST(Lines, NamesGiven_WinOverTheUsualOnes) {
  const auto reader = reader_with_format();
  const Names names{"MA", "SLO", "MA_at_slave", "SLO_at_slave"};
  expect_lines(find_lines(names, {}, "MA_at_slave", "slo_at_slave", reader), {2, 3},
               LineChoice::told);
  expect_lines(find_lines(names, {}, "", "SLO_at_slave", reader), {0, 3}, LineChoice::by_name);
}

TEST(Lines, NamesThatAreNotThere_AreNamedApart) {
  const auto reader = reader_with_format();
  const Names names{"MA", "SLO"};
  EXPECT_EQ(find_lines(names, {}, "X", "", reader).error(), LineProblem::no_such_ma);
  EXPECT_EQ(find_lines(names, {}, "", "X", reader).error(), LineProblem::no_such_slo);
  EXPECT_EQ(find_lines(names, {}, "MA", "MA", reader).error(), LineProblem::same_line);
}

TEST(Lines, NoNames_AreFoundByBehaviourEitherWayRound) {
  const Names names{"D0", "D1"};
  for (const auto& reader : {reader_with_format(), reader_without_format()}) {
    expect_lines(find_lines(names, edges_on(0, 1), "", "", reader), {0, 1},
                 LineChoice::by_behaviour);
    expect_lines(find_lines(names, edges_on(1, 0), "", "", reader), {1, 0},
                 LineChoice::by_behaviour);
  }
}

TEST(Lines, NamesTheWrongWayRound_AreKeptAndSaidToLookSwapped) {
  const auto reader = reader_with_format();
  const auto swapped = find_lines(Names{"MA", "SLO"}, edges_on(1, 0), "", "", reader);
  expect_lines(swapped, {0, 1}, LineChoice::by_name);
  EXPECT_TRUE(swapped->look_swapped);
  EXPECT_FALSE(find_lines(Names{"MA", "SLO"}, edges_on(0, 1), "", "", reader)->look_swapped);
}

TEST(Lines, OneNameGiven_TheOtherIsFoundByBehaviour) {
  const Names names{"D0", "D1", "D2"};
  const auto reader = reader_with_format();
  expect_lines(find_lines(names, edges_on(2, 0), "D2", "", reader), {2, 0},
               LineChoice::by_behaviour);
  expect_lines(find_lines(names, edges_on(2, 0), "", "D0", reader), {2, 0},
               LineChoice::by_behaviour);
}

TEST(Lines, SixteenLines_TheRightTwoAreFound) {
  Names names;
  for (int i = 0; i < 16; ++i) names.push_back("D" + std::to_string(i));
  auto edges = edges_on(11, 6);
  // Others: a second clock, a slow toggle, one that never moves.
  const Picoseconds end = edges.back().time;
  for (Picoseconds now{}; now < end; now += nanoseconds(700)) {
    edges.push_back({now, 3, now.count % 1'400'000 == 0 ? wire::Level::low : wire::Level::high});
    edges.push_back(
        {now, 9, now.count % 2'800'000 < 700'000 ? wire::Level::low : wire::Level::high});
  }
  std::stable_sort(edges.begin(), edges.end(),
                   [](const wire::Edge& a, const wire::Edge& b) { return a.time < b.time; });
  for (const auto& reader : {reader_with_format(), reader_without_format()}) {
    expect_lines(find_lines(names, edges, "", "", reader), {11, 6}, LineChoice::by_behaviour);
  }
}

TEST(Lines, FewerThanTwoLinesMove_IsNamed) {
  const auto reader = reader_with_format();
  EXPECT_EQ(find_lines(Names{"D0", "D1"}, {}, "", "", reader).error(), LineProblem::too_few_lines);
  EXPECT_EQ(find_lines(Names{}, {}, "", "", reader).error(), LineProblem::too_few_lines);
}

TEST(Lines, NothingLikeMaAndSlo_IsNamed) {
  std::vector<wire::Edge> edges;
  for (int i = 0; i < 400; ++i) {
    const auto level = i % 2 == 0 ? wire::Level::low : wire::Level::high;
    edges.push_back({microseconds(100 * i), 0, level});
    edges.push_back({microseconds(100 * i + 30), 1, level});
  }
  EXPECT_EQ(find_lines(Names{"D0", "D1"}, edges, "", "", reader_with_format()).error(),
            LineProblem::nothing_behaves);
}

}  // namespace
}  // namespace biss::decode::test
