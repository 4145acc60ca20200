// Requests so close together that the idle time between them may also be missing edges. The decoder
// must find the end of each request, whatever came before it.
#include <gtest/gtest.h>

#include "decode/test_line.hpp"

namespace biss::decode::test {
namespace decoder_step_test {

// Between two requests MA is idle for 2.1 periods.
const Shape tight{.timeout = nanoseconds(1'500), .gap = nanoseconds(10)};

void add_good(TestLine& line, std::uint64_t cycles) {
  for (std::uint64_t k = 0; k < cycles; ++k) line.request(tight, 0x1234567 + k);
}

// A request of `clocks` clocks without an answer.
void add_silent(TestLine& line, std::size_t clocks) {
  FrameBits bits;
  bits.append_run(true, clocks);
  line.request(tight, bits);
}

// Pulses on MA that are not clocks; the next request follows at the usual distance.
void add_slow_pulses(TestLine& line, int pulses, Picoseconds period) {
  for (int i = 0; i < pulses; ++i) {
    line.ma.push_back(low_at(line.now));
    line.ma.push_back(high_at(line.now + period / 2));
    line.now += period;
  }
  line.now += nanoseconds(1'600) - period / 2;
}

// From this request on there is one good row for each request and no other.
void expect_good_from(const TestLine& line, std::size_t request, std::string_view format) {
  const auto cycles = decode(line, format);
  std::size_t row = 0;
  const auto begin = [&](std::size_t k) { return line.ma[line.begins[k]].time; };
  while (row < cycles.size() && cycles[row].time < begin(request)) ++row;
  ASSERT_EQ(cycles.size() - row, line.begins.size() - request);
  for (std::size_t k = request; k < line.begins.size(); ++k, ++row) {
    EXPECT_EQ(cycles[row].time, begin(k)) << k;
    EXPECT_EQ(name_of(cycles[row].status), "ok") << k;
  }
}

TEST(DecoderStep, SilentRequestBehindALongOne_EndsWhereAFrameBegins) {
  TestLine line;
  add_good(line, 3);
  add_silent(line, 160);
  add_silent(line, 45);
  add_good(line, 6);
  const auto cycles = decode(line);
  ASSERT_EQ(cycles.size(), 11U);
  EXPECT_EQ(name_of(cycles[3].status), "no_response");
  EXPECT_EQ(name_of(cycles[4].status), "no_response");
  EXPECT_EQ(cycles[4].rising_edges, 45U);
  expect_good_from(line, 5, usual_format);
}

TEST(DecoderStep, LastFrameOfTheCapture_EndsTheOneBeforeToo) {
  TestLine line;
  add_good(line, 2);
  add_silent(line, 160);
  add_silent(line, 45);
  add_good(line, 1);
  expect_good_from(line, 4, usual_format);
}

// Bits without a CRC prove no cycle boundary.
TEST(DecoderStep, FrameWithoutChecksum_EndsNothing) {
  constexpr std::string_view format = "pos26,nE,nW";
  TestLine line;
  for (std::uint64_t k = 0; k < 3; ++k) line.request(tight, k, format);
  add_silent(line, 160);
  add_silent(line, 45);
  line.request(tight, 5, format);
  const auto cycles = decode(line, format);
  ASSERT_EQ(cycles.size(), 5U);
  EXPECT_GT(cycles[4].rising_edges, 45U);
}

// MA loses clocks before ACK: the rest looks like a complete answer, but no request began there.
TEST(DecoderStep, EdgesMissingBeforeAck_AreNoBoundary) {
  Shape shape = tight;
  shape.line_delay = nanoseconds(6'000);
  shape.extra_clocks = 5;
  TestLine line;
  for (std::uint64_t k = 0; k < 3; ++k) line.request(shape, 0x1234567 + k);
  const auto at = line.ma.begin() + static_cast<std::ptrdiff_t>(line.begins[1] + 4);
  line.ma.erase(at, at + 2);
  const auto cycles = decode(line);
  ASSERT_EQ(cycles.size(), 3U);
  EXPECT_EQ(name_of(cycles[1].status), "ma_clock");
}

TEST(DecoderStep, SlowPulsesBeforeTightRequests_SpoilOneRequestAtMost) {
  for (const std::int64_t period_us : {5, 10, 15}) {
    SCOPED_TRACE(period_us);
    TestLine line;
    add_good(line, 2);
    add_slow_pulses(line, 12, microseconds(period_us));
    add_good(line, 6);
    expect_good_from(line, 3, usual_format);
  }
}

// Pulses for longer than any request are skipped until the clock is regular again.
TEST(DecoderStep, EndlessSlowPulsesBeforeTightRequests_SpoilOneRequestAtMost) {
  TestLine line;
  add_good(line, 2);
  add_slow_pulses(line, 3'000, microseconds(10));
  add_good(line, 6);
  expect_good_from(line, 3, usual_format);
}

}  // namespace decoder_step_test
}  // namespace biss::decode::test
