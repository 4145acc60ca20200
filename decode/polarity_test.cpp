#include "decode/polarity.hpp"

#include <gtest/gtest.h>

#include <string>

#include "decode/test_line.hpp"

namespace biss::decode::test {
namespace polarity_test {

constexpr Lines as_shown{0, 1};

CycleReader reader_with_format() { return {*parse_format(usual_format), {}}; }
CycleReader reader_without_format() { return {std::nullopt, {}}; }

std::vector<wire::Edge> inverted(std::vector<wire::Edge> edges, bool ma, bool slo) {
  for (wire::Edge& edge : edges) {
    if (!(edge.line == 0 ? ma : slo)) continue;
    edge.level = edge.level == wire::Level::low ? wire::Level::high : wire::Level::low;
  }
  return edges;
}

std::vector<wire::Edge> edges_of(const Shape& shape, std::uint64_t requests = 8) {
  TestLine line;
  for (std::uint64_t k = 0; k < requests; ++k) line.request(shape, 0x155'5555 * k & low_mask(26));
  return line.edges();
}

TEST(Polarity, InvertedLines_AreFoundAndReadAsTheyAre) {
  for (const std::int64_t delay_ns : {0, 61, 420, 561, 5'000}) {
    for (const bool ma : {false, true}) {
      for (const bool slo : {false, true}) {
        for (const auto& reader : {reader_with_format(), reader_without_format()}) {
          SCOPED_TRACE(std::to_string(delay_ns) + " ns, " + (ma ? "MA " : "") + (slo ? "SLO" : "") +
                       " inverted");
          const auto edges = inverted(edges_of({.line_delay = nanoseconds(delay_ns)}), ma, slo);
          const Lines found = find_polarity(as_shown, edges, reader);
          EXPECT_EQ(found, (Lines{0, 1, ma, slo}));
          std::vector<Picoseconds> delays;
          Decoder decoder(reader, [&](const Cycle& cycle) {
            EXPECT_TRUE(is_good(cycle.status)) << name_of(cycle.status);
            delays.push_back(cycle.line_delay.value_or(-nanoseconds(1)));
          });
          decoder.push(edges, found);
          decoder.finish(edges.back().time + milliseconds(1));
          EXPECT_EQ(delays, std::vector<Picoseconds>(8, nanoseconds(delay_ns)));
        }
      }
    }
  }
}

TEST(Polarity, InversionThatIsGiven_IsKept) {
  const auto reader = reader_with_format();
  const Lines ma{0, 1, true, false};
  const Lines slo{0, 1, false, true};
  EXPECT_TRUE(find_polarity(ma, edges_of({}), reader).ma_inverted);
  EXPECT_TRUE(find_polarity(slo, edges_of({}), reader).slo_inverted);
  const auto one = inverted(edges_of({}, 1), true, true);
  EXPECT_EQ(find_polarity(ma, one, reader), (Lines{0, 1, true, true}));
  EXPECT_EQ(find_polarity({0, 1, true, true}, one, reader), (Lines{0, 1, true, true}));
}

TEST(Polarity, MaThatRestsLowForCdm_IsNotInverted) {
  const auto reader = reader_with_format();
  for (const Ending ending : {Ending::low_until_timeout, Ending::low_until_next}) {
    TestLine line;
    for (std::uint64_t k = 0; k < 8; ++k) {
      line.request(
          {.line_delay = nanoseconds(700), .ending = k % 3 == 0 ? ending : Ending::idle_high}, k);
    }
    EXPECT_EQ(find_polarity(as_shown, line.edges(), reader), as_shown);
  }
  const Shape always{.line_delay = nanoseconds(700), .ending = Ending::low_until_timeout};
  EXPECT_EQ(find_polarity(as_shown, edges_of(always), reader), as_shown);
}

TEST(Polarity, NoEncoder_NothingIsInverted) {
  for (const wire::Level level : {wire::Level::low, wire::Level::high}) {
    TestLine line;
    for (std::uint64_t k = 0; k < 8; ++k) line.request({}, k);
    line.slo = {{Picoseconds{}, level}};
    EXPECT_EQ(find_polarity(as_shown, line.edges(), reader_with_format()), as_shown);
  }
}

TEST(Polarity, WrongFormat_InvertedLinesAreFoundToo) {
  const CycleReader reader(*parse_format("pos24,nE,nW,crc6"), {});
  EXPECT_EQ(find_polarity(as_shown, inverted(edges_of({}), true, true), reader),
            (Lines{0, 1, true, true}));
  EXPECT_EQ(find_polarity(as_shown, edges_of({}), reader), as_shown);
}

}  // namespace polarity_test
}  // namespace biss::decode::test
