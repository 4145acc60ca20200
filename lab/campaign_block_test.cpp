#include "lab/campaign_block.hpp"

#include <gtest/gtest.h>

#include "biss/safety/configurations.hpp"

namespace biss::lab {
namespace campaign_block_test {

constexpr std::uint64_t seed = 20'261'121;

CampaignFrame frame_of(const char* name) {
  const SafetyConfiguration& known = *find_safety_configuration(name);
  return CampaignFrame::make(known.frame_format(), known.setup).value();
}

TEST(CampaignFrame, EveryConfiguration_IsMonitoredAsSafeUndamaged) {
  for (const SafetyConfiguration& each : safety_configurations) {
    const auto frame = CampaignFrame::make(each.frame_format(), each.setup);
    ASSERT_TRUE(frame) << each.name;
    for (std::uint64_t index = 0; index < 300; ++index) {
      const SentFrame sent = frame->draw(seed, index);
      const SafetyJudgement judgement = frame->monitor(sent, frame->encode(sent));
      ASSERT_EQ(judgement.verdict, SafetyVerdict::safe) << each.name << " " << index;
      ASSERT_EQ(control_position(frame->plan(), *judgement.position), sent.position);
    }
  }
}

TEST(CampaignFrame, FormatThatIsNoPair_IsRefused) {
  for (const char* text : {"pos26,nE,nW,crc6", "pos26,nE,nW,crc6+pos26,nE,nW,crc16",
                           "pos12,nE,crc6+pos12,nE,lc6,crc16+pos12,crc6"}) {
    EXPECT_FALSE(CampaignFrame::make(parse_format(text).value(), {})) << text;
  }
}

// 2^20 frames of each, so that every kind of acceptance occurs.
TEST(CampaignBlock, BitSlices_CountAsDecodeAndMonitorDo) {
  for (const char* name : {"fs-36-28", "rxm", "ruh"}) {
    const CampaignFrame frame = frame_of(name);
    for (const char* text : {"flips:0.5", "flips:0.1", "flips:0.01"}) {
      const FaultSequence sequence{*parse_fault(text), seed};
      CampaignCounts fast;
      CampaignCounts plain;
      for (std::uint64_t block = 0; block < 16; ++block) {
        fast.add(count_block(frame, sequence, block));
        plain.add(count_block_plainly(frame, sequence, block));
      }
      EXPECT_EQ(fast, plain) << name << " " << text;
      EXPECT_EQ(fast.frames, 16 * block_frames);
      EXPECT_GT(fast.total(Acceptance::cpw), 20U) << name << " " << text;
    }
  }
}

TEST(CampaignBlock, PartOfABlock_IsItsBeginning) {
  const CampaignFrame frame = frame_of("fs-36-28");
  const FaultSequence sequence{*parse_fault("flips:0.1"), seed};
  const CampaignCounts part = count_block(frame, sequence, 3, 1000);
  EXPECT_EQ(part, count_block_plainly(frame, sequence, 3, 1000));
  EXPECT_EQ(part.frames, 1000U);
}

TEST(CampaignBlock, SeedFaultAndBlock_EachGiveOtherFrames) {
  const CampaignFrame frame = frame_of("fs-36-28");
  const auto counts = [&](const char* fault, std::uint64_t from, std::uint64_t block) {
    return count_block(frame, {*parse_fault(fault), from}, block);
  };
  const CampaignCounts one = counts("flips:0.1", 1, 0);
  EXPECT_EQ(one, counts("flips:0.1", 1, 0));
  EXPECT_NE(one, counts("flips:0.1", 2, 0));
  EXPECT_NE(one, counts("flips:0.1", 1, 1));
  EXPECT_NE(one.accepted, counts("flips:0.1:0.1", 1, 0).accepted);
}

TEST(CampaignBlock, MissedFrames_AreWrongAndSafeWhenReplayed) {
  const CampaignFrame frame = frame_of("rxm");
  for (const char* text : {"flips:0.1", "burst:8"}) {
    const FaultSequence sequence{*parse_fault(text), seed};
    CampaignCounts counts;
    for (std::uint64_t block = 0; block < 6; ++block) {
      counts.add(count_block(frame, sequence, block));
    }
    ASSERT_FALSE(counts.missed.empty()) << text;
    for (const std::uint64_t index : counts.missed) {
      const ReplayedFrame replayed = replay_frame(frame, sequence, index);
      const SafetyJudgement judgement = frame.monitor(replayed.sent, replayed.received);
      EXPECT_EQ(judgement.verdict, SafetyVerdict::safe) << text << " " << index;
      EXPECT_NE(control_position(frame.plan(), *judgement.position), replayed.sent.position)
          << text << " " << index;
    }
  }
}

TEST(CampaignCounts, MissedFrames_AreTheFirstOnesInAnyOrder) {
  CampaignCounts counts;
  for (std::uint64_t n = 100; n > 0; --n) counts.add_missed(n);
  ASSERT_EQ(counts.missed.size(), missed_kept);
  EXPECT_EQ(counts.missed.front(), 1U);
  EXPECT_EQ(counts.missed.back(), missed_kept);
}

TEST(CampaignFault, Texts_ComeBackAsTheyWere) {
  for (const char* text :
       {"flips:0.5", "flips:0.25:0.125", "flips:0.01:0.1", "flips:0.5:fitting", "burst:16",
        "burst:2:7", "lost_bit", "doubled_bit:3", "slo_low:0", "slo_high:103", "inserted_low",
        "inserted_high:7", "gap_low:1", "gap_high:8:3", "lost_start", "false_start:2", "cds_high",
        "stop_high"}) {
    const auto fault = parse_fault(text);
    ASSERT_TRUE(fault) << text;
    EXPECT_EQ(text_of(*fault), text);
  }
}

TEST(CampaignFault, RatesThatAreNoPartOf2To32_ParseToTheSameAgain) {
  for (const char* text : {"flips:0.01", "flips:0.1:0.3", "flips:1e-9", "flips:2.3283064e-10"}) {
    const auto fault = parse_fault(text);
    ASSERT_TRUE(fault) << text;
    EXPECT_EQ(parse_fault(text_of(*fault)), fault) << text_of(*fault);
  }
}

TEST(CampaignFault, TextThatIsNoFault_IsRefused) {
  for (const char* text : {"",
                           "flip:0.1",
                           "flips",
                           "flips:0",
                           "flips:0.6",
                           "flips:nan",
                           "flips:-0.1",
                           "flips:0.1:",
                           "flips:0.1:0.2:0.3",
                           "flips:0.1:fit",
                           "flips:0.1:fitting:0.1",
                           "burst",
                           "burst:1",
                           "burst:33",
                           "burst:4:x",
                           "lost_bit:1:2",
                           "slo_low:",
                           "slo_high:-1",
                           "burst:16 ",
                           "gap_low",
                           "gap_high:0",
                           "gap_low:33",
                           "lost_start:1",
                           "cds_high:0",
                           "stop_high:"}) {
    EXPECT_FALSE(parse_fault(text)) << text;
  }
}

// 10110 and STOP = 0, so that each fault is visible.
constexpr LineWord line = 0b101100;

LineWord after(const char* text, unsigned place, std::uint64_t pattern = 0) {
  return damaged(line, 6, *parse_fault(text), place, pattern);
}

TEST(CampaignDamage, EachFault_ChangesWhatItSays) {
  EXPECT_EQ(after("lost_bit", 1) == 0b111000, true);
  EXPECT_EQ(after("doubled_bit", 1) == 0b100110, true);
  EXPECT_EQ(after("slo_low", 2) == 0b100000, true);
  EXPECT_EQ(after("slo_high", 2) == 0b101111, true);
  EXPECT_EQ(after("burst:4", 0, 0b10) == (line ^ 0b110100), true);
  EXPECT_EQ(after("burst:4", 1, 0b01) == (line ^ 0b010110), true);
  EXPECT_EQ(after("inserted_low", 0) == 0b010110, true);
  EXPECT_EQ(after("inserted_high", 1) == 0b110110, true);
  EXPECT_EQ(after("gap_low:2", 2) == 0b100000, true);
  EXPECT_EQ(after("gap_high:3", 1) == 0b111100, true);
  EXPECT_EQ(after("gap_high:9", 4) == 0b101111, true);
  EXPECT_EQ(after("stop_high", 0) == 0b101101, true);
  EXPECT_EQ(after("burst:2", 3) == (line ^ 0b000110), true);
}

}  // namespace campaign_block_test
}  // namespace biss::lab
