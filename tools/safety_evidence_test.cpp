#include "tools/safety_evidence.hpp"

#include <gtest/gtest.h>

#include "biss/safety/configurations.hpp"

namespace biss::tools {
namespace {

EvidenceQuestion question_of(const EvidenceOptions& options) {
  const EvidenceChoice choice = choose_evidence(options, 1);
  EXPECT_TRUE(choice.question) << choice.error;
  return choice.question.value_or(EvidenceQuestion{});
}

TEST(EvidenceHash, PublishedVectors_AreReached) {
  // FIPS 180-4's examples.
  EXPECT_EQ(sha256_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(EvidenceQuestion, UncheckedBits_AreThoseOfTheDocuments) {
  const auto unchecked = [](const std::string& name) {
    EvidenceOptions options;
    options.format = name;
    const UncheckedBits bits = unchecked_bits(question_of(options));
    return std::array{bits.below_resolution, bits.not_compared, bits.turns};
  };
  using Bits = std::array<unsigned, 3>;
  EXPECT_EQ(unchecked("fs-36-28"), (Bits{8, 0, 0}));
  EXPECT_EQ(unchecked("fs-28-24"), (Bits{4, 0, 0}));
  EXPECT_EQ(unchecked("fs-32-32"), (Bits{0, 0, 0}));
  EXPECT_EQ(unchecked("rxm"), (Bits{4, 3, 0}));
  EXPECT_EQ(unchecked("rlh"), (Bits{8, 3, 0}));
  EXPECT_EQ(unchecked("rum"), (Bits{4, 3, 12}));
  EvidenceOptions ignored;
  ignored.format = "rsm";
  ignored.ignore_turns = true;
  EXPECT_EQ(unchecked_bits(question_of(ignored)).turns, 12U);
}

TEST(EvidenceQuestion, EveryConfiguration_IsMonitoredAsItsRowSays) {
  for (const SafetyConfiguration& each : safety_configurations) {
    EvidenceOptions options;
    options.format = each.name;
    const EvidenceQuestion question = question_of(options);
    EXPECT_EQ(question.configuration, each.name);
    EXPECT_EQ(question.setup, each.setup) << each.name;
    EXPECT_EQ(period_of(question.rate), each.setup.cycle_min) << each.name;
  }
}

TEST(EvidenceOptions, Kept_ComeBackAsTheyWere) {
  EvidenceOptions options;
  options.format = "rsm";
  options.frames = 1;
  options.faults = 2;
  options.cycles = 3;
  options.seed = ~std::uint64_t{0};
  options.bit_error_rates = {"1e-3", "0.5"};
  options.rate = kilohertz(8);
  options.setup = {.configuration = "rsm",
                   .counter = "count_0_63",
                   .compare_bits = 7,
                   .tolerance = 0,
                   .start_frames = 9,
                   .watchdog = nanoseconds(200'001),
                   .shortest = nanoseconds(3)};
  options.missed = "perhaps";
  options.ignore_turns = true;
  options.budget = 3;
  options.budget_window = milliseconds(5);
  const auto back = read_options("{\"options\": " + options_json(options) + "}");
  ASSERT_TRUE(back);
  EXPECT_EQ(options_json(*back), options_json(options));
  const EvidenceQuestion question = question_of(*back);
  EXPECT_EQ(question.setup.counter.missed, MissedFrames::perhaps);
  EXPECT_EQ(question.setup.comparison.multiturn, MultiturnRule::ignored);
  EXPECT_EQ(question.setup.budget, (SafetyBudget{3, milliseconds(5)}));
  EXPECT_EQ(question.setup.frame_gap_max, nanoseconds(200'001));
  EXPECT_EQ(question.setup.frame_gap_min, nanoseconds(3));
  EXPECT_TRUE(question.setup.latch);
}

TEST(EvidenceOptions, DamagedText_IsRefused) {
  const std::string good = "{\"options\": " + options_json({}) + "}";
  ASSERT_TRUE(read_options(good));
  EXPECT_FALSE(read_options(""));
  EXPECT_FALSE(read_options("{}"));
  EXPECT_FALSE(read_options(good.substr(0, good.size() / 2)));
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return read_options(text.replace(at, from.size(), to)).has_value();
  };
  EXPECT_FALSE(changed("\"seed\":1", "\"seed\":\"one\""));
  EXPECT_FALSE(changed("\"counter\":\"\"", "\"counter\":\"count_2_63\""));
  EXPECT_FALSE(changed("\"tolerance\":null", "\"tolerance\":256"));
  EXPECT_FALSE(changed("\"rate_hz\":null", "\"rate_hz\":0"));
  EXPECT_TRUE(changed("\"tolerance\":null", "\"tolerance\":255"));
}

TEST(EvidenceCoverage, Share_HasWilsonsLimits) {
  CoverageRow row{};
  row.committed = 1000;
  row.accepted_wrong = 10;
  set_share(row);
  EXPECT_DOUBLE_EQ(row.share, 0.01);
  EXPECT_NEAR(row.low, 0.0054407, 1e-6);
  EXPECT_NEAR(row.high, 0.0183095, 1e-6);
  row.accepted_wrong = 0;
  set_share(row);
  EXPECT_EQ(row.low, 0);
  EXPECT_NEAR(row.high, 0.003827, 1e-6);
}

}  // namespace
}  // namespace biss::tools
