#include "sim/wrong_frames.hpp"

#include <gtest/gtest.h>

#include <set>

namespace biss::sim {
namespace wrong_frames_test {

// Frames 0, 1, 2, … by their position; \return the position of the frame that is sent in place of
// the next one.
class Sender {
 public:
  WrongFrames wrong;

  std::uint64_t next() {
    Frame own;
    own.channel_count = 1;
    own.channel_list[0].position = sent_++;
    return wrong.put(own).channel_list[0].position;
  }
  void skip(int frames) {
    while (frames-- != 0) next();
  }

 private:
  std::uint64_t sent_ = 0;
};

TEST(WrongFrames, Nothing_SendsEachFrameAndTheEncodersOwnCounter) {
  Sender sender;
  for (std::uint64_t frame = 0; frame < 30; ++frame) EXPECT_EQ(sender.next(), frame);
  EXPECT_EQ(sender.wrong.take_lost(), 0U);
  EXPECT_EQ(sender.wrong.ahead(), 0U);
  EXPECT_EQ(sender.wrong.position_share(), 0U);
  EXPECT_FALSE(sender.wrong.holds_counter());
}

TEST(WrongFrames, Repeat_SendsTheFrameBeforeUntilItEnds) {
  Sender sender;
  sender.skip(5);
  sender.wrong.begin(FaultKind::repeat, 77);
  EXPECT_EQ(sender.next(), 4U);
  EXPECT_EQ(sender.next(), 5U);
  sender.wrong.end(FaultKind::repeat);
  EXPECT_EQ(sender.next(), 7U);
}

TEST(WrongFrames, RepeatOfTheFirstFrame_SendsIt) {
  Sender sender;
  sender.wrong.begin(FaultKind::repeat, 0);
  EXPECT_EQ(sender.next(), 0U);
  EXPECT_EQ(sender.next(), 0U);
}

TEST(WrongFrames, Reorder_SendsOneOfTwoToEightFramesBefore) {
  std::set<std::uint64_t> ages;
  for (std::uint64_t detail = 0; detail < 14; ++detail) {
    Sender sender;
    sender.skip(20);
    sender.wrong.begin(FaultKind::reorder, detail);
    const std::uint64_t age = 20 - sender.next();
    EXPECT_EQ(age, 2 + detail % 7);
    ages.insert(age);
    // The complete memory, several times: the ring buffer wraps around.
    EXPECT_EQ(21 - sender.next(), age);
  }
  EXPECT_EQ(ages, (std::set<std::uint64_t>{2, 3, 4, 5, 6, 7, 8}));
}

TEST(WrongFrames, ReorderOfFewFrames_SendsTheFirst) {
  Sender sender;
  sender.skip(2);
  sender.wrong.begin(FaultKind::reorder, 6);
  EXPECT_EQ(sender.next(), 0U);
}

TEST(WrongFrames, Loss_IsToldOnceAndIsOneToEightFrames) {
  std::set<std::uint32_t> lost;
  for (std::uint64_t detail = 0; detail < 16; ++detail) {
    WrongFrames wrong;
    wrong.begin(FaultKind::loss, detail);
    lost.insert(wrong.take_lost());
    EXPECT_EQ(wrong.take_lost(), 0U);
    EXPECT_FALSE(wrong.holds_counter());
  }
  EXPECT_EQ(lost, (std::set<std::uint32_t>{1, 2, 3, 4, 5, 6, 7, 8}));
}

TEST(WrongFrames, AnotherSource_IsNeitherNearTheFramesToComeNorThoseBefore) {
  for (const FaultKind kind : {FaultKind::insert, FaultKind::other_encoder}) {
    std::set<std::uint64_t> ahead;
    for (std::uint64_t draw = 0; draw < 200; ++draw) {
      WrongFrames wrong;
      wrong.begin(kind, scrambled(draw));
      ahead.insert(wrong.ahead());
      EXPECT_NE(wrong.position_share(), 0U);
      wrong.end(kind);
      EXPECT_EQ(wrong.ahead(), 0U);
      EXPECT_EQ(wrong.position_share(), 0U);
    }
    EXPECT_EQ(*ahead.begin(), 10U);
    EXPECT_EQ(*ahead.rbegin(), 52U);
  }
}

TEST(WrongFrames, EncodersCounter_StandsForAnInsertedFrameAndAFrozenOneOnly) {
  for (const FaultKind kind : {FaultKind::insert, FaultKind::lc_frozen, FaultKind::other_encoder,
                               FaultKind::repeat, FaultKind::reorder}) {
    WrongFrames wrong;
    wrong.begin(kind, 1);
    EXPECT_EQ(wrong.holds_counter(), kind == FaultKind::insert || kind == FaultKind::lc_frozen);
    wrong.end(kind);
    EXPECT_FALSE(wrong.holds_counter());
  }
}

TEST(WrongFrames, TwoFaultsAtOnce_EndEachByItself) {
  Sender sender;
  sender.skip(9);
  sender.wrong.begin(FaultKind::repeat, 0);
  sender.wrong.begin(FaultKind::lc_frozen, 0);
  sender.wrong.end(FaultKind::repeat);
  EXPECT_TRUE(sender.wrong.holds_counter());
  EXPECT_EQ(sender.next(), 9U);
}

}  // namespace wrong_frames_test
}  // namespace biss::sim
