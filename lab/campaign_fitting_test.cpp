#include "lab/campaign_fitting.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "biss/safety/configurations.hpp"
#include "lab/campaign.hpp"
#include "lab/campaign_theory.hpp"

namespace biss::lab {
namespace campaign_fitting_test {

constexpr std::uint64_t seed = 5;

CampaignFrame frame_of(const char* text, SafetyComparison comparison = {}) {
  SafetySetup setup;
  setup.comparison = comparison;
  const SafetyConfiguration* known = find_safety_configuration(text);
  return CampaignFrame::make(known != nullptr ? known->frame_format() : parse_format(text).value(),
                             setup)
      .value();
}

// Also with fewer than 1000 effective events.
double sigma_of(const CampaignFrame& frame, const FaultChoice& fault, const CampaignCounts& counts,
                Acceptance what, CampaignTheories& theories) {
  const long double theory = (*theories.of(fault))[static_cast<std::size_t>(what)];
  const CampaignEstimate found = estimate(frame, fault, counts, what, theory);
  EXPECT_GT(found.effective, 10);
  return static_cast<double>((found.rate - theory) / (found.high - found.rate) * 1.959963985L);
}

CampaignCounts counted(const CampaignFrame& frame, const FaultChoice& fault, std::uint64_t blocks) {
  CampaignCounts counts;
  for (std::uint64_t block = 0; block < blocks; ++block) {
    counts.add(count_block(frame, {fault, seed}, block));
  }
  return counts;
}

void expect_theory(const CampaignFrame& frame, const char* name, std::uint64_t blocks) {
  CampaignTheories theories(frame);
  for (const char* text :
       {"flips:0.5:fitting", "flips:0.1:fitting", "flips:0.01:fitting", "flips:1e-4:fitting"}) {
    const FaultChoice fault = *parse_fault(text);
    const CampaignCounts counts = counted(frame, fault, blocks);
    EXPECT_EQ(counts.total(Acceptance::cpw), 0U);
    for (const Acceptance what : {Acceptance::monitor, Acceptance::wrong}) {
      EXPECT_LT(std::abs(sigma_of(frame, fault, counts, what, theories)), 5) << name << " " << text;
    }
  }
}

TEST(FittingDraws, EveryFormat_IsWithinFiveDeviationsOfTheTheory) {
  for (const char* name : {"fs-36-28", "fs-32-32", "fs-28-24", "rsh", "rum"}) {
    expect_theory(frame_of(name), name, 1);
  }
  expect_theory(frame_of("fs-36-28", {.compare_bits = 13}), "13 bits compared", 1);
  expect_theory(frame_of("rlh", {.compare_bits = 1}), "turns and one bit compared", 1);
  expect_theory(frame_of("rsm", {.multiturn = MultiturnRule::ignored}), "turns ignored", 1);
  expect_theory(frame_of("fs-28-24", {.tolerance_lsb = 0}), "no tolerance", 1);
}

// With these few bits every pattern occurs many times, so a wrong weight would be visible.
TEST(FittingDraws, SmallFrames_AreWithinFiveDeviationsOfTheTheory) {
  for (const char* text :
       {"pos5,nE,crc3+pos3,nE,lc6,crc3", "pos3,nE,nW,crc3+pos4,nE,nW,lc6,crc4",
        "mt2,st3,pad2,nE,crc4+mt3,st2,nE,pad1,lc6,crc3", "pos2,nE,crc3+pos2,nE,lc6,crc3"}) {
    expect_theory(
        frame_of(text, {.tolerance_lsb = text[3] == '2' ? std::uint8_t{0} : std::uint8_t{1}}), text,
        3);
  }
}

TEST(FittingDraws, HalfOfThem_AreAcceptedAtARateNoCampaignSees) {
  const CampaignFrame frame = frame_of("fs-36-28");
  const FaultChoice fault = *parse_fault("flips:0.5:fitting");
  const CampaignCounts counts = counted(frame, fault, 1);
  EXPECT_GT(counts.total(Acceptance::wrong), 20'000U);
  EXPECT_LT(counts.total(Acceptance::monitor), 40'000U) << "and the others refused";
  const auto theory = *campaign_theory(frame, fault);
  const auto found = estimate(frame, fault, counts, Acceptance::wrong, theory[4]);
  EXPECT_NEAR(static_cast<double>(found.rate), 1.041e-17, 5e-19);
  EXPECT_GE(found.effective, 1000);
  ASSERT_TRUE(found.sigma);
}

TEST(FittingDraws, FewEffectiveEvents_HaveNoSigma) {
  const CampaignFrame frame = frame_of("fs-36-28");
  const FaultChoice fault = *parse_fault("flips:0.01:fitting");
  const auto found = estimate(frame, fault, counted(frame, fault, 1), Acceptance::wrong, 1e-6L);
  EXPECT_LT(found.effective, 1000);
  EXPECT_FALSE(found.sigma);
}

TEST(FittingDraws, Replayed_AreTheFramesThatWereCounted) {
  const CampaignFrame frame = frame_of("fs-36-28");
  const FaultSequence sequence{*parse_fault("flips:0.1:fitting"), seed};
  const CampaignCounts counts = count_block(frame, sequence, 2, 100);
  ASSERT_FALSE(counts.missed.empty());
  for (const std::uint64_t index : counts.missed) {
    const ReplayedFrame replayed = replay_frame(frame, sequence, index);
    const SafetyJudgement judgement = frame.monitor(replayed.sent, replayed.received);
    EXPECT_EQ(judgement.verdict, SafetyVerdict::safe) << index;
    EXPECT_NE(control_position(frame.plan(), *judgement.position), replayed.sent.position) << index;
  }
}

// One check of the theory differs from the monitor.
TEST(FittingDraws, TheoryOfAnotherComparison_IsFarFromTheCounts) {
  const CampaignFrame frame = frame_of("fs-36-28");
  const FaultChoice fault = *parse_fault("flips:0.5:fitting");
  const CampaignCounts counts = counted(frame, fault, 1);
  for (const SafetyComparison& other :
       {SafetyComparison{.tolerance_lsb = 0}, SafetyComparison{.compare_bits = 27}}) {
    const CampaignFrame another = frame_of("fs-36-28", other);
    CampaignTheories theories(another);
    EXPECT_GT(std::abs(sigma_of(frame, fault, counts, Acceptance::wrong, theories)), 5);
  }
}

// An independent receiver; one of its checks can be left out.
class PlainReceiver {
 public:
  enum class Check { none, cpw_crc, spw_crc, cpw_error, spw_error, counter, comparison, tolerance };

  PlainReceiver(const CampaignFrame& frame, Check left_out) : frame_(frame), left_out_(left_out) {}

  FrameOutcome judge(const SentFrame& sent, const WordPair& received) const {
    const std::uint64_t cpw_data = received.cpw >> 6U;
    const std::uint64_t spw_data = received.spw >> 16U;
    const Channel cpw = unpack(frame_.cpw_format(), cpw_data);
    const Channel spw = unpack(frame_.spw_format(), spw_data);
    const auto apart = static_cast<std::int32_t>(
        static_cast<std::uint32_t>(((cpw.position >> 8U) - spw.position) << 4U));
    const std::int32_t most = left_out_ == Check::tolerance ? 2 : 1;
    const auto passes = [this](Check check, bool good) { return good || left_out_ == check; };
    const auto& codec = frame_.plan().codec();
    FrameOutcome outcome;
    outcome.monitor =
        received != frame_.encode(sent) &&
        passes(Check::cpw_crc, codec.crc(0, cpw_data, false) == (received.cpw & 0x3FU)) &&
        passes(Check::spw_crc, codec.crc(1, spw_data, false) == (received.spw & 0xFFFFU)) &&
        passes(Check::cpw_error, cpw.nE) && passes(Check::spw_error, spw.nE) &&
        passes(Check::counter, spw.life_counter == sent.life_counter) &&
        passes(Check::comparison, apart / 16 <= most && apart / 16 >= -most);
    outcome.wrong = outcome.monitor && cpw.position != sent.position;
    return outcome;
  }

 private:
  const CampaignFrame& frame_;
  Check left_out_;
};

TEST(FittingDraws, MonitorWithoutOneOfItsChecks_IsFarFromTheTheory) {
  const CampaignFrame frame = frame_of("fs-36-28");
  using Check = PlainReceiver::Check;
  constexpr std::array checks{Check::none,       Check::cpw_crc,   Check::spw_crc,
                              Check::cpw_error,  Check::spw_error, Check::counter,
                              Check::comparison, Check::tolerance};
  const FaultChoice fault = *parse_fault("flips:0.5:fitting");
  const FittingDraws draws(frame, fault.rate);
  std::array<CampaignCounts, checks.size()> counts;
  for (std::uint64_t index = 0; index < 500'000; ++index) {
    const SentFrame sent = frame.draw(seed, index);
    const FittingDraws::Pattern pattern = draws.draw(sent, seed, index);
    const WordPair received = frame.flipped(frame.encode(sent), pattern.wrong);
    for (std::size_t k = 0; k < checks.size(); ++k) {
      ++counts[k].frames;
      const bool wrong = PlainReceiver(frame, checks[k]).judge(sent, received).wrong;
      if (wrong) ++counts[k].fitted[{Acceptance::wrong, pattern.bits}];
    }
  }
  CampaignTheories theories(frame);
  for (std::size_t k = 0; k < checks.size(); ++k) {
    const double sigma = sigma_of(frame, fault, counts[k], Acceptance::wrong, theories);
    if (checks[k] == Check::none) {
      EXPECT_LT(std::abs(sigma), 5);
    } else {
      EXPECT_GT(sigma, 5) << k;
    }
  }
}

}  // namespace campaign_fitting_test
}  // namespace biss::lab
