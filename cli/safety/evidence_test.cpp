#include "cli/safety/evidence.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "biss/safety/configurations.hpp"
#include "cli/common/text_file.hpp"
#include "cli/safety/format.hpp"
#include "sim/fault.hpp"

namespace biss::cli {
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

// Numbers that would be others when they are made to fit.
TEST(EvidenceOptions, NumbersOutOfRange_AreRefused) {
  EvidenceOptions options;
  options.rate = kilohertz(8);
  options.setup.watchdog = nanoseconds(200'001);
  const std::string good = "{\"options\": " + options_json(options) + "}";
  ASSERT_TRUE(read_options(good));
  const auto changed = [&](const std::string& name, const std::string& value) {
    std::string text = good;
    const std::size_t at = text.find("\"" + name + "\":") + name.size() + 3;
    return read_options(text.replace(at, text.find_first_of(",}", at) - at, value)).has_value();
  };
  EXPECT_TRUE(changed("frames", "1099511627776"));
  EXPECT_FALSE(changed("frames", "1099511627777"));
  for (const char* name :
       {"frames", "faults", "cycles", "seed", "rate_hz", "compare_bits", "tolerance",
        "start_frames", "watchdog_ps", "shortest_gap_ps", "budget", "budget_window_ps"}) {
    EXPECT_TRUE(changed(name, "1")) << name;
    EXPECT_FALSE(changed(name, "-1")) << name;
    EXPECT_FALSE(changed(name, "1.5")) << name;
    EXPECT_EQ(changed(name, "18446744073709551615"), std::string(name) == "seed") << name;
  }
  EXPECT_FALSE(changed("rate_hz", "4294967297"));
  EXPECT_FALSE(changed("watchdog_ps", "1000000000000001"));
  EXPECT_FALSE(changed("safety", "\"rsn\""));
}

TEST(EvidenceQuestion, FormatsText_IsMonitoredByItsWidths) {
  const auto* rsh = find_safety_configuration("rsh");
  ASSERT_NE(rsh, nullptr);
  EvidenceOptions options;
  options.format = rsh->format;
  const EvidenceQuestion by_text = question_of(options);
  EXPECT_EQ(by_text.setup, SafetySetup{});
  EXPECT_EQ(campaign_name(by_text), rsh->format);
  options.setup.configuration = "rsh";
  EXPECT_EQ(question_of(options).setup, rsh->setup);
  // As the campaign takes each -f.
  for (const char* name :
       {"rsh", "fs-36-28", "fortis-fs-36-28", "mt12,st24,nE,nW,crc6+mt12,st16,nE,nW,lc6,crc16"}) {
    options = {};
    options.format = name;
    const SafetySetup setup = parse_safety_format(name).value().setup;
    EXPECT_EQ(question_of(options).setup, setup) << name;
  }
  // The catalogue's name is a name.
  options = {};
  options.format = "fortis-fs-36-28";
  EXPECT_EQ(question_of(options).configuration, "fs-36-28");
}

// At the rate at which an encoder comes to rest only with the next request.
TEST(EvidenceLine, EachFault_IsToldInItsTimeOrDidNoHarm) {
  EvidenceOptions options;
  options.format = "fs-36-28";
  options.cycles = 2000;
  const EvidencePart part = evidence_line(question_of(options));
  EXPECT_THAT(part.findings, testing::IsEmpty());
  EXPECT_EQ(part.coverage.size(), sim::simulated_fault_count);
  for (const CoverageRow& row : part.coverage) {
    EXPECT_GT(row.committed, 30U) << row.fault;
    // These last for up to three cycles, and not each of them has a row that shows it.
    const std::set<std::string> lasting{"ma_low", "ma_high", "swap_ma", "delay_step"};
    EXPECT_LE(row.reaction.value_or(0), lasting.contains(row.fault) ? 4U : 1U) << row.fault;
    if (row.fault == "late_start" || row.fault == "no_answer" || row.fault == "delay") {
      EXPECT_EQ(row.detected, row.committed) << row.fault;
    }
    // As `biss decode` finds it beside `simulate --truth`: 73 % and 9 %.
    const double share = static_cast<double>(*row.detected) / static_cast<double>(row.committed);
    if (row.fault == "lost_clock") {
      EXPECT_NEAR(share, 0.73, 0.2);
    }
    if (row.fault == "glitch_slo") {
      EXPECT_NEAR(share, 0.09, 0.09);
    }
  }
}

TEST(EvidenceReadme, NothingRun_IsSaid) {
  EvidenceOptions options;
  options.format = "fs-36-28";
  options.frames = 0;
  options.cycles = 0;
  EXPECT_EQ(not_run(options).size(), 2U);
  CoverageRow never{};
  never.by = "line";
  never.fault = "flip";
  CoverageRow always{};
  always.fault = "frozen";
  always.committed = always.accepted_wrong = 7;
  always.theory = 1;
  CoverageRow none{};
  none.fault = "cut";
  none.committed = 100;
  none.theory = 0;
  for (CoverageRow* row : {&always, &none}) set_share(*row);
  const std::string text = evidence_readme(question_of(options), {never, always, none}, {}).text;
  using testing::HasSubstr;
  EXPECT_THAT(text, HasSubstr("**Nothing was run: line.csv (--cycles 0).**"));
  EXPECT_THAT(text, HasSubstr("**Nothing was run: campaign.csv"));
  EXPECT_THAT(text, HasSubstr("In the rest no count"));
  EXPECT_THAT(text, HasSubstr("nothing is known of them:** `flip` (line).\n"));
  EXPECT_THAT(text, HasSubstr("| `frozen` | 7 | 7 | 0: never seen | 0 |\n"));
  EXPECT_THAT(text, HasSubstr("| `cut` | 100 | 0 | 1 - 3.70e-02 | 1 |\n"));
  EXPECT_THAT(text, HasSubstr("up to 1 count** of the lowest bit compared, in the CPW 256,"));
  options.setup.tolerance = 0;
  const std::string exact = evidence_readme(question_of(options), {}, {}).text;
  EXPECT_EQ(exact.find("A difference of up to"), std::string::npos);
  for (const std::string& each : {text, exact}) EXPECT_EQ(each.find(" \n"), std::string::npos);
}

TEST(EvidencePages, LinksOutOfTheBundle_ArePlainText) {
  EXPECT_EQ(page_of_bundle("see [status.md](status.md), [the page](safety.md), a[3](x)"),
            "see status.md, [the page](safety.md), a3");
  const std::string page = page_of_bundle(safety_page);
  EXPECT_EQ(page.find("](safety-analysis.md"), std::string::npos);
  EXPECT_NE(page.find("](safety-matrix.md"), std::string::npos);
}

TEST(TextFile, WhatCannotBeRead_IsNamed) {
  EXPECT_EQ(read_text_file("/dev/null").text, "");
  EXPECT_TRUE(read_text_file("/dev/null"));
  EXPECT_EQ(read_text_file("/").error, "it is a directory");
  EXPECT_EQ(read_text_file("/none/at/all").error, "cannot open it: No such file or directory");
  EXPECT_EQ(read_text_file("/dev/zero").error, "it is larger than 64 MiB");
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
}  // namespace biss::cli
