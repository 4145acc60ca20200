#include "sim/motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "biss/frame/format_text.hpp"

namespace biss::sim {
namespace motion_test {

constexpr Picoseconds interval = microseconds(40);

Motion motion_of(MotionKind kind, std::string_view format) {
  return {kind, parse_format(format)->channel_list[0], interval, 3};
}

struct Range {
  std::uint64_t min = UINT64_MAX;
  std::uint64_t max = 0;
};

Range range_of(MotionKind kind, int samples) {
  Motion motion = motion_of(kind, "pos10,crc6");
  Range range;
  for (int i = 0; i < samples; ++i) {
    const std::uint64_t position = motion.sample(i * interval);
    range.min = std::min(range.min, position);
    range.max = std::max(range.max, position);
  }
  return range;
}

TEST(Motion, Constant_StaysWhereItIs) {
  const Range range = range_of(MotionKind::constant, 100);
  EXPECT_EQ(range.min, range.max);
}

TEST(Motion, RampAndRandomWalk_VisitTheWholeRange) {
  for (const MotionKind kind : {MotionKind::ramp, MotionKind::random}) {
    const Range range = range_of(kind, 5000);
    EXPECT_EQ(range.min, 0U);
    EXPECT_EQ(range.max, 1023U);
  }
}

TEST(Motion, Sine_KeepsToAQuarterEitherSideOfZero) {
  Motion motion = motion_of(MotionKind::sine, "pos10,crc6");
  std::uint64_t most = 0;
  std::uint64_t least = 1023;
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t position = motion.sample(i * interval);
    EXPECT_TRUE(position <= 256 || position >= 768) << position;
    if (position <= 256) most = std::max(most, position);
    if (position >= 768) least = std::min(least, position);
  }
  EXPECT_GE(most, 255U);
  EXPECT_LE(least, 769U);
}

TEST(Motion, SineOfMoreThan32Bits_MovesItsLowestBitsToo) {
  Motion fine = motion_of(MotionKind::sine, "pos42,crc6");
  Motion coarse = motion_of(MotionKind::sine, "pos32,crc6");
  std::uint64_t changed = 0;
  const std::uint64_t first = fine.sample({});
  for (int i = 0; i < 100; ++i) {
    const std::uint64_t position = fine.sample(i * interval);
    changed |= position ^ first;
    const std::uint64_t apart = (position >> 10U) - coarse.sample(i * interval) + 8;
    EXPECT_LE(apart & 0xFFFF'FFFFU, 16U) << i;
  }
  EXPECT_EQ(changed & 0x3FFU, 0x3FFU);
}

TEST(Motion, FullSpeed_CrossesZeroBothWaysAndTurnsCanBeCounted) {
  Motion motion = motion_of(MotionKind::max, "mt8,st12,crc6");
  bool forwards = false;
  bool backwards = false;
  std::uint64_t last = motion.sample({});
  for (int i = 1; i < 2000; ++i) {
    const std::uint64_t position = motion.sample(i * interval);
    const std::uint64_t step = (position - last) & 0xFFF;
    // Less than half a turn, and much of it.
    EXPECT_TRUE(step < 0x800 || step > 0x800) << step;
    EXPECT_TRUE(step < 0x800 ? step > 0x600 || i % 250 < 2 : step < 0xA00 || i % 250 < 2) << i;
    if (last > 0xFF000 && position < 0x1000) forwards = true;
    if (last < 0x1000 && position > 0xFF000) backwards = true;
    last = position;
  }
  EXPECT_TRUE(forwards);
  EXPECT_TRUE(backwards);
}

}  // namespace motion_test
}  // namespace biss::sim
