#include "capture/seconds.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace biss::capture {
namespace seconds_test {

TEST(Seconds, WholePicoseconds_ComeBackUpTo75Minutes) {
  std::mt19937_64 random(7'601);
  for (int i = 0; i < 200'000; ++i) {
    const auto magnitude = static_cast<std::int64_t>((random() >> 12U) >> random() % 52);
    const Picoseconds time{random() % 2 == 0 ? magnitude : -magnitude};
    const auto back = picoseconds_of(seconds_of(time));
    ASSERT_TRUE(back.ok());
    ASSERT_EQ(*back, time);
  }
}

TEST(Seconds, ExactValue_IsRoundedOnceAndHalvesAwayFromZero) {
  EXPECT_EQ(*picoseconds_of(0.0), Picoseconds{});
  EXPECT_EQ(*picoseconds_of(-0.0), Picoseconds{});
  EXPECT_EQ(*picoseconds_of(1.5), picoseconds(1'500'000'000'000));
  EXPECT_EQ(*picoseconds_of(-1e-9), picoseconds(-1'000));
  // 2^-13 s are 122070312.5 ps.
  EXPECT_EQ(*picoseconds_of(std::ldexp(1, -13)), picoseconds(122'070'313));
  EXPECT_EQ(*picoseconds_of(-std::ldexp(1, -13)), picoseconds(-122'070'313));
  EXPECT_EQ(*picoseconds_of(std::nextafter(std::ldexp(1, -13), 0)), picoseconds(122'070'312));
  EXPECT_EQ(*picoseconds_of(0.4e-12), Picoseconds{});
  EXPECT_EQ(*picoseconds_of(0.6e-12), picoseconds(1));
  EXPECT_EQ(*picoseconds_of(std::numeric_limits<double>::denorm_min()), Picoseconds{});
  EXPECT_EQ(*picoseconds_of(std::numeric_limits<double>::min()), Picoseconds{});
  // The double nearest to 4000.000000000001 s is nearer to this picosecond than to any other.
  EXPECT_EQ(*picoseconds_of(4000.000000000001), picoseconds(4'000'000'000'000'001));
}

TEST(Seconds, PeriodOfARate_IsRoundedUpAndASecondAtMost) {
  EXPECT_EQ(period_of_rate(10e6), nanoseconds(100));
  EXPECT_EQ(period_of_rate(3e6), picoseconds(333'334));
  EXPECT_EQ(period_of_rate(0.1), picoseconds(1'000'000'000'000));
  EXPECT_EQ(period_of_rate(std::numeric_limits<double>::denorm_min()),
            picoseconds(1'000'000'000'000));
}

TEST(Seconds, RateOfWholeHertz_IsKept) {
  EXPECT_EQ(whole_rate(62.5e6), Hertz{62'500'000});
  EXPECT_EQ(whole_rate(0.5), Hertz{});
  EXPECT_EQ(whole_rate(1.5), Hertz{});
  EXPECT_EQ(whole_rate(1e10), Hertz{});
}

TEST(Seconds, NoNumberAndTooFar_AreNamed) {
  using Limits = std::numeric_limits<double>;
  EXPECT_EQ(picoseconds_of(Limits::quiet_NaN()).error(), CaptureCause::malformed);
  EXPECT_EQ(picoseconds_of(Limits::infinity()).error(), CaptureCause::malformed);
  EXPECT_EQ(picoseconds_of(-Limits::infinity()).error(), CaptureCause::malformed);
  EXPECT_EQ(picoseconds_of(Limits::max()).error(), CaptureCause::time_out_of_range);
  EXPECT_EQ(picoseconds_of(-9.3e6).error(), CaptureCause::time_out_of_range);
  EXPECT_EQ(picoseconds_of(9'223'372.5).error(), CaptureCause::time_out_of_range);
  EXPECT_TRUE(picoseconds_of(9'223'372.0).ok());
  EXPECT_TRUE(picoseconds_of(-9'223'372.0).ok());
}

}  // namespace seconds_test
}  // namespace biss::capture
