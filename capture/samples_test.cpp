#include "capture/samples.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/common/random.hpp"

namespace biss::capture {
namespace samples_test {

static_assert(SampleClock(megahertz(100)).time_of(7) == nanoseconds(70));
static_assert(SampleClock(megahertz(3)).time_of(1) == picoseconds(333'333));
static_assert(SampleClock(megahertz(3)).time_of(2) == picoseconds(666'667));
static_assert(SampleClock(megahertz(3)).time_of(3) == picoseconds(1'000'000));
static_assert(SampleClock(megahertz(3)).first_at_or_after(picoseconds(333'333)) == 1);
static_assert(SampleClock(megahertz(3)).first_at_or_after(picoseconds(333'334)) == 2);

TEST(SampleClock, RatesThatDoNotDivideASecond_DoNotDrift) {
  // 48 MHz: 20833.3… ps. Summing a rounded period would be 3.3 s off after a week.
  const SampleClock clock(megahertz(48));
  const std::uint64_t week = 7U * 24U * 3'600U;
  EXPECT_EQ(clock.time_of(week * 48'000'000U).count,
            static_cast<std::int64_t>(week) * picoseconds_per_second);
}

TEST(SampleClock, RandomTimes_LieWithinHalfAPicosecondOfTheExactOnes) {
  std::mt19937_64 random = test::random_of(7'401);
  for (int i = 0; i < 100'000; ++i) {
    const Hertz rate{1U + static_cast<std::uint32_t>(random() >> (32U + random() % 32U))};
    const SampleClock clock(rate);
    const std::uint64_t index = (random() >> (random() % 64U)) % clock.last_index();
    const Picoseconds time = clock.time_of(index);
    // time × rate / 10^12 differs from the index by at most rate / 2, in units of 10^-12. The
    // comparison omits the common multiple of 2^64 that both sides lack.
    const auto error =
        static_cast<std::int64_t>(static_cast<std::uint64_t>(time.count) * rate.count -
                                  index * std::uint64_t{picoseconds_per_second});
    ASSERT_LE(2 * error, std::int64_t{rate.count}) << rate.count << ' ' << index;
    ASSERT_GT(2 * error, -std::int64_t{rate.count} - 1) << rate.count << ' ' << index;
    ASSERT_EQ(clock.first_at_or_after(time), index);
    ASSERT_EQ(clock.first_at_or_after(time + picoseconds(1)), index + 1);
    if (index == 0) continue;
    ASSERT_EQ(clock.first_at_or_after(time - picoseconds(1)), index);
  }
}

TEST(SampleClock, LastIndex_IsTheLastThatFits) {
  for (const std::uint32_t rate : {1U, 3U, 1'000'000U, 48'000'000U, UINT32_MAX}) {
    const SampleClock clock(Hertz{rate});
    const Picoseconds last = clock.time_of(clock.last_index());
    EXPECT_GT(last.count, 0);
    EXPECT_GE(last.count,
              std::numeric_limits<std::int64_t>::max() - picoseconds_per_second / rate - 1);
  }
}

}  // namespace samples_test
}  // namespace biss::capture
