// Faults of what is around the two words, and of the clock: the campaign's theory, its reader, and
// the analysis of structure.
#include <gtest/gtest.h>

#include <cmath>

#include "biss/safety/configurations.hpp"
#include "lab/campaign.hpp"
#include "lab/pair_checks.hpp"

namespace biss::lab {
namespace {

constexpr std::uint64_t seed = 3;

// Counters evenly distributed over all 64 values, as the analysis takes them.
CampaignFrame frame_of(const char* format, SafetyComparison comparison = {}) {
  SafetySetup setup;
  setup.comparison = comparison;
  setup.counter.mode = CounterMode::count_0_63;
  return CampaignFrame::make(parse_format(format).value(), setup).value();
}

long double wrong_share(const CampaignFrame& frame, const std::string& text) {
  return placed_theory(frame, *parse_fault(text)).back();
}

void expect_as_analysed(const CampaignFrame& frame, const char* name, StructuralFault fault,
                        unsigned first_place) {
  const StructureModel model = structure_model_of(frame.plan().setup());
  for (unsigned place = 0; place < frame.bits(); ++place) {
    const long double analysed =
        passed_shares(frame.format(), fault, place + first_place, model).pair;
    EXPECT_NEAR(
        static_cast<double>(wrong_share(frame, std::string(name) + ":" + std::to_string(place))),
        static_cast<double>(analysed), 1e-15)
        << name << " " << place;
  }
}

TEST(CampaignAround, WrongPositions_AreAsTheAnalysisOfStructureSays) {
  const struct {
    const char* format;
    SafetyComparison comparison;
  } cases[] = {{"pos12,nE,nW,crc4+pos8,nE,nW,lc6,crc5", {}},
               {"st10,nE,nW,crc3+st7,nE,nW,lc6,crc3;cds0", {.compare_bits = 4}},
               {"mt3,nE,nW,st8,crc4+mt3,st6,nE,nW,lc6,crc4", {.compare_bits = 5}}};
  for (const auto& [format, comparison] : cases) {
    const CampaignFrame frame = frame_of(format, comparison);
    expect_as_analysed(frame, "lost_clock", StructuralFault::lost_bit, 2);
    expect_as_analysed(frame, "double_clock", StructuralFault::doubled_bit, 2);
    expect_as_analysed(frame, "inserted_low", StructuralFault::inserted_low, 2);
    expect_as_analysed(frame, "inserted_high", StructuralFault::inserted_high, 2);
    expect_as_analysed(frame, "slo_low", StructuralFault::stuck_low, 2);
    expect_as_analysed(frame, "slo_high", StructuralFault::stuck_high, 2);
    expect_as_analysed(frame, "gap_low:8", StructuralFault::gap_low, 2);
    expect_as_analysed(frame, "gap_high:8", StructuralFault::gap_high, 2);
    expect_as_analysed(frame, "early_start", StructuralFault::early_start, 1);
    const StructureModel model = structure_model_of(frame.plan().setup());
    const auto late = structure_row(frame.format(), StructuralFault::late_start, model);
    EXPECT_NEAR(static_cast<double>(wrong_share(frame, "late_start")),
                static_cast<double>(late.sum.pair), 1e-15);
  }
}

// Each position and counter of a small frame through the real reader and the monitor.
TEST(CampaignAround, SmallFrame_IsAsEnumerated) {
  for (const char* format :
       {"pos5,nE,crc3+pos3,nE,lc6,crc3", "pos5,nE,crc3+pos3,nE,lc6,crc3;cds0"}) {
    const CampaignFrame frame = frame_of(format);
    for (const char* text :
         {"inserted_low:9", "inserted_high:2", "gap_low:3:0", "gap_high:4:22", "late_start",
          "early_start:0", "early_start:5", "cds_high", "stop_high"}) {
      const FaultChoice fault = *parse_fault(text);
      std::array<double, acceptance_count> sum{};
      for (std::uint64_t n = 0; n < 32U * 64U; ++n) {
        const SentFrame sent{n / 64U, static_cast<std::uint8_t>(n % 64U)};
        const WordPair received = frame.damage(frame.encode(sent), fault, seed, n);
        const FrameOutcome outcome = frame.judge(sent, received);
        sum[0] += outcome.cpw ? 1 : 0;
        sum[1] += outcome.spw ? 1 : 0;
        sum[2] += outcome.both ? 1 : 0;
        sum[3] += outcome.monitor ? 1 : 0;
        sum[4] += outcome.wrong ? 1 : 0;
      }
      const CampaignTheory theory = placed_theory(frame, fault);
      for (std::size_t what = 0; what < acceptance_count; ++what) {
        EXPECT_DOUBLE_EQ(static_cast<double>(theory[what]), sum[what] / (32 * 64))
            << format << " " << text << " " << acceptance_names[what];
      }
    }
  }
}

TEST(CampaignAround, Counts_AreWithinFiveDeviations) {
  const SafetyConfiguration& known = *find_safety_configuration("rxm");
  const CampaignFrame frame = CampaignFrame::make(known.frame_format(), known.setup).value();
  for (const char* text : {"inserted_low", "inserted_high:8", "gap_low:8", "gap_high:3",
                           "late_start", "early_start", "cds_high", "stop_high"}) {
    const FaultChoice fault = *parse_fault(text);
    CampaignCounts counts;
    for (std::uint64_t block = 0; block < 5; ++block) {
      counts.add(count_block(frame, {fault, seed}, block));
    }
    const CampaignTheory theory = *campaign_theory(frame, fault);
    for (std::size_t what = 0; what < acceptance_count; ++what) {
      const auto acceptance = static_cast<Acceptance>(what);
      const auto found = estimate(frame, fault, counts, acceptance, theory[what]);
      const double sigma = static_cast<double>(found.sigma.value_or(0));
      EXPECT_LT(std::abs(sigma), 5) << text << " " << acceptance_names[what];
      EXPECT_TRUE(theory[what] != 0 || counts.total(acceptance) == 0) << text;
    }
  }
}

TEST(CampaignAround, StartThatComesLaterThanTheBounds_IsNoFrame) {
  const SafetyConfiguration& known = *find_safety_configuration("fs-36-28");
  SafetySetup setup = known.setup;
  setup.bounds.ack_max_clocks = 30;
  const CampaignFrame frame = CampaignFrame::make(known.frame_format(), setup).value();
  // ACK, START and CDS are zeros as well.
  EXPECT_TRUE(frame.read({.cpw = std::uint64_t{1} << 16U, .start = false}));
  EXPECT_FALSE(frame.read({.cpw = std::uint64_t{1} << 15U, .start = false}));

  const CampaignFrame any = CampaignFrame::make(known.frame_format(), known.setup).value();
  const FaultChoice fault = *parse_fault("late_start");
  const WordPair late{.cpw = 0xFFU, .start = false};
  EXPECT_TRUE(any.read(late));
  EXPECT_FALSE(frame.read(late));
  EXPECT_LT(campaign_theory(frame, fault)->front(), campaign_theory(any, fault)->front());
}

}  // namespace
}  // namespace biss::lab
