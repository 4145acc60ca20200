#include "lab/campaign.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

#include "biss/safety/configurations.hpp"
#include "lab/campaign_theory.hpp"

namespace biss::lab {
namespace campaign_test {

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
       {"flips:0.1", "flips:0.01:0.1", "flips:0.1:fitting", "burst:8", "lost_bit"}) {
    asked.faults.push_back(*parse_fault(text));
  }
  return asked;
}

CampaignState run(unsigned threads, Shard shard = {}) {
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
  for (const auto& row : whole().rows) EXPECT_EQ(row.counts.frames, plan().frames);
  EXPECT_EQ(run(2), whole());
  EXPECT_EQ(run(4), whole());
}

TEST(Campaign, EndedAtAnySave_GoesOnToTheSame) {
  std::string saved = state_text(CampaignState(plan()));
  unsigned ends = 0;
  for (bool done = false; !done && ends < 10'000; ++ends) {
    CampaignState state = read_state(saved).value();
    ExperimentRun part{.threads = 3, .save_seconds = 0.001};
    const std::string begun = saved;
    // Stops at the first save that has more events than the one before, on a machine of any speed.
    // Later counts are lost, as when the process is killed.
    part.save = [&] {
      saved = state_text(state);
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

// The text with the first `from` after `row` replaced.
std::string changed(const std::string& from, const std::string& to, const std::string& row = "") {
  std::string text = state_text(whole());
  const std::size_t at = text.find(from, row.empty() ? 0 : text.rfind("{\"acc", text.find(row)));
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string refusal_of(const std::string& text) {
  const auto state = read_state(text);
  return state ? "taken" : state.error();
}

TEST(CampaignState, TextThatEndsEarly_IsRefused) {
  const std::string text = state_text(whole());
  for (std::size_t size = 0; size + 2 < text.size(); size += 97) {
    EXPECT_EQ(refusal_of(text.substr(0, size)), "it is not JSON, or ends early");
  }
}

TEST(CampaignState, FieldOfAnotherKind_IsRefusedByName) {
  EXPECT_EQ(refusal_of("[]"), "it is not a state of a campaign");
  EXPECT_EQ(refusal_of(changed("\"biss_campaign\":2", "\"biss_campaign\":3")),
            "its version is 3, this program reads version 2");
  EXPECT_EQ(refusal_of(changed("\"seed\":7", "\"seed\":\"7\"")), "'seed' is not a number");
  EXPECT_EQ(refusal_of(changed("\"seed\":7", "\"seed\":-7")),
            "'seed' is -7, not a whole number from 0 to 18446744073709551615");
  EXPECT_EQ(refusal_of(changed("\"rules\"", "\"rule\"")), "'rules' is missing");
  EXPECT_EQ(refusal_of(changed("burst:8", "burst:1")), "\"burst:1\" is not a fault");
  EXPECT_EQ(refusal_of(changed("\"monitor\":", "\"monitors\":")),
            "flips:0.1: 'monitor' is missing");
}

TEST(CampaignState, BlocksThatAreNotTheFrames_AreRefused) {
  const std::string blocks = "\"blocks\":[[0,13]]";
  EXPECT_EQ(refusal_of(changed(blocks, "\"blocks\":[[0,12]]")),
            "flips:0.1: 'frames' is 787666, the blocks have 786432");
  EXPECT_EQ(refusal_of(changed(blocks, "\"blocks\":[[0,14]]")),
            "flips:0.1: 'blocks' is 14, not a whole number from 0 to 13");
  EXPECT_EQ(refusal_of(changed(blocks, "\"blocks\":[[0,12],[11,13]]")),
            "flips:0.1: 'blocks' are not in ascending order at [11,13]");
  EXPECT_EQ(refusal_of(changed(blocks, "\"blocks\":[[0]]")),
            "flips:0.1: 'blocks' has an entry without 2 values");
}

// Counts become rates in floating point: no count may exceed its frames.
TEST(CampaignState, CountThatCannotBe_IsRefused) {
  const std::string accepted = "\"cpw\":[[0,";
  for (const auto& [count, shown] : {std::pair{"-5", "-5"}, std::pair{"99999999", "99999999"},
                                     std::pair{"1e308", "1e+308"}, std::pair{"1.5", "1.5"}}) {
    EXPECT_EQ(refusal_of(changed(accepted, accepted + count + "],[0,", "burst:8")),
              "burst:8: 'cpw' is " + std::string(shown) + ", not a whole number from 0 to 787666");
  }
  EXPECT_EQ(refusal_of(changed(accepted, "\"cpw\":[[0,1],[0,", "burst:8")),
            "burst:8: 'cpw' has the weight 0 twice");
  EXPECT_EQ(refusal_of(changed(accepted, "\"cpw\":[[1,", "burst:8")),
            "burst:8: 'cpw' is 1, not a whole number from 0 to 0");
  EXPECT_EQ(refusal_of(changed("\"wrong\":[[0,", "\"wrong\":[[0,7", "burst:8")),
            "burst:8: 'wrong' has more frames than 'monitor'");
  EXPECT_EQ(refusal_of(changed("[\"monitor\",", "[\"monitors\",")),
            "flips:0.1:fitting: 'fitted' has an entry of an unknown kind");
  EXPECT_EQ(refusal_of(changed("[\"monitor\",", "[\"monitor\",300,", "fitting")),
            "flips:0.1:fitting: 'fitted' has an entry without 5 values");
  EXPECT_EQ(refusal_of(changed("\"missed\":[", "\"missed\":[787666,", "burst:8")),
            "burst:8: 'missed' has 17 frames, 'wrong' asks for 16");
}

TEST(CampaignState, MoreWrongBitsThanTheWordsHave_DoNotFit) {
  EXPECT_TRUE(fits(frame(), whole()));
  CampaignState state = whole();
  state.rows[0].counts.add(Acceptance::cpw, frame().cpw_bits() + 1U);
  EXPECT_FALSE(fits(frame(), state));
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

}  // namespace campaign_test
}  // namespace biss::lab
