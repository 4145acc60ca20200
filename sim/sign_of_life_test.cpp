#include "sim/sign_of_life.hpp"

#include <gtest/gtest.h>

#include <set>

namespace biss::sim {
namespace sign_of_life_test {

std::uint32_t value(const SignOfLife& life, std::uint64_t frames) {
  return life.value(0, frames, 6);
}

TEST(SignOfLife, Default_CountsFrom1To63AndNeverIs0) {
  const SignOfLife life;
  EXPECT_EQ(life.period(), 63U);
  std::set<std::uint32_t> seen;
  for (std::uint64_t frame = 0; frame < 63; ++frame) {
    EXPECT_EQ(value(life, frame), frame + 1);
    seen.insert(value(life, frame));
  }
  EXPECT_EQ(seen.size(), 63U);
  EXPECT_FALSE(seen.count(0));
  EXPECT_EQ(value(life, 63), 1U);
}

TEST(SignOfLife, From0_Has64ValuesAnd63IsFollowedBy0) {
  const SignOfLife life{.first = 0, .starts = SignOfLife::all_from(62)};
  EXPECT_EQ(life.period(), 64U);
  for (const auto& [frame, expected] : {std::pair{0, 62U}, {1, 63U}, {2, 0U}, {3, 1U}, {66, 0U}}) {
    EXPECT_EQ(value(life, static_cast<std::uint64_t>(frame)), expected) << frame;
  }
}

TEST(SignOfLife, StartAtTheHighestValue_IsFollowedByTheLowest) {
  const SignOfLife life{.starts = SignOfLife::all_from(63)};
  EXPECT_EQ(value(life, 0), 63U);
  EXPECT_EQ(value(life, 1), 1U);
}

TEST(SignOfLife, EachChannel_HasItsOwnStart) {
  SignOfLife life;
  life.starts[1] = 40;
  EXPECT_EQ(life.value(0, 5, 6), 6U);
  EXPECT_EQ(life.value(1, 5, 6), 45U);
}

TEST(SignOfLife, FewerBits_ShowTheLowerOnes) {
  const SignOfLife life{.starts = SignOfLife::all_from(0x2D)};
  EXPECT_EQ(life.value(0, 0, 4), 0xDU);
  EXPECT_EQ(life.value(0, 0, 1), 1U);
  EXPECT_EQ(life.value(0, 0, 0), 0U);
  EXPECT_EQ(life.value(0, 0, 8), 0x2DU);
}

// Ten years of frames at 32 kHz.
TEST(SignOfLife, ManyFrames_StayInStep) {
  const SignOfLife life;
  const std::uint64_t periods = 158'730'158'730;
  EXPECT_EQ(value(life, 63 * periods), 1U);
  EXPECT_EQ(value(life, 63 * periods + 62), 63U);
}

}  // namespace sign_of_life_test
}  // namespace biss::sim
