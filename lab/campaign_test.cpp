#include "lab/campaign.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "biss/safety/configurations.hpp"

namespace biss::lab {
namespace {

const CampaignFrame& frame() {
  static const SafetyConfiguration& known = *find_safety_configuration("rxm");
  static const CampaignFrame made = CampaignFrame::make(known.frame_format(), known.setup).value();
  return made;
}

// 13 blocks of each fault, the last one cut short.
CampaignPlan plan() {
  CampaignPlan asked{
      .format = "rxm", .rules = "", .seed = 7, .frames = 12 * block_frames + 1234, .faults = {}};
  for (const char* text :
       {"flips:0.1", "flips:0.01:0.1", "flips:0.1:fitting", "burst:8", "lost_clock"}) {
    asked.faults.push_back(*parse_fault(text));
  }
  return asked;
}

CampaignState run(unsigned threads, CampaignShard shard = {}) {
  CampaignState state(plan());
  EXPECT_TRUE(run_campaign(frame(), state, {.threads = threads, .shard = shard}));
  return state;
}

const CampaignState& whole() {
  static const CampaignState state = run(1);
  return state;
}

TEST(Campaign, AnyNumberOfThreads_GivesTheSame) {
  EXPECT_TRUE(whole().complete());
  for (const CampaignCounts& counts : whole().counts) EXPECT_EQ(counts.frames, plan().frames);
  EXPECT_EQ(run(2), whole());
  EXPECT_EQ(run(4), whole());
}

TEST(Campaign, EndedAtAnySave_GoesOnToTheSame) {
  std::string saved = state_text(CampaignState(plan()));
  unsigned ends = 0;
  for (bool done = false; !done && ends < 10'000; ++ends) {
    CampaignState state = read_state(saved).value();
    CampaignRun part{.threads = 3, .save_seconds = 0.001};
    const std::string begun = saved;
    // It ends with the first save that has more than the one before, however slow the machine is.
    // What is counted after that is lost, as it is when the process is killed.
    part.save = [&](const CampaignState& now) {
      saved = state_text(now);
      return saved == begun;
    };
    done = run_campaign(frame(), state, part);
    if (read_state(saved)->complete()) done = true;
  }
  EXPECT_GT(ends, 1U);
  EXPECT_EQ(read_state(saved), whole());
}

TEST(Campaign, SevenShards_AddUpToTheWhole) {
  CampaignState sum = run(2, {.number = 3, .count = 7});
  EXPECT_FALSE(sum.complete());
  for (const std::uint64_t number : {1U, 7U, 2U, 6U, 5U, 4U}) {
    ASSERT_TRUE(sum.merge(run(2, {.number = number, .count = 7})));
  }
  EXPECT_EQ(sum, whole());
}

TEST(Campaign, PartsThatDoNotBelongTogether_AreNotMerged) {
  CampaignState one = run(1, {.number = 1, .count = 2});
  const CampaignState before = one;
  EXPECT_FALSE(one.merge(one)) << "the same blocks twice";
  EXPECT_FALSE(one.merge(whole())) << "some blocks twice";
  CampaignPlan other = plan();
  ++other.seed;
  EXPECT_FALSE(one.merge(CampaignState(other)));
  EXPECT_EQ(one, before);
}

TEST(CampaignState, Text_ComesBack) {
  const CampaignState part = run(2, {.number = 2, .count = 3});
  EXPECT_EQ(read_state(state_text(part)), part);
}

TEST(CampaignState, DamagedText_IsRefused) {
  const std::string text = state_text(whole());
  for (std::size_t size = 0; size + 2 < text.size(); size += 97) {
    EXPECT_FALSE(read_state(text.substr(0, size)));
  }
  const auto changed = [&text](const std::string& from, const std::string& to) {
    std::string other = text;
    other.replace(other.find(from), from.size(), to);
    return read_state(other);
  };
  EXPECT_FALSE(changed("\"biss_campaign\":2", "\"biss_campaign\":3"));
  EXPECT_FALSE(changed("\"blocks\":[[0,13]]", "\"blocks\":[[0,12]]")) << "frames without a block";
  EXPECT_FALSE(changed("\"blocks\":[[0,13]]", "\"blocks\":[[0,14]]")) << "a block too many";
  EXPECT_FALSE(changed("[\"monitor\",", "[\"monitors\","));
  EXPECT_FALSE(changed("burst:8", "burst:1"));
  EXPECT_FALSE(changed("\"seed\":7", "\"seed\":\"7\""));
}

TEST(CampaignEstimate, PlainCounts_HaveWilsonsBounds) {
  CampaignCounts counts;
  counts.frames = 1000;
  for (int n = 0; n < 10; ++n) counts.add(Acceptance::cpw, 3);
  const CampaignEstimate found =
      estimate(frame(), *parse_fault("flips:0.1"), counts, Acceptance::cpw, std::nullopt);
  EXPECT_DOUBLE_EQ(static_cast<double>(found.rate), 0.01);
  // Wilson's interval of 10 in 1000.
  EXPECT_NEAR(static_cast<double>(found.low), 0.005441, 1e-6);
  EXPECT_NEAR(static_cast<double>(found.high), 0.0183095, 1e-6);
  EXPECT_FALSE(found.sigma);
}

TEST(CampaignEstimate, WeighedCounts_AreScaledByTheirLikelihood) {
  CampaignCounts counts;
  counts.frames = 1000;
  for (int n = 0; n < 100; ++n) counts.add(Acceptance::cpw, 3);
  const FaultChoice fault = *parse_fault("flips:0.125:0.25");
  const CampaignEstimate found = estimate(frame(), fault, counts, Acceptance::cpw, std::nullopt);
  const unsigned others = frame().cpw_bits() - 3;
  EXPECT_NEAR(static_cast<double>(found.rate), 0.1 * 0.125 * std::pow(0.875 / 0.75, others), 1e-12);
}

}  // namespace
}  // namespace biss::lab
