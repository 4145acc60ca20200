#include "biss/base/bits.hpp"
#include "biss/turns/turn_counter.hpp"
#include "tests/core/test.hpp"

namespace biss::turns_test {

/// The true position: it never wraps, is two words wide, and moves by signed steps.
class Motion {
 public:
  Motion(unsigned width_bits, std::uint64_t count) : width_bits_(width_bits), count_(count) {}

  void move(bool forward, std::uint64_t step) {
    const std::uint64_t mask = low_mask(width_bits_);
    if (forward) {
      // The carry is detected without an addition beyond the width.
      if (step > mask - count_) ++turns_;
      count_ = (count_ + step) & mask;
    } else {
      if (step > count_) --turns_;
      count_ = (count_ - step) & mask;
    }
  }
  std::uint64_t count() const { return count_; }
  std::int64_t turns() const { return turns_; }

 private:
  unsigned width_bits_;
  std::uint64_t count_;
  std::int64_t turns_ = 0;
};

constexpr std::uint64_t half_turn(unsigned width_bits) {
  return std::uint64_t{1} << (width_bits - 1U);
}

BISS_TEST(TurnCounter, FirstSample_IsTurnZeroWhereverItStands) {
  for (unsigned width = 1; width <= 64; ++width) {
    TurnCounter counter(width);
    BISS_EXPECT_EQ(counter.state(), TurnState::empty);
    BISS_EXPECT_EQ(counter.update(low_mask(width), 7), TurnState::first) << width;
    BISS_EXPECT_EQ(counter.turns(), 0);
    BISS_EXPECT_EQ(counter.count(), low_mask(width));
  }
}

BISS_TEST(TurnCounter, CrossingZero_CountsATurnEachWay) {
  TurnCounter counter(18);
  counter.update(0x3FFFF);
  BISS_EXPECT_EQ(counter.update(0), TurnState::tracked);
  BISS_EXPECT_EQ(counter.turns(), 1);
  BISS_EXPECT_EQ(counter.update(0x3FFFF), TurnState::tracked);
  BISS_EXPECT_EQ(counter.turns(), 0);
  BISS_EXPECT_EQ(counter.update(0), TurnState::tracked);
  BISS_EXPECT_EQ(counter.update(0), TurnState::tracked);
  BISS_EXPECT_EQ(counter.turns(), 1);
}

BISS_TEST(TurnCounter, StartJustAboveZeroAndBack_IsTurnMinusOne) {
  TurnCounter counter(26);
  counter.update(3);
  counter.update(0x3FFFFFD);
  BISS_EXPECT_EQ(counter.turns(), -1);
  BISS_EXPECT(counter.position() == -3);
}

BISS_TEST(TurnCounter, EveryWidthAtTheHighestSpeed_FollowsBothWays) {
  for (unsigned width = 2; width <= 64; ++width) {
    for (const bool forward : {true, false}) {
      Motion truth(width, width * 0x9E3779B97F4A7C15U & low_mask(width));
      TurnCounter counter(width);
      counter.update(truth.count());
      for (int i = 0; i < 40; ++i) {
        truth.move(forward, half_turn(width) - 1);
        BISS_EXPECT_EQ(counter.update(truth.count()), TurnState::tracked) << width;
        BISS_EXPECT_EQ(counter.turns(), truth.turns()) << "width " << width << " step " << i;
      }
      // 40 steps of one count less than half a turn; with few bits that is much less.
      const std::int64_t turned = forward ? counter.turns() : -counter.turns();
      BISS_EXPECT(turned >= 19 || width <= 8) << width;
    }
  }
}

BISS_TEST(TurnCounter, RandomMotionOfEveryWidth_FollowsTheTruth) {
  BISS_RANDOM(random, 0x70125);
  for (unsigned width = 2; width <= 64; ++width) {
    Motion truth(width, random.bits(width));
    TurnCounter counter(width);
    counter.update(truth.count());
    for (std::uint64_t i = 0; i < test::rounds(2'000, 50); ++i) {
      truth.move(random.flip(), random.bits(width - 1U));
      BISS_EXPECT_EQ(counter.update(truth.count()), TurnState::tracked) << width;
      BISS_EXPECT_EQ(counter.turns(), truth.turns()) << width;
    }
  }
}

BISS_TEST(TurnCounter, ExactlyHalfATurn_IsAmbiguousAndStaysSo) {
  for (unsigned width = 1; width <= 64; ++width) {
    for (const std::uint64_t start : {std::uint64_t{0}, low_mask(width)}) {
      TurnCounter counter(width);
      counter.update(start);
      BISS_EXPECT_EQ(counter.update(start ^ half_turn(width)), TurnState::ambiguous) << width;
      BISS_EXPECT_EQ(counter.update(start ^ half_turn(width)), TurnState::ambiguous) << width;
    }
  }
}

BISS_TEST(TurnCounter, WidthOfOneBit_KnowsRestOnly) {
  TurnCounter counter(1);
  counter.update(1);
  BISS_EXPECT_EQ(counter.update(1), TurnState::tracked);
  BISS_EXPECT_EQ(counter.update(0), TurnState::ambiguous);
  counter.restart();
  counter.update(1);
  BISS_EXPECT_EQ(counter.update(1, 1), TurnState::ambiguous);
}

BISS_TEST(TurnCounter, AnyGapWithoutAKnownSpeed_IsAmbiguous) {
  for (unsigned width = 1; width <= 64; ++width) {
    TurnCounter counter(width);
    counter.update(0);
    BISS_EXPECT_EQ(counter.update(0, 1), TurnState::ambiguous) << width;
  }
}

BISS_TEST(TurnCounter, Gap_IsBridgedWhileItsMotionStaysBelowHalfATurn) {
  // 26 bits, at most 2^20 counts per sample: half a turn has 32 of these steps.
  constexpr std::uint64_t step = std::uint64_t{1} << 20U;
  for (const bool forward : {true, false}) {
    Motion truth(26, 5);
    TurnCounter counter(26, step);
    counter.update(truth.count());
    for (int i = 0; i < 10; ++i) {
      truth.move(forward, 31 * step);
      BISS_EXPECT_EQ(counter.update(truth.count(), 30), TurnState::tracked);
      BISS_EXPECT_EQ(counter.turns(), truth.turns());
    }
    truth.move(forward, 1);
    BISS_EXPECT_EQ(counter.update(truth.count(), 31), TurnState::ambiguous);
  }
}

BISS_TEST(TurnCounter, StepBeyondTheLargest_IsAmbiguous) {
  for (const bool forward : {true, false}) {
    Motion truth(26, 0);
    TurnCounter counter(26, 1000);
    counter.update(0);
    truth.move(forward, 1000);
    BISS_EXPECT_EQ(counter.update(truth.count()), TurnState::tracked);
    truth.move(forward, 3000);
    BISS_EXPECT_EQ(counter.update(truth.count(), 2), TurnState::tracked);
    truth.move(forward, 1001);
    BISS_EXPECT_EQ(counter.update(truth.count()), TurnState::ambiguous);
  }
}

BISS_TEST(TurnCounter, SpeedOfHalfATurnASample_IsAmbiguousAtEveryStep) {
  // With 8 bits, 56 forward may have been 200 backward.
  for (const std::uint64_t step : {std::uint64_t{128}, std::uint64_t{200}}) {
    TurnCounter counter(8, step);
    counter.update(0);
    BISS_EXPECT_EQ(counter.update(56), TurnState::ambiguous) << step;
  }
  TurnCounter fastest(8, 127);
  fastest.update(0);
  BISS_EXPECT_EQ(fastest.update(127), TurnState::tracked);
}

BISS_TEST(TurnCounter, HugeGap_DoesNotRunOver) {
  constexpr std::uint64_t all = std::numeric_limits<std::uint64_t>::max();
  TurnCounter counter(64, std::uint64_t{1} << 62U);
  counter.update(0);
  BISS_EXPECT_EQ(counter.update(1, all), TurnState::ambiguous);
  TurnCounter slow(64, 1);
  slow.update(0);
  BISS_EXPECT_EQ(slow.update(5, 5), TurnState::tracked);
  BISS_EXPECT_EQ(slow.update(5, all), TurnState::ambiguous);
}

BISS_TEST(TurnCounter, KnownMultiturn_EndsTheAmbiguity) {
  TurnCounter counter(12);
  counter.update(100);
  BISS_EXPECT_EQ(counter.update(100 + 2048), TurnState::ambiguous);
  BISS_EXPECT_EQ(counter.resynchronise(-7), TurnState::tracked);
  BISS_EXPECT_EQ(counter.update(100 + 2048 + 2047), TurnState::tracked);
  BISS_EXPECT_EQ(counter.turns(), -6);
}

BISS_TEST(TurnCounter, MultiturnBeforeTheFirstSample_IsKept) {
  TurnCounter counter(12);
  BISS_EXPECT_EQ(counter.resynchronise(41), TurnState::empty);
  BISS_EXPECT_EQ(counter.update(4095), TurnState::first);
  BISS_EXPECT_EQ(counter.update(0), TurnState::tracked);
  BISS_EXPECT_EQ(counter.turns(), 42);
  counter.restart();
  BISS_EXPECT_EQ(counter.state(), TurnState::empty);
  BISS_EXPECT_EQ(counter.turns(), 0);
}

BISS_TEST(TurnCounter, BitsAboveTheWidth_AreDropped) {
  TurnCounter counter(8);
  counter.update(0xAB12);
  BISS_EXPECT_EQ(counter.count(), 0x12U);
}

BISS_TEST(TurnCounter, TurnsAtTheirLimit_Stay) {
  TurnCounter up(8);
  up.resynchronise(std::numeric_limits<std::int64_t>::max());
  up.update(255);
  up.update(0);
  BISS_EXPECT_EQ(up.turns(), std::numeric_limits<std::int64_t>::max());
  BISS_EXPECT(!up.position().has_value());
  TurnCounter down(8);
  down.resynchronise(std::numeric_limits<std::int64_t>::min());
  down.update(0);
  down.update(255);
  BISS_EXPECT_EQ(down.turns(), std::numeric_limits<std::int64_t>::min());
  BISS_EXPECT(!down.position().has_value());
}

BISS_TEST(TurnCounter, Position_IsThereExactlyWhereItFits) {
  const auto at = [](unsigned width, std::int64_t turns, std::uint64_t count) {
    TurnCounter counter(width);
    counter.update(count);
    counter.resynchronise(turns);
    return counter.position();
  };
  constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
  constexpr std::int64_t least = std::numeric_limits<std::int64_t>::min();
  BISS_EXPECT(at(8, 2, 5) == 517);
  BISS_EXPECT(at(8, -1, 255) == -1);
  BISS_EXPECT(at(1, (std::int64_t{1} << 62) - 1, 1) == most);
  BISS_EXPECT(!at(1, std::int64_t{1} << 62, 0).has_value());
  BISS_EXPECT(at(63, 0, low_mask(63)) == most);
  BISS_EXPECT(at(63, -1, 0) == least);
  BISS_EXPECT(!at(63, 1, 0).has_value());
  BISS_EXPECT(!at(63, -2, 0).has_value());
  BISS_EXPECT(at(64, 0, low_mask(63)) == most);
  BISS_EXPECT(at(64, -1, ~std::uint64_t{0}) == -1);
  BISS_EXPECT(!at(64, 0, ~std::uint64_t{0}).has_value());
  BISS_EXPECT(!at(64, -1, 0).has_value());
}

}  // namespace biss::turns_test
