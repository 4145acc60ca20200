#include "lab/campaign_theory.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "biss/safety/configurations.hpp"
#include "lab/campaign.hpp"
#include "lab/dual_sums.hpp"

namespace biss::lab {
namespace {

constexpr std::uint64_t seed = 1;

CampaignFrame frame_of(const char* name) {
  const SafetyConfiguration& known = *find_safety_configuration(name);
  return CampaignFrame::make(known.frame_format(), known.setup).value();
}

void expect_theory(const CampaignFrame& frame, const char* text, std::uint64_t blocks) {
  const FaultChoice fault = *parse_fault(text);
  const auto theory = campaign_theory(frame, fault);
  ASSERT_TRUE(theory);
  CampaignCounts counts;
  for (std::uint64_t block = 0; block < blocks; ++block) {
    counts.add(count_block(frame, {fault, seed}, block));
  }
  for (std::size_t what = 0; what < acceptance_count; ++what) {
    const auto found =
        estimate(frame, fault, counts, static_cast<Acceptance>(what), (*theory)[what]);
    if (found.sigma) {
      EXPECT_LT(std::abs(static_cast<double>(*found.sigma)), 5)
          << text << " " << acceptance_names[what];
    } else if ((*theory)[what] == 0) {
      EXPECT_EQ(counts.total(static_cast<Acceptance>(what)), 0U) << text;
    }
  }
}

TEST(CampaignTheory, Counts_AreWithinFiveDeviations) {
  const CampaignFrame frame = frame_of("rxm");
  for (const char* text : {"flips:0.5", "flips:0.1", "flips:0.01", "flips:0.01:0.1", "burst:4",
                           "burst:8", "burst:24", "lost_clock", "double_clock", "slo_low",
                           "slo_high", "lost_clock:3", "double_clock:40", "burst:6:20"}) {
    expect_theory(frame, text, 30);
  }
}

// Residual error of a control word with 38 data bits, and of a safety word with 36, at 1 %: the
// project's fact sheet, from the weights of the codes.
TEST(CampaignTheory, Words_HaveThePublishedResidualError) {
  const CampaignTheory theory = FlipsTheory(frame_of("fs-36-28")).at(0.01L);
  EXPECT_NEAR(static_cast<double>(theory[0]), 1.572e-4, 1e-7);
  EXPECT_NEAR(static_cast<double>(theory[1]), 3.806e-10, 1e-13);
}

// 8 and 6 bits of position: all that can be read, for every position.
TEST(CampaignTheory, SmallFrame_IsAsEnumerated) {
  SafetySetup setup;
  const auto frame =
      CampaignFrame::make(parse_format("pos5,nE,crc3+pos3,nE,lc6,crc3").value(), setup);
  ASSERT_TRUE(frame);
  const double rate = 0.125;
  const CampaignTheory theory = FlipsTheory(*frame).at(0.125L);
  std::array<double, acceptance_count> sum{};
  const std::uint64_t patterns = std::uint64_t{1} << frame->bits();
  for (std::uint64_t wrong = 1; wrong < patterns; ++wrong) {
    const double share = std::pow(rate, std::popcount(wrong)) *
                         std::pow(1 - rate, static_cast<int>(frame->bits()) - std::popcount(wrong));
    // The checksums do not look at the position, so one shows whether they pass.
    const auto received = [&](std::uint64_t position) {
      WordPair words = frame->encode({position, 9});
      words.cpw ^= wrong >> frame->spw_bits();
      words.spw ^= wrong & low_mask(frame->spw_bits());
      return words;
    };
    const FrameOutcome first = frame->judge({0, 9}, received(0));
    sum[0] += first.cpw ? share : 0;
    sum[1] += first.spw ? share : 0;
    if (!first.both) continue;
    sum[2] += share;
    for (std::uint64_t position = 0; position < 32; ++position) {
      const FrameOutcome outcome = frame->judge({position, 9}, received(position));
      sum[3] += outcome.monitor ? share / 32 : 0;
      sum[4] += outcome.wrong ? share / 32 : 0;
    }
  }
  for (std::size_t what = 0; what < acceptance_count; ++what) {
    EXPECT_NEAR(static_cast<double>(theory[what]), sum[what], 1e-12) << acceptance_names[what];
  }
}

// The other route: the mean of signs over all pairs of dual words, in floating point.
void expect_two_routes_agree(const CampaignFrame& frame, long double rate, const char* name) {
  const CampaignTheory theory = FlipsTheory(frame).at(rate);
  const CampaignTheory other = dual_sums(frame, rate);
  for (std::size_t what = 0; what < acceptance_count; ++what) {
    EXPECT_NEAR(static_cast<double>(theory[what] - other[what]), 0,
                1e-12 * static_cast<double>(theory[what]) + 1e-17)
        << name << " " << static_cast<double>(rate) << " " << acceptance_names[what];
  }
}

TEST(CampaignTheory, WeightsOfPairsAndDualSums_AreTheSame) {
  const struct {
    const char* format;
    SafetyComparison comparison;
  } cases[] = {
      {"pos20,nE,nW,crc6+pos16,nE,nW,lc6,crc8", {}},
      {"pos16,nE,nW,crc5+pos16,nE,nW,lc6,crc8", {.tolerance_lsb = 0}},
      {"st16,nE,nW,crc6+st12,nE,nW,lc6,crc7", {.compare_bits = 9}},
      {"mt12,st16,nE,nW,crc6+mt12,st12,nE,nW,lc6,crc7", {.compare_bits = 9}},
      {"mt12,st16,nE,nW,crc6+mt8,st12,nE,nW,lc6,crc7", {.multiturn = MultiturnRule::ignored}},
      {"mt12,st24,nE,nW,crc6+st16,nE,nW,lc6,crc6", {.compare_bits = 13}}};
  for (const auto& [text, comparison] : cases) {
    SafetySetup setup;
    setup.comparison = comparison;
    const auto frame = CampaignFrame::make(parse_format(text).value(), setup);
    ASSERT_TRUE(frame) << text;
    for (const long double rate : {0.5L, 0.3L, 0.1L, 0.01L}) {
      expect_two_routes_agree(*frame, rate, text);
    }
  }
  expect_two_routes_agree(frame_of("rxm"), 0.1L, "rxm");
}

TEST(CampaignTheory, MoreToleranceThanOneCount_HasNone) {
  SafetySetup setup;
  setup.comparison.tolerance_lsb = 2;
  const auto frame = CampaignFrame::make(find_safety_configuration("rxm")->frame_format(), setup);
  ASSERT_TRUE(frame);
  EXPECT_FALSE(campaign_theory(*frame, *parse_fault("flips:0.1")));
}

TEST(Campaign, ImportanceSampling_IsAddedWherePlainSeesTooLittle) {
  const CampaignFrame frame = frame_of("rxm");
  const FaultChoice fault = *parse_fault("flips:0.01");
  const auto weighed = importance_of(frame, fault, 1'000'000, *campaign_theory(frame, fault));
  ASSERT_EQ(weighed.size(), 2U);
  EXPECT_EQ(weighed[0].rate, fault.rate);
  EXPECT_GT(weighed[0].drawn_rate, fault.rate);
  EXPECT_EQ(text_of(weighed[1]), "flips:0.01:fitting");
  const FaultChoice high = *parse_fault("flips:0.5");
  const auto fitting = importance_of(frame, high, 1'000'000, *campaign_theory(frame, high));
  ASSERT_EQ(fitting.size(), 1U);
  EXPECT_EQ(text_of(fitting[0]), "flips:0.5:fitting");
  CampaignTheory enough{};
  enough.fill(1e-3L);
  EXPECT_TRUE(importance_of(frame, high, 1'000'000, enough).empty());
}

}  // namespace
}  // namespace biss::lab
