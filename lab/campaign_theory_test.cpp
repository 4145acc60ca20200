#include "lab/campaign_theory.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "biss/safety/configurations.hpp"
#include "lab/campaign.hpp"
#include "lab/structure.hpp"

namespace biss::lab {
namespace campaign_theory_test {

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
                           "burst:8", "burst:24", "lost_bit", "doubled_bit", "slo_low", "slo_high",
                           "lost_bit:3", "doubled_bit:40", "burst:6:20"}) {
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

// 8 and 6 bits of position: every possible reading for every position.
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
    // The checksums are independent of the position, so one position shows whether they pass.
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

// Bits of a word that must be received as sent, or the monitor rejects the word.
std::uint64_t fixed_bits(const ChannelFormat& word, bool counter) {
  std::uint64_t data = std::uint64_t{1} << word.error.shift;
  if (counter) data |= word.life_counter.placed(~std::uint64_t{0});
  return data << word.crc.width_bits;
}

// Where the position's lowest bit is in a word with its CRC.
unsigned position_shift(const ChannelFormat& word) {
  const unsigned shift = word.position.present()     ? word.position.shift
                         : word.singleturn.present() ? word.singleturn.shift
                                                     : word.multiturn.shift;
  return shift + word.crc.width_bits;
}

// Sums one word of the dual code for each index: bit j is whether error bit j inverts its sign.
std::vector<std::uint64_t> sign_words(const std::vector<std::uint32_t>& columns, unsigned width) {
  std::vector<std::uint64_t> words(std::size_t{1} << width);
  for (std::size_t word = 0; word < words.size(); ++word) {
    for (std::size_t bit = 0; bit < columns.size(); ++bit) {
      words[word] |= std::uint64_t{std::popcount(word & columns[bit]) % 2 != 0} << bit;
    }
  }
  return words;
}

std::vector<long double> powers_of(long double base) {
  std::vector<long double> powers{1};
  for (std::size_t n = 1; n < weight_count; ++n) powers.push_back(powers.back() * base);
  return powers;
}

// The mean of the sign over all error patterns that the monitor lets pass, for one word of either
// dual code; its mean over all of them is the probability of such a pattern with both CRCs good.
class PassingMean {
 public:
  // position_kept: only patterns that leave the control word's position alone.
  PassingMean(const CampaignFrame& frame, long double rate, bool position_kept)
      : rate_(rate), kept_(position_kept), tilt_(powers_of(1 - 2 * rate)) {
    const safety_detail::Alignment& alignment = frame.plan().alignment();
    bits_ = alignment.bits;
    cpw_shift_ = position_shift(frame.cpw_format()) + alignment.cpw_shift;
    spw_shift_ = position_shift(frame.spw_format()) + alignment.spw_shift;
    tolerant_ = frame.plan().setup().comparison.tolerance_lsb == 1;
    std::uint64_t cpw_fixed = fixed_bits(frame.cpw_format(), false);
    const std::uint64_t spw_fixed = fixed_bits(frame.spw_format(), true);
    const std::uint64_t compared = low_mask(bits_);
    if (position_kept) {
      const std::uint64_t position = low_mask(frame.cpw_format().position_bits())
                                     << position_shift(frame.cpw_format());
      cpw_fixed |= position & ~(compared << cpw_shift_);
    }
    cpw_free_ = low_mask(frame.cpw_bits()) & ~cpw_fixed & ~(compared << cpw_shift_);
    spw_free_ = low_mask(frame.spw_bits()) & ~spw_fixed & ~(compared << spw_shift_);
    fixed_ = powers_of(
        1 - rate)[static_cast<std::size_t>(std::popcount(cpw_fixed) + std::popcount(spw_fixed))];
    const long double good = 1 - rate;
    same_ = powers_of(kept_ ? good * good : good * good + rate * rate);
    apart_ = powers_of(kept_ ? good * good : good * good - rate * rate);
  }

  long double operator()(std::uint64_t cpw, std::uint64_t spw) const {
    const std::uint64_t a = (cpw >> cpw_shift_) & low_mask(bits_);
    const std::uint64_t b = (spw >> spw_shift_) & low_mask(bits_);
    long double sum = equal_above(a ^ b, 0);
    // The values read differ by 1 where their lowest k bits do, as in …0111 and …1000.
    long double differing = 1;
    for (unsigned k = 1; tolerant_ && k <= bits_; ++k) {
      differing *= one_wrong((a >> (k - 1U)) & 1U, (b >> (k - 1U)) & 1U);
      if (differing == 0) break;
      const int pairs = k == bits_ ? 4 : 2;  // from the last value to the first one too
      sum += differing * equal_above(a ^ b, k) *
             std::ldexp(static_cast<long double>(pairs), -static_cast<int>(k));
    }
    return sum * fixed_ *
           tilt_[static_cast<std::size_t>(std::popcount(cpw & cpw_free_) +
                                          std::popcount(spw & spw_free_))];
  }

 private:
  // Compared bits from `from` on are wrong in both words or in none.
  long double equal_above(std::uint64_t apart, unsigned from) const {
    const std::uint64_t upper = from >= bits_ ? 0 : apart >> from;
    const auto differing = static_cast<std::size_t>(std::popcount(upper));
    return apart_[differing] * same_[bits_ - from - differing];
  }
  // A compared bit is wrong in one word only.
  long double one_wrong(std::uint64_t a, std::uint64_t b) const {
    const long double in_spw = b != 0 ? -1 : 1;
    if (kept_) return rate_ * (1 - rate_) * in_spw;
    return rate_ * (1 - rate_) * (in_spw + (a != 0 ? -1 : 1));
  }

  long double rate_;
  bool kept_;
  bool tolerant_ = false;
  unsigned bits_ = 0;
  unsigned cpw_shift_ = 0;
  unsigned spw_shift_ = 0;
  std::uint64_t cpw_free_ = 0;
  std::uint64_t spw_free_ = 0;
  long double fixed_ = 1;
  std::vector<long double> tilt_;
  std::vector<long double> same_;
  std::vector<long double> apart_;
};

long double good_sum(const std::vector<std::uint64_t>& dual, long double rate) {
  const auto tilt = powers_of(1 - 2 * rate);
  long double sum = 0;
  for (const std::uint64_t word : dual) sum += tilt[static_cast<std::size_t>(std::popcount(word))];
  return sum / static_cast<long double>(dual.size());
}

long double passing(const PassingMean& mean, const std::vector<std::uint64_t>& cpw,
                    const std::vector<std::uint64_t>& spw) {
  long double sum = 0;
  for (const std::uint64_t a : cpw) {
    long double row = 0;
    for (const std::uint64_t b : spw) row += mean(a, b);
    sum += row;
  }
  return sum / static_cast<long double>(cpw.size()) / static_cast<long double>(spw.size());
}

// The theory of flips by another method: as a mean of signs over all pairs of dual words, in
// floating point. It shares no code with weights and pairs. The rounding error is about 1e-19 of 1,
// so differences below 1e-16 are not significant. \pre the conditions of campaign_theory()
CampaignTheory dual_sums(const CampaignFrame& frame, long double rate) {
  const auto cpw = sign_words(frame.cpw_columns(), frame.cpw_format().crc.width_bits);
  const auto spw = sign_words(frame.spw_columns(), frame.spw_format().crc.width_bits);
  const long double cpw_good = good_sum(cpw, rate);
  const long double spw_good = good_sum(spw, rate);
  const auto intact = powers_of(1 - rate);
  const long double all = passing(PassingMean(frame, rate, false), cpw, spw);
  const long double kept = passing(PassingMean(frame, rate, true), cpw, spw);
  return {cpw_good - intact[frame.cpw_bits()], spw_good - intact[frame.spw_bits()],
          cpw_good * spw_good - intact[frame.bits()], all - intact[frame.bits()], all - kept};
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

constexpr std::uint64_t around_seed = 3;

// Counters evenly distributed over all 64 values, as the analysis takes them.
CampaignFrame frame_with(const char* format, SafetyComparison comparison = {}) {
  SafetySetup setup;
  setup.comparison = comparison;
  setup.counter.mode = CounterMode::count_0_63;
  return CampaignFrame::make(parse_format(format).value(), setup).value();
}

long double wrong_share(const CampaignFrame& frame, const std::string& text) {
  return campaign_theory(frame, *parse_fault(text))->back();
}

// The model of a monitor with this setup, CDS sent as 0.
StructureModel structure_model_of(const SafetySetup& setup) {
  return {.pair = true, .comparison = setup.comparison};
}

void expect_as_analysed(const CampaignFrame& frame, const char* name, FaultKind fault,
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
    const CampaignFrame frame = frame_with(format, comparison);
    expect_as_analysed(frame, "lost_bit", FaultKind::lost_bit, 2);
    expect_as_analysed(frame, "doubled_bit", FaultKind::doubled_bit, 2);
    expect_as_analysed(frame, "inserted_low", FaultKind::inserted_low, 2);
    expect_as_analysed(frame, "inserted_high", FaultKind::inserted_high, 2);
    expect_as_analysed(frame, "slo_low", FaultKind::slo_low, 2);
    expect_as_analysed(frame, "slo_high", FaultKind::slo_high, 2);
    expect_as_analysed(frame, "gap_low:8", FaultKind::gap_low, 2);
    expect_as_analysed(frame, "gap_high:8", FaultKind::gap_high, 2);
    expect_as_analysed(frame, "false_start", FaultKind::false_start, 1);
    const StructureModel model = structure_model_of(frame.plan().setup());
    const auto late = structure_row(frame.format(), FaultKind::lost_start, model);
    EXPECT_NEAR(static_cast<double>(wrong_share(frame, "lost_start")),
                static_cast<double>(late.sum.pair), 1e-15);
  }
}

// Each position and counter of a small frame through the real reader and the monitor.
TEST(CampaignAround, SmallFrame_IsAsEnumerated) {
  for (const char* format :
       {"pos5,nE,crc3+pos3,nE,lc6,crc3", "pos5,nE,crc3+pos3,nE,lc6,crc3;cds0"}) {
    const CampaignFrame frame = frame_with(format);
    for (const char* text :
         {"inserted_low:9", "inserted_high:2", "gap_low:3:0", "gap_high:4:22", "lost_start",
          "false_start:0", "false_start:5", "cds_high", "stop_high"}) {
      const FaultChoice fault = *parse_fault(text);
      std::array<double, acceptance_count> sum{};
      for (std::uint64_t n = 0; n < 32U * 64U; ++n) {
        const SentFrame sent{n / 64U, static_cast<std::uint8_t>(n % 64U)};
        const WordPair received = frame.damage(frame.encode(sent), fault, around_seed, n);
        const FrameOutcome outcome = frame.judge(sent, received);
        sum[0] += outcome.cpw ? 1 : 0;
        sum[1] += outcome.spw ? 1 : 0;
        sum[2] += outcome.both ? 1 : 0;
        sum[3] += outcome.monitor ? 1 : 0;
        sum[4] += outcome.wrong ? 1 : 0;
      }
      const CampaignTheory theory = *campaign_theory(frame, fault);
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
                           "lost_start", "false_start", "cds_high", "stop_high"}) {
    const FaultChoice fault = *parse_fault(text);
    CampaignCounts counts;
    for (std::uint64_t block = 0; block < 5; ++block) {
      counts.add(count_block(frame, {fault, around_seed}, block));
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
  setup.bounds = {};
  const CampaignFrame any = CampaignFrame::make(known.frame_format(), setup).value();
  setup.bounds.ack_max_clocks = 30;
  const CampaignFrame frame = CampaignFrame::make(known.frame_format(), setup).value();
  // ACK, START and CDS are zeros as well.
  EXPECT_TRUE(frame.read({.cpw = std::uint64_t{1} << 16U, .start = false}));
  EXPECT_FALSE(frame.read({.cpw = std::uint64_t{1} << 15U, .start = false}));

  const FaultChoice fault = *parse_fault("lost_start");
  const WordPair late{.cpw = 0xFFU, .start = false};
  EXPECT_TRUE(any.read(late));
  EXPECT_FALSE(frame.read(late));
  EXPECT_LT(campaign_theory(frame, fault)->front(), campaign_theory(any, fault)->front());
}

}  // namespace campaign_theory_test
}  // namespace biss::lab
