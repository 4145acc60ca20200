// What recognise_protocol() takes captures of other protocols for, on a sample that runs quickly.
#include <gtest/gtest.h>

#include "tests/other_lines/generators.hpp"
#include "tests/other_lines/score.hpp"

namespace biss::other_lines::recognise_test {

using identify::Protocol;

identify::ProtocolGuess best(const Capture& capture) {
  return identify::recognise_protocol(capture.edges, capture.lines, capture.sample_period,
                                      capture.end)
      .front();
}

TEST(Recognise, NoEdges_IsIdle) {
  EXPECT_EQ(identify::recognise_protocol({}, 0, {}, {}).front().protocol, Protocol::idle);
  const std::vector<wire::Edge> still{{{}, 0, wire::Level::high}, {{}, 1, wire::Level::low}};
  EXPECT_EQ(identify::recognise_protocol(still, 2, {}, {}).front().protocol, Protocol::idle);
}

TEST(Recognise, EdgesOfLinesThatDoNotExist_AreIgnored) {
  const std::vector<wire::Edge> edges{{{}, 7, wire::Level::high},
                                      {nanoseconds(1), 7, wire::Level::low}};
  EXPECT_EQ(identify::recognise_protocol(edges, 2, {}, nanoseconds(2)).front().protocol,
            Protocol::idle);
}

TEST(Recognise, AllEdgesAtOneTime_IsNotBissC) {
  std::vector<wire::Edge> edges;
  for (unsigned i = 0; i < 4'000; ++i) {
    edges.push_back({nanoseconds(5), i % 2, i / 2 % 2 == 0 ? wire::Level::high : wire::Level::low});
  }
  EXPECT_NE(identify::recognise_protocol(edges, 2, {}, nanoseconds(5)).front().protocol,
            Protocol::biss_c);
}

TEST(Recognise, MasterWithoutEncoder_IsAClockAlone) {
  Dice dice(1);
  Drawing drawing;
  drawing.lines = {Wave(true), Wave(true)};
  Picoseconds time = microseconds(10);
  for (int i = 0; i < 30; ++i, time += microseconds(80)) {
    for (int k = 0; k < 46; ++k, time += microseconds(1)) {
      drawing.lines[0].set(time, false);
      drawing.lines[0].set(time + nanoseconds(500), true);
    }
  }
  drawing.end = time;
  drawing.finest = microseconds(1);
  const auto guess = best(captured(drawing, dice));
  EXPECT_EQ(guess.protocol, Protocol::clock_alone);
  EXPECT_NE(guess.why.find("bursts of a clock of 1000 kHz"), std::string::npos) << guess.why;
}

TEST(Recognise, SampleOfEveryProtocol_IsNamedAndNeverTakenForBissC) {
  const Score result = score(9, 100, 50);
  for (const Row& row : result.rows) {
    if (row.protocol == Protocol::biss_c) continue;
    EXPECT_EQ(row.taken_for_biss, 0U) << row.name << "\n" << result.wrong;
    if (row.protocol == Protocol::noise || row.protocol == Protocol::unknown) continue;
    EXPECT_GE(row.right() + 1, row.all) << row.name << "\n" << result.wrong;
  }
}

TEST(Recognise, CapturesOfBissC_AreBissC) {
  const Row row = score(8, 0, 50).row("BiSS C");
  EXPECT_EQ(row.right(), row.all);
  EXPECT_GE(row.least_biss, 0.9);
}

}  // namespace biss::other_lines::recognise_test
