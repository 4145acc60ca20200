// `marginal`: the least distance between a change of SLO and a sampling instant.
#include <gtest/gtest.h>

#include <algorithm>

#include "decode/test_line.hpp"

namespace biss::decode::test {
namespace margin_test {

constexpr Picoseconds period = nanoseconds(1'000);

std::vector<Cycle> decode_with(const TestLine& line, const MarginSetup& margin,
                               std::string_view format = usual_format) {
  return decode(line.edges(), line.last_time() + milliseconds(1), format, {}, margin);
}

std::optional<bool> marginal(const TestLine& line, const MarginSetup& margin = {},
                             std::string_view format = usual_format) {
  const auto cycles = decode_with(line, margin, format);
  return cycles.size() == 1 ? cycles[0].marginal : std::nullopt;
}

// One request. One change of SLO in the middle of the data is late or early, so that it is
// `distance` from a sampling instant. The instant follows the mean of all changes, which includes
// this one.
TestLine with_change_at(Picoseconds distance, bool late) {
  TestLine line;
  line.request({}, 0x1555555);
  const Picoseconds last_rise = line.ma.back().time;
  const auto counted = std::count_if(line.slo.begin() + 1, line.slo.end(), [&](const auto& change) {
    return change.time < last_rise + period;
  });
  EXPECT_GT(counted, 20);
  const Picoseconds by = (period / 2 - distance) * counted / (counted - 1);
  line.slo[12].time += late ? by : -1 * by;
  return line;
}

TEST(Margin, ChangeWithinFivePercentOfASample_IsMarginal) {
  for (const bool late : {true, false}) {
    SCOPED_TRACE(late);
    EXPECT_EQ(marginal(with_change_at(nanoseconds(49), late)), true);
    EXPECT_EQ(marginal(with_change_at(nanoseconds(51), late)), false);
    EXPECT_EQ(marginal(with_change_at(nanoseconds(300), late)), false);
  }
}

TEST(Margin, IsAFlag_ThePositionIsThere) {
  const auto cycles = decode(with_change_at(nanoseconds(49), true));
  ASSERT_EQ(cycles.size(), 1U);
  EXPECT_EQ(name_of(cycles[0].status), "ok");
  EXPECT_EQ(cycles[0].frame->channel_list[0].position, 0x1555555U);
}

TEST(Margin, WithoutFormat_IsJudgedToo) {
  EXPECT_EQ(marginal(with_change_at(nanoseconds(49), true), {}, ""), true);
  EXPECT_EQ(marginal(with_change_at(nanoseconds(51), true), {}, ""), false);
}

// Two edges and their mean may each be wrong by one sample.
TEST(Margin, CoarseCapture_IsMarginalWhereThatIsCertain) {
  const MarginSetup fine{.resolution = nanoseconds(5)};
  EXPECT_EQ(marginal(with_change_at(nanoseconds(39), true), fine), true);
  EXPECT_EQ(marginal(with_change_at(nanoseconds(41), true), fine), false);
  const TestLine line = with_change_at(nanoseconds(39), true);
  EXPECT_EQ(marginal(line, {.resolution = nanoseconds(25)}), false);
  EXPECT_EQ(marginal(line, {.resolution = nanoseconds(26)}), std::nullopt);
}

TEST(Margin, MasterWithoutCompensation_IsJudgedByItsOwnSamples) {
  for (const std::int64_t whole : {0, 1, 2}) {
    for (const auto& [delay_ns, near] : {std::pair{449, false},
                                         {451, true},
                                         {499, true},
                                         {501, true},
                                         {549, true},
                                         {551, false},
                                         {700, false}}) {
      SCOPED_TRACE(std::to_string(whole) + " periods and " + std::to_string(delay_ns) + " ns");
      TestLine line;
      line.request({.line_delay = nanoseconds(whole * 1'000 + delay_ns), .extra_clocks = 3}, 5);
      EXPECT_EQ(marginal(line), false);
      EXPECT_EQ(marginal(line, {.compensated = false}), near);
      const MarginSetup coarse{.compensated = false, .resolution = nanoseconds(49)};
      EXPECT_EQ(marginal(line, coarse), delay_ns == 499 || delay_ns == 501);
    }
  }
}

TEST(Margin, BehindStop_IsOfNoInterest) {
  // LAT 0, …, STOP 40; bits are sampled 600 ns after their rising edges.
  for (const bool compensated : {true, false}) {
    for (const std::size_t clock : {38U, 40U, 41U, 43U}) {
      SCOPED_TRACE(clock);
      TestLine line;
      line.request({.extra_clocks = 5}, 0x1555555);
      const Picoseconds rise = line.ma[line.begins[0] + 2 * clock + 1].time;
      const Picoseconds sample = rise + nanoseconds(compensated ? 600 : 500);
      TestLine::add_pulse(line.slo, sample + nanoseconds(10), nanoseconds(3));
      EXPECT_EQ(marginal(line, {.compensated = compensated}), clock <= 40);
    }
  }
}

// With a line delay of a whole period, STOP is the bit of the next clock.
TEST(Margin, StopOfALongCable_IsALaterSampleWithoutCompensation) {
  for (const std::size_t clock : {41U, 42U}) {
    TestLine line;
    line.request({.line_delay = nanoseconds(1'100), .extra_clocks = 5}, 0x1555555);
    const Picoseconds rise = line.ma[line.begins[0] + 2 * clock + 1].time;
    TestLine::add_pulse(line.slo, rise + nanoseconds(510), nanoseconds(3));
    EXPECT_EQ(marginal(line, {.compensated = false}), clock == 41) << clock;
  }
}

TEST(Margin, BehindTheLastSampleOfAll_CountsToo) {
  TestLine line;
  line.request({}, 0x1555555);
  TestLine::add_pulse(line.slo, line.ma.back().time + nanoseconds(610), nanoseconds(3));
  EXPECT_EQ(marginal(line), true);
}

TEST(Margin, SampleAheadOfTheFirstChange_CountsToo) {
  TestLine line;
  line.request({}, 0x1555555);
  const Picoseconds sample = line.ma[line.begins[0] + 3].time + nanoseconds(600);
  for (const std::int64_t from_ns : {-30, 10}) {
    TestLine spoiled = line;
    TestLine::add_pulse(spoiled.slo, sample + nanoseconds(from_ns), nanoseconds(3));
    EXPECT_EQ(marginal(spoiled), true) << from_ns;
  }
}

TEST(Margin, WhatIsNotSampled_IsNotJudged) {
  TestLine line;
  FrameBits silence;
  silence.append_run(true, 41);
  line.request({}, silence);
  EXPECT_EQ(marginal(line), std::nullopt);
}

TEST(Margin, FailedFrames_AreJudged) {
  TestLine line;
  FrameBits bits = bits_of(usual_format, 0x1555555);
  bits.flip(20);
  line.request({.line_delay = nanoseconds(460)}, bits);
  const auto cycles = decode_with(line, {.compensated = false});
  ASSERT_EQ(cycles.size(), 1U);
  EXPECT_EQ(name_of(cycles[0].status), "crc");
  EXPECT_EQ(cycles[0].marginal, true);
}

}  // namespace margin_test
}  // namespace biss::decode::test
