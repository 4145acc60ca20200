#include "rows/motion.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <random>

namespace biss::rows {
namespace motion_test {

constexpr Picoseconds at(std::int64_t number) { return microseconds(number * 100); }

TEST(Motion, DescendingOverZero_IsNegative) {
  Motion motion(12, std::nullopt, true, std::nullopt);
  EXPECT_EQ(motion.take(at(0), 30).unwrapped, 30);
  EXPECT_EQ(motion.take(at(1), 4050).unwrapped, -46);
  EXPECT_EQ(motion.take(at(2), 3990).unwrapped, -106);
  EXPECT_EQ(motion.take(at(3), 22).unwrapped, 22) << "128 counts are a 32nd of the range";
  EXPECT_EQ(motion.take(at(4), 151).unwrapped, std::nullopt);
}

TEST(Motion, RandomWay_IsFollowedOverManyTurns) {
  std::mt19937_64 random(20261123);
  for (const unsigned bits : {6U, 16U, 32U, 48U, 63U}) {
    const std::uint64_t most = std::uint64_t{1} << (bits - 5);
    Motion motion(bits, std::nullopt, true, Scale{.per_count = 0.5, .unit = "mm"});
    std::int64_t exact = 5;
    std::int64_t before = exact;
    for (std::int64_t i = 0; i < 1000; ++i) {
      const bool missed = i % 7 == 3;
      const auto position = static_cast<std::uint64_t>(exact) & low_mask(bits);
      const MotionValues values =
          motion.take(at(i), missed ? std::nullopt : std::optional(position));
      if (missed) {
        EXPECT_FALSE(values.unwrapped || values.scaled || values.velocity);
      } else {
        ASSERT_EQ(values.unwrapped, exact) << bits << ' ' << i;
        ASSERT_EQ(values.scaled, static_cast<double>(exact) * 0.5);
        const double seconds = i % 7 == 4 ? 2e-4 : 1e-4;
        const double velocity = static_cast<double>(exact - before) * 0.5 / seconds;
        if (i != 0) {
          ASSERT_NEAR(values.velocity.value(), velocity, std::abs(velocity) * 1e-12);
        }
        before = exact;
      }
      // Up and down, so that 63 bits do not leave the range of the result.
      const auto step = static_cast<std::int64_t>(random() % (most + 1));
      exact += (i / 4) % 2 == 0 ? step : -step;
    }
    EXPECT_FALSE(motion.lost());
  }
}

TEST(Motion, AfterAWayThatIsNotCertain_OnlyTheVelocityIsKnownAgain) {
  Motion motion(12, 100, true, std::nullopt);
  EXPECT_EQ(motion.take(at(0), 0).velocity, std::nullopt);
  EXPECT_EQ(motion.take(at(1), 100).velocity, 1e6);
  const MotionValues jump = motion.take(at(2), 201);
  EXPECT_EQ(jump.unwrapped, std::nullopt);
  EXPECT_EQ(jump.velocity, std::nullopt);
  EXPECT_TRUE(motion.lost());
  const MotionValues after = motion.take(at(3), 200);
  EXPECT_EQ(after.unwrapped, std::nullopt);
  EXPECT_EQ(after.velocity, -1e4);
  EXPECT_EQ(motion.uncertain(), 1U);
}

TEST(Motion, RowsWithoutAPosition_AreBridgedUpToHalfOfTheRange) {
  for (const int missed : {19, 20}) {
    Motion motion(12, 100, true, std::nullopt);
    motion.take(at(0), 0);
    for (int i = 0; i < missed; ++i) motion.take(at(i + 1), std::nullopt);
    // 2047 counts are just below half of the range.
    EXPECT_EQ(motion.take(at(30), 1500).unwrapped.has_value(), missed == 19) << missed;
  }
}

TEST(Motion, WithoutUnwrap_TheScaledPositionIsThatOfTheRow) {
  Motion motion(12, 5, false, Scale{.per_count = 2, .unit = "deg"});
  EXPECT_EQ(motion.take(at(0), 4000).scaled, 8000);
  EXPECT_EQ(motion.take(at(1), 1).scaled, 2);
}

}  // namespace motion_test
}  // namespace biss::rows
