#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>
#include <vector>

#include "capture/event_csv.hpp"
#include "capture/test_capture.hpp"
#include "capture/vcd.hpp"
#include "tests/common/long_run.hpp"
#include "tests/common/random.hpp"

namespace biss::capture {
namespace round_trip_test {

struct Capture {
  std::vector<std::string> lines;
  std::vector<wire::Edge> edges;
  Picoseconds end_time;
};

// Lines that change now and then, several at a time, up to the end of the range.
Capture random_capture(std::mt19937_64& random, bool negative_times) {
  Capture capture;
  const std::size_t lines = 1 + random() % 200;
  for (std::size_t i = 0; i < lines; ++i) capture.lines.push_back("line" + std::to_string(i));
  std::vector<int> levels(lines, 3);
  std::int64_t time =
      negative_times ? -static_cast<std::int64_t>(random() >> (1 + random() % 40)) : 0;
  const std::size_t changes = random() % 2'000;
  for (std::size_t i = 0; i < changes; ++i) {
    if (random() % 3 != 0) {
      const auto step = static_cast<std::int64_t>(random() >> (20 + random() % 44));
      if (time > std::numeric_limits<std::int64_t>::max() - step) break;
      time += step;
    }
    const std::size_t line = random() % lines;
    const int level = static_cast<int>(random() % 3);
    if (levels[line] == level) continue;
    levels[line] = level;
    capture.edges.push_back(
        {Picoseconds{time}, static_cast<wire::LineIndex>(line), static_cast<wire::Level>(level)});
  }
  capture.end_time = Picoseconds{time};
  if (time < 1'000'000'000)
    capture.end_time += picoseconds(static_cast<std::int64_t>(random() % 999));
  return capture;
}

template <class Writer>
std::string text_of(const Capture& capture) {
  std::string text;
  StringSink sink(text);
  Writer writer(capture.lines, sink);
  EXPECT_EQ(*writer.write(capture.edges), capture.edges.size());
  EXPECT_TRUE(writer.finish(capture.end_time).ok());
  return text;
}

void expect_same(const Capture& capture, const Read& read) {
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.lines, capture.lines);
  EXPECT_EQ(read.edges, capture.edges);
  EXPECT_EQ(read.end_time, capture.end_time);
}

TEST(RoundTrip, RandomCaptures_ComeBackFromVcd) {
  std::mt19937_64 random = test::random_of(7'301);
  for (std::uint64_t i = 0; i < test::rounds(200, 60) && !testing::Test::HasFailure(); ++i) {
    SCOPED_TRACE(i);
    const Capture capture = random_capture(random, false);
    expect_same(capture, read_vcd(text_of<VcdWriter>(capture), 1 + random() % 10'000));
  }
}

TEST(RoundTrip, RandomCaptures_ComeBackFromEventCsv) {
  std::mt19937_64 random = test::random_of(7'302);
  for (std::uint64_t i = 0; i < test::rounds(200, 60) && !testing::Test::HasFailure(); ++i) {
    SCOPED_TRACE(i);
    const Capture capture = random_capture(random, true);
    expect_same(capture, read_csv(text_of<EventCsvWriter>(capture), 1 + random() % 10'000));
  }
}

TEST(RoundTrip, MoreLinesThanOneCharacterNames_ComeBackFromVcd) {
  Capture capture;
  for (std::size_t i = 0; i < 10'000; ++i) {
    capture.lines.push_back("n" + std::to_string(i));
    capture.edges.push_back({Picoseconds{static_cast<std::int64_t>(i)},
                             static_cast<wire::LineIndex>(i), wire::Level::high});
  }
  capture.end_time = Picoseconds{9'999};
  expect_same(capture, read_vcd(text_of<VcdWriter>(capture)));
}

TEST(RoundTrip, NamesOfEveryKind_ComeBackFromEventCsv) {
  Capture capture;
  capture.lines = {"MA", "a,b", "c;d", "e\tf", "g\"h", " i ", "j k", "#l", "\"", "\xC3\xA9"};
  expect_same(capture, read_csv(text_of<EventCsvWriter>(capture)));
}

}  // namespace round_trip_test
}  // namespace biss::capture
