#include "verbs/safety/evidence.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "biss/safety/configurations.hpp"
#include "cli/test_verb_harness.hpp"
#include "lab/pair.hpp"
#include "sim/fault.hpp"
#include "verbs/common/safety_format.hpp"
#include "verbs/common/text_file.hpp"

namespace biss::verbs {
namespace evidence_test {

EvidenceSubject subject_of(const EvidenceOptions& options) {
  const auto choice = choose_evidence(options);
  EXPECT_TRUE(choice.has_value()) << choice.error();
  return choice.value_or(EvidenceSubject{});
}

TEST(EvidenceHash, PublishedVectors_AreReached) {
  // FIPS 180-4's examples.
  EXPECT_EQ(sha256_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(EvidenceSubject, UncheckedBits_AreThoseOfTheDocuments) {
  const auto unchecked = [](const std::string& name) {
    EvidenceOptions options;
    options.format = name;
    const auto bits = subject_of(options).monitored.unchecked_bits();
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
  EXPECT_EQ(subject_of(ignored).monitored.unchecked_bits().turns, 12U);
}

TEST(EvidenceSubject, EveryConfiguration_IsMonitoredAsItsRowSays) {
  for (const SafetyConfiguration& each : safety_configurations) {
    EvidenceOptions options;
    options.format = each.name;
    const EvidenceSubject subject = subject_of(options);
    EXPECT_EQ(subject.configuration, each.name);
    EXPECT_EQ(subject.monitored.setup, each.setup) << each.name;
    EXPECT_EQ(period_of(subject.rate), each.setup.cycle_min) << each.name;
  }
}

EvidenceOptions options_with_everything() {
  EvidenceOptions options;
  options.format = "rsm";
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
  return options;
}

TEST(EvidenceSubject, EveryOption_IsInTheSetup) {
  const SafetySetup setup = subject_of(options_with_everything()).monitored.setup;
  EXPECT_EQ(setup.counter.mode, CounterMode::count_0_63);
  EXPECT_EQ(setup.counter.missed, MissedFrames::perhaps);
  EXPECT_EQ(setup.comparison, (SafetyComparison{7, 0, MultiturnRule::ignored}));
  EXPECT_EQ(setup.budget, (SafetyBudget{3, milliseconds(5)}));
  EXPECT_EQ(setup.start_frames, 9U);
  EXPECT_EQ(setup.frame_gap_max, nanoseconds(200'001));
  EXPECT_EQ(setup.frame_gap_min, nanoseconds(3));
  EXPECT_TRUE(setup.latch);
}

TEST(ConfigurationJson, Written_IsReadTheSame) {
  std::vector<EvidenceOptions> all{options_with_everything()};
  for (const SafetyConfiguration& each : safety_configurations) {
    all.emplace_back().format = each.name;
  }
  for (const EvidenceOptions& options : all) {
    const EvidenceSubject subject = subject_of(options);
    const auto back =
        parse_configuration_json(configuration_json(subject.monitored, subject.configuration));
    ASSERT_TRUE(back) << options.format;
    EXPECT_EQ(back->format, subject.monitored.format);
    EXPECT_EQ(back->setup, subject.monitored.setup);
    EXPECT_EQ(back->device, options.format);
  }
}

TEST(ConfigurationJson, DamagedText_IsRefused) {
  const std::string good = configuration_json(subject_of(options_with_everything()).monitored, "");
  ASSERT_TRUE(parse_configuration_json(good));
  EXPECT_FALSE(parse_configuration_json(""));
  EXPECT_FALSE(parse_configuration_json("{}"));
  EXPECT_FALSE(parse_configuration_json(good.substr(0, good.size() / 2)));
  const auto changed = [&](const std::string& name, const std::string& value) {
    std::string text = good;
    const std::size_t at = text.find("\"" + name + "\": ") + name.size() + 4;
    return parse_configuration_json(text.replace(at, text.find_first_of(",\n}", at) - at, value))
        .has_value();
  };
  for (const char* name : {"start_frames", "compare_bits", "tolerance_lsb", "near_frames",
                           "frame_gap_max", "window", "ack_max_clocks"}) {
    EXPECT_FALSE(changed(name, "-1")) << name;
    EXPECT_FALSE(changed(name, "1.5")) << name;
    EXPECT_FALSE(changed(name, "18446744073709551615")) << name;
  }
  EXPECT_TRUE(changed("tolerance_lsb", "1"));
  EXPECT_FALSE(changed("tolerance_lsb", "256"));
  EXPECT_FALSE(changed("latch", "1"));
  EXPECT_FALSE(changed("mode", "\"count_2_63\""));
  EXPECT_FALSE(changed("cpw", "7"));
  EXPECT_FALSE(changed("format", "\"pos12,crc6\""));
  EXPECT_FALSE(changed("start_frames", "1"));
}

TEST(EvidenceCommands, MonitorOfAnyName_IsGivenShortly) {
  EvidenceOptions options;
  const auto format_of = [&] { return evidence_commands(subject_of(options)).back().arguments[3]; };
  options.format = "fs-36-28";
  EXPECT_EQ(format_of(), "fs-36-28");
  options.setup.tolerance = 0;
  EXPECT_EQ(format_of(), "configuration.json");
  options = {};
  options.format = find_safety_configuration("rsh")->format;
  EXPECT_EQ(format_of(), options.format);
  options.setup.configuration = "rsh";
  EXPECT_EQ(format_of(), "rsh");
  EXPECT_EQ(command_line({"safety", "line", "-f", "a;b", "--cycles", "7"}),
            "biss safety line -f 'a;b' --cycles 7");
}

TEST(EvidenceSubject, FormatsText_IsMonitoredByItsWidths) {
  const auto* rsh = find_safety_configuration("rsh");
  ASSERT_NE(rsh, nullptr);
  EvidenceOptions options;
  options.format = rsh->format;
  EXPECT_EQ(subject_of(options).monitored.setup, SafetySetup{});
  options.setup.configuration = "rsh";
  EXPECT_EQ(subject_of(options).monitored.setup, rsh->setup);
  // The format that the campaign gets from each -f.
  for (const char* name :
       {"rsh", "fs-36-28", "fortis-fs-36-28", "mt12,st24,nE,nW,crc6+mt12,st16,nE,nW,lc6,crc16"}) {
    options = {};
    options.format = name;
    const SafetySetup setup = parse_safety_format(name).value().setup;
    EXPECT_EQ(subject_of(options).monitored.setup, setup) << name;
  }
  // A name of the catalogue is a valid name.
  options = {};
  options.format = "fortis-fs-36-28";
  EXPECT_EQ(subject_of(options).configuration, "fs-36-28");
}

std::vector<std::map<std::string, std::string>> rows_of(const std::string& csv) {
  std::vector<std::map<std::string, std::string>> rows;
  std::vector<std::string> names;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line);
    std::vector<std::string> row;
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
    if (names.empty()) {
      names = row;
      continue;
    }
    row.resize(names.size());
    auto& named = rows.emplace_back();
    for (std::size_t k = 0; k < names.size(); ++k) named[names[k]] = row[k];
  }
  return rows;
}

TEST(SafetySequences, UsualPlan_HasBothCountersBothMistakesAndEightKinds) {
  const lab::SequencePlan plan =
      usual_sequences(parse_safety_format("fs-28-24").value(), 100, 80, 1);
  std::uint64_t undamaged = 0;
  std::uint64_t mistakes = 0;
  std::uint64_t faults = 0;
  for (const lab::SequenceRow& row : plan.rows) {
    if (row.task == lab::SequenceTask::undamaged) undamaged += row.size;
    if (row.task == lab::SequenceTask::counter_mode) mistakes += row.size;
    if (row.task == lab::SequenceTask::fault) faults += row.size;
  }
  EXPECT_EQ(undamaged, 400U);
  EXPECT_EQ(mistakes, 160U);
  EXPECT_EQ(faults, 640U);
}

// At a rate at which the encoder becomes ready only when the next request begins.
TEST(SafetyLine, EachFault_IsDetectedInTimeOrDoesNoHarm) {
  const Ran ran = run_verb({"safety", "line", "-f", "fs-36-28", "--cycles", "2000", "--to", "csv"});
  EXPECT_EQ(ran.status, ExitStatus::done) << ran.err;
  const auto rows = rows_of(ran.out);
  EXPECT_EQ(rows.size(), sim::simulated_fault_count);
  for (const auto& row : rows) {
    const std::string& fault = row.at("fault");
    EXPECT_GT(std::stoul(row.at("injected")), 30U) << fault;
    EXPECT_EQ(row.at("false_alarms"), "0") << fault;
    // These faults last up to three cycles, and not every cycle has a row that shows them.
    const std::set<std::string> lasting{"ma_low", "ma_high", "swap_ma", "delay_step"};
    if (!row.at("reaction_cycles").empty()) {
      EXPECT_LE(std::stoul(row.at("reaction_cycles")), lasting.contains(fault) ? 4U : 1U) << fault;
    }
    if (fault == "late_start" || fault == "no_answer" || fault == "delay") {
      EXPECT_EQ(row.at("detected"), row.at("injected")) << fault;
    }
    // The shares that `biss decode` finds with `simulate --truth`: 73 % and 9 %.
    const double share = std::stod(row.at("detected")) / std::stod(row.at("injected"));
    if (fault == "lost_clock") {
      EXPECT_NEAR(share, 0.73, 0.2);
    }
    if (fault == "glitch_slo") {
      EXPECT_NEAR(share, 0.09, 0.09);
    }
  }
}

TEST(SafetyLine, WrongUsage_IsNamed) {
  const auto refused = [](const std::vector<std::string>& more, const std::string& what) {
    std::vector<std::string> arguments{"safety", "line"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Ran ran = run_verb(arguments);
    EXPECT_EQ(ran.status, ExitStatus::usage) << ran.err;
    EXPECT_THAT(ran.err, testing::HasSubstr(what));
  };
  refused({}, "--format");
  refused({"-f", "resolute-26"}, "resolute-26");
  refused({"-f", "/none/at/all.json"}, "cannot open it");
  refused({"-f", "fs-36-28", "--rate", "200kHz"}, "the line model");
  refused({"-f", "fs-36-28", "--rate", "1Hz", "--cycles", "4000000000"}, "100 days");
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
  always.by = "line";
  always.fault = "frozen";
  always.injected = always.accepted_wrong = 7;
  const EvidenceSubject subject = subject_of(options);
  auto commands = evidence_commands(subject);
  const std::string text = readme_file(subject, commands, {never, always}).text;
  using testing::HasSubstr;
  EXPECT_THAT(text, HasSubstr("**Nothing was run: line.csv (--cycles 0).**"));
  EXPECT_THAT(text, HasSubstr("**Nothing was run: campaign.csv"));
  EXPECT_THAT(text, HasSubstr("Every command ended with exit status 0"));
  EXPECT_THAT(text, HasSubstr("**Never injected, so nothing is known of them:** `flip` (line).\n"));
  EXPECT_THAT(text, HasSubstr("**Never detected:** `frozen` (line).\n"));
  EXPECT_THAT(text, HasSubstr("up to 1 count** of the lowest bit compared, in the CPW 256,"));
  options.setup.tolerance = 0;
  commands.back().status = 1;
  const std::string exact = readme_file(subject_of(options), commands, {}).text;
  EXPECT_EQ(exact.find("A difference of up to"), std::string::npos);
  EXPECT_THAT(exact, HasSubstr("**Finding:** `biss safety sequences"));
  for (const std::string& each : {text, exact}) EXPECT_EQ(each.find(" \n"), std::string::npos);
}

// The lines of README.md, joined.
std::string readme_of(const EvidenceOptions& options) {
  const EvidenceSubject subject = subject_of(options);
  std::string text = readme_file(subject, evidence_commands(subject), {}).text;
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

TEST(EvidenceReadme, ConstantDelayAndOneClock_AreNamed) {
  EvidenceOptions options;
  options.format = "fs-36-28";
  using testing::HasSubstr;
  const std::string text = readme_of(options);
  EXPECT_THAT(text, HasSubstr("**A constant delay since power-up**"));
  EXPECT_THAT(text, HasSubstr("**A clock at a wrong rate, with one clock** (`OneClock`"));
  EXPECT_THAT(text, HasSubstr("The time of a transfer is not checked."));
  EvidenceSubject subject = subject_of(options);
  subject.monitored.setup.counter.first = 1;
  subject.monitored.setup.clocks.bit_period = nanoseconds(100);
  const std::string known = readme_file(subject, {}, {}).text;
  EXPECT_EQ(known.find("constant delay"), std::string::npos);
  EXPECT_EQ(known.find("The time of a transfer"), std::string::npos);
}

TEST(EvidenceReadme, BothFiguresAndTheRating_AreThoseOfTheConfiguration) {
  EvidenceOptions options;
  using testing::HasSubstr;
  options.format = "fs-36-28";
  const std::string rated = readme_of(options);
  EXPECT_THAT(rated, HasSubstr("per hour at 32 kHz |"));
  EXPECT_THAT(rated, HasSubstr("counter, comparison | 6.25e-18 | 7.2e-10 |"));
  EXPECT_THAT(rated, HasSubstr("only the CPW's CRC | 4.83e-06 | 557 |"));
  EXPECT_THAT(rated, HasSubstr("**Rated:** `check_safety()` accepts this configuration: at most "
                               "1e-09 undetected errors an hour (`residual_max_e15`)"));
  // The comparison and the rate are those of the bundle.
  options.setup.compare_bits = 9;
  options.rate = kilohertz(1);
  const std::string fewer = readme_of(options);
  EXPECT_THAT(fewer, HasSubstr("per hour at 1 kHz |"));
  EXPECT_EQ(fewer.find("6.25e-18"), std::string::npos);
  EXPECT_THAT(fewer, HasSubstr("**Not rated:** `check_safety()` returns `unrated`: no rating"));
  options.setup.compare_bits = 8;
  EXPECT_THAT(readme_of(options), HasSubstr("returns `weak_comparison`: fewer than 9 bits"));
  options = {};
  options.format = "pos36,nE,nW,crc5+pos28,nE,nW,lc6,crc16";
  EXPECT_THAT(readme_of(options), HasSubstr("returns `checksum`: the CPW's CRC is not 0x43"));
  // Without a shortest gap, the number of frames an hour has no limit.
  options = {};
  options.format = "rsh";
  options.setup.shortest = Picoseconds{};
  EXPECT_THAT(readme_of(options), HasSubstr("returns `residual`: more undetected errors"));
  options.setup.tolerance = 2;
  const std::string wide = readme_of(options);
  EXPECT_THAT(wide, HasSubstr("The two words cannot be analysed together"));
  EXPECT_THAT(wide, HasSubstr("returns `weak_comparison`"));
}

// The ratings count errors of the CPW; the safe position is the position of the SPW.
TEST(EvidenceResidual, SafePositionOfEveryConfiguration_IsWithinItsLimitCountedByEitherWord) {
  for (const SafetyConfiguration& each : safety_configurations) {
    const auto shares = lab::undetected_shares(each.frame_format(), each.setup.comparison);
    ASSERT_TRUE(shares) << each.name;
    const long double frames = 3600e12L / static_cast<long double>(each.setup.frame_gap_min.count);
    const auto limit = static_cast<long double>(each.setup.residual_max_e15) * 1e-15L;
    EXPECT_LE(shares->by_cpw * frames, limit) << each.name;
    EXPECT_LE(shares->by_spw * frames, limit) << each.name;
    EXPECT_NEAR(static_cast<double>(shares->by_spw / shares->by_cpw), 1, 0.14) << each.name;
    EXPECT_EQ(shares->safe_position(), std::max(shares->by_cpw, shares->by_spw));
    EXPECT_GT(shares->control_position, shares->safe_position()) << each.name;
  }
}

TEST(EvidencePages, LinksOutOfTheBundle_ArePlainText) {
  EXPECT_EQ(page_of_bundle("see [status.md](status.md), [the page](safety.md), a[3](x)"),
            "see status.md, [the page](safety.md), a3");
  // Brackets that are no link.
  EXPECT_EQ(page_of_bundle("[a [b](x) a](x) [b](y)"), "a [b a](x) b");
  EXPECT_EQ(page_of_bundle("[a] b](x) [c](y) [[1]](x)"), "[a] b](x) c [[1]](x)");
  EXPECT_EQ(page_of_bundle("[a](safety.md#[b](c) [d](e"), "[a](safety.md#b [d](e");
  const std::string page = page_of_bundle(safety_page);
  EXPECT_EQ(page.find("](safety-experiments.md"), std::string::npos);
  EXPECT_NE(page.find("](safety-matrix.md"), std::string::npos);
}

TEST(TextFile, WhatCannotBeRead_IsNamed) {
  EXPECT_EQ(*read_text_file("/dev/null"), "");
  EXPECT_TRUE(read_text_file("/dev/null").has_value());
  EXPECT_EQ(read_text_file("/").error(), "it is a directory");
  EXPECT_EQ(read_text_file("/none/at/all").error(), "cannot open it: No such file or directory");
  EXPECT_EQ(read_text_file("/dev/zero").error(), "it is larger than 64 MiB");
}

TEST(EvidenceCoverage, Share_HasWilsonsLimits) {
  CoverageRow row{};
  row.injected = 1000;
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

}  // namespace evidence_test
}  // namespace biss::verbs
