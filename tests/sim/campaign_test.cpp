// The line with every kind of fault, read by the decoder.
#include "tests/sim/campaign.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/format_text.hpp"
#include "tests/exhaustive/scale.hpp"
#include "tests/sim/fault_table.hpp"

namespace biss::campaign::campaign_test {

const Tally& alone(const Outcome& outcome, sim::FaultKind kind) {
  return outcome.alone[static_cast<std::size_t>(kind)];
}

// The checksum of 6 bits finds every single error. Of bursts longer than it one in 2^6 passes, of
// those longer by one bit one in 2^5: with lengths of 2 to 16 alike that is one in 85. A frame that
// slips by a clock is as good as random: one in 64. Chance is given four deviations.
void expect_wrong_positions_as_explained(const Outcome& outcome) {
  const Tally& flips = alone(outcome, sim::FaultKind::flip);
  EXPECT_EQ(flips.statuses[static_cast<std::size_t>(CycleStatus::crc)], flips.cycles);
  EXPECT_GT(alone(outcome, sim::FaultKind::burst).wrong, 0U);
  for (std::size_t k = 0; k < sim::line_fault_kind_count; ++k) {
    const Tally& tally = outcome.alone[k];
    const double expected = static_cast<double>(tally.cycles) / 64;
    const auto passed = static_cast<double>(tally.wrong + tally.wrong_error);
    EXPECT_LE(passed, expected + 4 * std::sqrt(expected)) << sim::fault_list[k].name;
  }
}

void expect_document_has(const std::string& table, const char* path = "docs/faults.md") {
  std::ifstream file(std::string(BISS_SOURCE_FOLDER "/") + path);
  std::stringstream document;
  document << file.rdbuf();
  EXPECT_NE(document.str().find(table), std::string::npos) << "print it with biss_fault_table";
}

TEST(FaultsDocument, Lists_AreThoseOfTheCode) {
  expect_document_has(fault_list(0, sim::line_fault_kind_count));
  expect_document_has(fault_list(sim::line_fault_kind_count, sim::simulated_fault_count));
  expect_document_has(fault_list(sim::simulated_fault_count, sim::line_only_fault_first));
  expect_document_has(fault_list(sim::line_only_fault_first, sim::fault_kind_count));
  expect_document_has(place_table());
}

// One test, because all its checks use the same run.
TEST(Damage, AMillionCyclesWithEveryKind_UndamagedAreOkAndWrongPositionsAsRareAsTheChecksumSays) {
  const std::uint64_t cycles = exhaustive::slow_build ? documented_cycles / 10 : documented_cycles;
  const Outcome outcome = run(documented_line(), cycles);
  EXPECT_GT(outcome.undamaged.cycles, cycles / 3);
  EXPECT_EQ(outcome.undamaged.right(), outcome.undamaged.cycles) << outcome.complaints;
  EXPECT_EQ(outcome.master_failed + outcome.master_wrong, 0U);
  for (std::size_t k = 0; k < sim::line_fault_kind_count; ++k) {
    EXPECT_GE(100 * outcome.injected[k], cycles) << sim::fault_list[k].name;
  }
  expect_wrong_positions_as_explained(outcome);
  // An error that the encoder itself reports is not a fault of the line.
  for (const auto kind : {sim::FaultKind::nE, sim::FaultKind::nW, sim::FaultKind::frozen}) {
    EXPECT_EQ(alone(outcome, kind).right(), alone(outcome, kind).cycles);
  }
  if (!exhaustive::slow_build) expect_document_has(fault_table(outcome), "lab/reports/faults.md");
}

// A checksum of 16 bits lets one damaged frame in 65536 pass; all else that is good was sent.
TEST(Damage, GoodRowsWithALongChecksum_HaveTheTruePosition) {
  for (const char* name : {"pos36,crc16", "pos24,nE,nW,crc16", "mt12,st20,nE,nW,lc6,crc16"}) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      sim::LineSetup setup = documented_line();
      setup.format = *parse_format(name);
      if (seed % 2 == 0) setup.timing.timeout = {TimeoutRule::adaptive, nanoseconds(200)};
      setup.compensate = seed > 2;
      setup.ma_jitter = setup.slo_jitter = nanoseconds(5);
      setup.faults = all_faults(std::uint64_t{1} << 28U);
      setup.seed = seed;
      const Outcome outcome = run(setup, exhaustive::rounds(20'000));
      Tally all = outcome.several;
      all.wrong += outcome.behind.wrong + outcome.undamaged.wrong;
      for (const Tally& tally : outcome.alone) {
        all.wrong += tally.wrong;
        all.wrong_error += tally.wrong_error;
      }
      EXPECT_LE(all.wrong + all.wrong_error, 1U) << name << ", seed " << seed;
    }
  }
}

// Encoders with each rule of the timeout, with several channels, at fast and slow clocks, with
// jitter.
TEST(Damage, OtherEncodersAndClocks_UndamagedCyclesAreOk) {
  for (const char* name : {"resolute-18", "fs-36-28", "ic-mhm", "lenz-b3", "faulhaber-aemt"}) {
    for (const Hertz clock : {kilohertz(250), megahertz(1)}) {
      const CatalogueEntry* entry = find_encoder(name);
      ASSERT_NE(entry, nullptr) << name;
      sim::LineSetup setup = documented_line();
      setup.format = entry->frame_format();
      setup.timing = entry->timing;
      setup.internal_delay = entry->timing.internal_delay_max;
      setup.clock = clock;
      setup.ma_jitter = setup.slo_jitter = nanoseconds(10);
      const Outcome outcome = run(setup, exhaustive::rounds(10'000));
      EXPECT_EQ(outcome.undamaged.right(), outcome.undamaged.cycles)
          << name << ": " << outcome.complaints;
    }
  }
}

// Encoders that are ready 1.5 periods after the last clock. Between two requests MA is idle no
// longer than in a request with a few missing edges, so a damaged cycle does not end by itself.
template <class Check>
void for_each_tight_line(Check check) {
  std::size_t lines = 0;
  for (const CatalogueEntry& entry : catalogue) {
    if (!entry.name.starts_with("ic-mr")) continue;
    sim::LineSetup setup = documented_line();
    setup.format = entry.frame_format();
    setup.timing = entry.timing;
    setup.internal_delay = entry.timing.internal_delay_max;
    setup.clock = megahertz(4);
    setup.seed = 1;
    check(setup, entry.name);
    ++lines;
  }
  EXPECT_EQ(lines, 12U);
}

TEST(Damage, TightRequestsBehindLongSpoiledCycles_AreCyclesOfTheirOwn) {
  for_each_tight_line([](const sim::LineSetup& setup, std::string_view name) {
    const Outcome outcome = run(setup, exhaustive::rounds(20'000));
    EXPECT_EQ(outcome.undamaged.right(), outcome.undamaged.cycles)
        << name << ": " << outcome.complaints;
  });
}

TEST(Damage, ProbesExchangedForSomeCycles_StepIsFoundAgain) {
  for_each_tight_line([](sim::LineSetup setup, std::string_view name) {
    setup.faults.clear();
    for (const std::uint64_t length : {1U, 2U, 5U, 80U}) {
      const std::uint64_t every = length + 20;
      const Outcome outcome = run(setup, exhaustive::rounds(100 * every), {every, length});
      EXPECT_EQ(outcome.undamaged.right(), outcome.undamaged.cycles)
          << name << ", " << length << " cycles: " << outcome.complaints;
    }
  });
}

}  // namespace biss::campaign::campaign_test
