// A master that pauses its clock within a request: an SPI master between bytes, an interrupt. The
// clocks on both sides of a pause are one request if only together they are a right frame.
#include <gtest/gtest.h>

#include "decode/limits.hpp"
#include "decode/polarity.hpp"
#include "decode/test_line.hpp"

namespace biss::decode {
namespace pause_test {

using test::Shape;
using test::TestLine;

const std::vector<std::int64_t> each_byte{8, 16, 24, 32};

Shape paused(Picoseconds pause, std::vector<std::int64_t> before) {
  Shape shape;
  shape.pauses = std::move(before);
  shape.pause = pause;
  return shape;
}

std::vector<CycleStatus> statuses(const std::vector<Cycle>& cycles) {
  std::vector<CycleStatus> all;
  for (const Cycle& cycle : cycles) all.push_back(cycle.status);
  return all;
}

void expect_positions(const std::vector<Cycle>& cycles, std::size_t count, std::uint64_t first) {
  ASSERT_EQ(statuses(cycles), std::vector<CycleStatus>(count, CycleStatus::ok));
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(cycles[i].frame->channels()[0].position, first + i * 1001) << i;
  }
}

std::vector<Cycle> decode_paused(const Shape& shape, const DeviceTiming& timing = {}) {
  TestLine line;
  for (std::uint64_t i = 0; i < 20; ++i) line.request(shape, 1'000'000 + i * 1001);
  return test::decode(line, test::usual_format, timing);
}

DeviceTiming with_timeout(Picoseconds time) {
  DeviceTiming timing;
  timing.timeout = {TimeoutRule::fixed, time};
  return timing;
}

TEST(Pause, PausesOfAnyLengthAfterEachByte_OneRowARequestWithItsPosition) {
  for (const std::int64_t tenths : {5, 6, 7, 8, 9, 10, 12, 15, 20, 30, 40, 60, 100, 160}) {
    SCOPED_TRACE(tenths);
    expect_positions(decode_paused(paused(nanoseconds(tenths * 100), each_byte)), 20, 1'000'000);
  }
}

TEST(Pause, PauseBeforeAnyClock_OneRowARequestWithItsPosition) {
  for (std::int64_t clock = 1; clock <= 40; ++clock) {
    for (const std::int64_t tenths : {7, 15, 80}) {
      SCOPED_TRACE(testing::Message() << clock << ' ' << tenths);
      expect_positions(decode_paused(paused(nanoseconds(tenths * 100), {clock})), 20, 1'000'000);
    }
  }
}

TEST(Pause, InSomeRequestsOnly_AllRowsAreOk) {
  TestLine line;
  for (std::uint64_t i = 0; i < 40; ++i) {
    const bool interrupted = i % 10 == 3;
    line.request(interrupted ? paused(microseconds(8), {17}) : Shape{}, 5000 + i * 1001);
  }
  expect_positions(test::decode(line), 40, 5000);
}

TEST(Pause, RowsWithPauses_CountThemAndExceedClockChangeOnlyWhereItIsForbidden) {
  const Shape shape = paused(microseconds(8), {17, 25});
  DeviceTiming constant;
  constant.clock_constant = true;
  for (const bool forbidden : {false, true}) {
    const DeviceTiming timing = forbidden ? constant : DeviceTiming{};
    LimitWatch limits(timing);
    for (const Cycle& cycle : decode_paused(shape, timing)) {
      EXPECT_EQ(cycle.pauses, 2U);
      EXPECT_EQ(text_of(limits.judge(cycle)), forbidden ? "clock_change" : "");
    }
  }
}

TEST(Pause, LongerThanTheTimeoutThatIsGiven_TwoRows) {
  const Shape shape = paused(microseconds(8), {17});
  const auto cycles = decode_paused(shape, with_timeout(microseconds(5)));
  EXPECT_EQ(cycles.size(), 40U);
  EXPECT_EQ(cycles[0].status, CycleStatus::truncated);
  expect_positions(decode_paused(shape, with_timeout(microseconds(20))), 20, 1'000'000);
}

// The encoder releases SLO after 20 us in each request: a longer pause would end a request too.
TEST(Pause, LongerThanTheTimeoutThatIsSeen_TwoRows) {
  TestLine line;
  for (std::uint64_t i = 0; i < 5; ++i) line.request(Shape{}, 5000 + i * 1001);
  line.request(paused(microseconds(30), {17}), 77);
  const auto cycles = test::decode(line);
  ASSERT_EQ(cycles.size(), 7U);
  EXPECT_EQ(cycles[5].status, CycleStatus::truncated);
}

TEST(Pause, WrongChecksum_OneRowOnlyWhereTheTimeoutIsKnown) {
  FrameBits bits = test::bits_of(test::usual_format, 4711);
  FrameBits wrong;
  for (std::size_t i = 0; i < bits.size_bits(); ++i) wrong.append(bits.view()[i] != (i == 20));
  TestLine line;
  for (int i = 0; i < 5; ++i) line.request(paused(microseconds(8), {17}), wrong);
  const auto known = test::decode(line, test::usual_format, with_timeout(microseconds(20)));
  EXPECT_EQ(statuses(known), std::vector<CycleStatus>(5, CycleStatus::crc));
  EXPECT_EQ(test::decode(line).size(), 10U);
}

TEST(Pause, WithoutFormat_OneRowOnlyWhereTheTimeoutIsKnown) {
  TestLine line;
  for (std::uint64_t i = 0; i < 5; ++i) line.request(paused(microseconds(8), {17}), 4711 + i);
  const auto known = test::decode(line, "", with_timeout(microseconds(20)));
  ASSERT_EQ(statuses(known), std::vector<CycleStatus>(5, CycleStatus::unchecked));
  EXPECT_EQ(known[0].rising_edges, test::bits_of(test::usual_format, 0).size_bits());
  EXPECT_EQ(test::decode(line, "").size(), 10U);
}

TEST(Pause, RequestThatFailedBeforeARightOne_StaysTwoRows) {
  for (const Picoseconds gap : {microseconds(5), microseconds(7), microseconds(15)}) {
    for (const std::size_t clocks : {3U, 9U, 20U, 36U}) {
      for (const DeviceTiming& timing : {DeviceTiming{}, with_timeout(microseconds(20))}) {
        SCOPED_TRACE(testing::Message() << gap.count << ' ' << clocks);
        Shape shape;
        shape.timeout = microseconds(1);
        shape.gap = gap;
        TestLine line;
        const FrameBits whole = test::bits_of(test::usual_format, 123456);
        FrameBits cut;
        cut.append(whole.view().first(clocks));
        for (int i = 0; i < 4; ++i) {
          line.request(shape, cut);
          line.request(shape, whole);
        }
        const auto cycles = test::decode(line, test::usual_format, timing);
        ASSERT_EQ(cycles.size(), 8U);
        for (std::size_t i = 1; i < 8; i += 2) {
          EXPECT_EQ(cycles[i].status, CycleStatus::ok);
          EXPECT_NE(cycles[i - 1].status, CycleStatus::ok);
        }
      }
    }
  }
}

// The line of a capture that has lost a clock: the frame has one less than the others.
TEST(Pause, ClockMissingInTheCapture_IsNeverOk) {
  for (std::size_t clock = 3; clock < 39; ++clock) {
    TestLine line;
    for (std::uint64_t i = 0; i < 3; ++i) line.request(Shape{}, 0x2AAAAAA);
    const std::size_t edge = line.begins.back() + 2 * clock;
    line.ma.erase(line.ma.begin() + static_cast<std::ptrdiff_t>(edge),
                  line.ma.begin() + static_cast<std::ptrdiff_t>(edge) + 2);
    const auto cycles = test::decode(line);
    ASSERT_EQ(cycles.size(), 3U) << clock;
    EXPECT_NE(cycles[2].status, CycleStatus::ok) << clock;
  }
}

// At 10 MHz and 100 m of cable, ten bits are on their way when the clock pauses.
TEST(Pause, LineDelayOfManyClocks_OneRowARequest) {
  Shape shape = paused(microseconds(2), each_byte);
  shape.period = nanoseconds(100);
  shape.line_delay = nanoseconds(1'030);
  expect_positions(decode_paused(shape), 20, 1'000'000);
}

TEST(Pause, MaRestsLowInThePause_OneRowARequest) {
  TestLine line;
  for (std::uint64_t i = 0; i < 5; ++i) {
    line.request(Shape{}, 9000 + i * 1001);
    // The falling edge before the pause stays at its time.
    const std::size_t begin = line.begins.back();
    const Picoseconds pause = microseconds(6);
    const Picoseconds from = line.ma[begin + 2 * 17 + 1].time;
    for (auto* changes : {&line.ma, &line.slo}) {
      for (LevelChange& change : *changes) {
        if (change.time >= from) change.time += pause;
      }
    }
    line.now += pause;
  }
  expect_positions(test::decode(line), 5, 9000);
}

// Delays of 0.1 us and a clock less or more of the encoder.
TEST(Pause, EncoderThatCountsAClockMoreOrLess_HasItsUsualDelay) {
  for (const std::int64_t clocks : {-1, 1}) {
    Shape shape;
    shape.line_delay = nanoseconds(1'100);
    TestLine line;
    for (int i = 0; i < 6; ++i) {
      const std::size_t slo = line.slo.size();
      line.request(shape, 4711);
      if (i != 3) continue;
      for (std::size_t k = slo; k + 1 < line.slo.size(); ++k) {
        line.slo[k].time += clocks * shape.period;
      }
    }
    for (const Cycle& cycle : test::decode(line)) {
      EXPECT_EQ(cycle.line_delay, shape.line_delay);
      if (cycle.ack_edge != 1) {
        EXPECT_EQ(cycle.ack_edge, clocks < 0 ? 0U : 2U);
      }
    }
  }
}

TEST(Pause, CaptureWithPausesInEachRequest_ShowsTheTimeout) {
  TestLine line;
  for (std::uint64_t i = 0; i < 40; ++i) line.request(paused(microseconds(1), each_byte), 1000 * i);
  const auto timeout = find_paused_timeout({0, 1}, line.edges());
  ASSERT_TRUE(timeout);
  EXPECT_GT(timeout->time, microseconds(19));
  EXPECT_LT(timeout->time, microseconds(21));
  TestLine even;
  for (std::uint64_t i = 0; i < 40; ++i) even.request(Shape{}, 1000 * i);
  EXPECT_FALSE(find_paused_timeout({0, 1}, even.edges()));
}

}  // namespace pause_test
}  // namespace biss::decode
