#include "lab/sequence.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "biss/frame/format_text.hpp"
#include "biss/safety/configurations.hpp"
#include "lab/sequence_block.hpp"

namespace biss::lab {
namespace {

using enum CounterMode;

constexpr std::uint64_t seed = 20'261'121;
// Weak checksums, so that much is accepted, and theory is quick.
constexpr std::string_view weak_text = "pos12,nE,nW,crc5+pos10,nE,nW,lc6,crc6";

SequencePlan plan_of(const SafetyConfiguration& type) {
  return {.format = type.frame_format(), .setup = type.setup, .seed = seed};
}
SequencePlan plan_of(const char* name) { return plan_of(*find_safety_configuration(name)); }
SequencePlan weak_plan() { return {.format = *parse_format(weak_text), .setup = {}, .seed = seed}; }

std::vector<SequenceResult> results_of(const SequencePlan& plan) {
  return run_sequences(plan, 2).value();
}

void expect_passed(const std::vector<SequenceResult>& results) {
  for (const SequenceResult& each : results) {
    EXPECT_TRUE(each.passed()) << each.row.name() << " " << each.row.variant_name() << " alarms "
                               << each.counts.false_alarms << " late " << each.counts.late
                               << " unexpected " << each.counts.unexpected << " accepted "
                               << each.counts.accepted << " sigma " << each.sigma.value_or(0);
  }
}

TEST(Sequence, UndamagedFrames_AreNeverAnAlarm) {
  for (const SafetyConfiguration& type : safety_configurations) {
    SequencePlan plan = plan_of(type);
    for (const auto motion : {SequenceMotion::max, SequenceMotion::steps, SequenceMotion::creep}) {
      for (const CounterMode encoder : {count_1_63, count_0_63}) {
        plan.add_undamaged(motion, {encoder, encoder}, 1000);
        plan.add_undamaged(motion, {learned, encoder}, 1000);
      }
    }
    const auto results = results_of(plan);
    expect_passed(results);
    for (const SequenceResult& each : results) EXPECT_EQ(each.counts.frames, 1000U) << type.name;
  }
}

// Rounded words from the second block on, and a clock that wraps around in the fourth.
TEST(Sequence, FourBlocks_AreNeverAnAlarm) {
  SequencePlan plan = plan_of("rsm");
  plan.add_undamaged(SequenceMotion::max, {learned, count_0_63}, 4 * 65'536);
  const auto results = results_of(plan);
  expect_passed(results);
  EXPECT_GT(results[0].counts.position_wraps, 200U);
  EXPECT_GT(results[0].counts.counter_wraps, 4090U);
}

// Shows that an alarm would be counted.
TEST(Sequence, WrongCounterTakenForUndamaged_IsAnAlarmARound) {
  SequencePlan plan = plan_of("fs-36-28");
  plan.add_undamaged(SequenceMotion::max, {count_0_63, count_1_63}, 6300);
  const auto results = results_of(plan);
  EXPECT_GE(results[0].counts.false_alarms, 99U);
  EXPECT_LE(results[0].counts.false_alarms, 101U);
  EXPECT_EQ(results[0].counts.odd.size(), odd_kept);
  EXPECT_FALSE(results[0].passed());
}

TEST(Sequence, CounterOfTheOtherRange_IsNamedAndNeverALoss) {
  SequencePlan plan = plan_of("fs-36-28");
  plan.add_counter_mode({count_0_63, count_1_63}, 500);
  plan.add_counter_mode({count_1_63, count_0_63}, 500);
  const auto results = results_of(plan);
  expect_passed(results);
  for (const SequenceResult& each : results) {
    EXPECT_EQ(each.counts.told(SafetyVerdict::counter_mode), 500U);
    EXPECT_EQ(each.counts.recognised(), 500U);
  }
}

TEST(Sequence, EveryKindOfFault_IsToldInTimeAndAcceptedAsTheorySays) {
  for (const CounterMode counter : {count_1_63, count_0_63}) {
    SequencePlan plan = weak_plan();
    for (const SafetyMeasure& measure : safety_measures) {
      plan.add_fault(measure.error, {counter, counter}, 3000);
    }
    const auto results = results_of(plan);
    expect_passed(results);
    EXPECT_EQ(results.size(), plan.rows.size() + transmission_error_count);
    for (const SequenceResult& each : results) {
      ASSERT_TRUE(each.theory) << each.row.variant_name();
      EXPECT_EQ(each.counts.accepted + each.counts.recognised(), each.counts.events);
      // Something has to be accepted where so much has to be.
      const long double expected = *each.theory * static_cast<long double>(each.counts.events);
      EXPECT_TRUE(expected < 30 || each.counts.accepted > 0) << each.row.variant_name();
    }
  }
}

TEST(Sequence, SumOfAKind_IsThatOfItsVariants) {
  SequencePlan plan = weak_plan();
  plan.add_fault(TransmissionError::addressing, {count_1_63, count_1_63}, 1000);
  const auto results = results_of(plan);
  ASSERT_EQ(results.size(), 4U);
  EXPECT_EQ(results[3].row.variant_name(), "all");
  EXPECT_EQ(results[3].counts.events, 1000U);
  EXPECT_EQ(results[3].counts.accepted, results[0].counts.accepted + results[1].counts.accepted);
  EXPECT_NEAR(static_cast<double>(*results[3].theory), 667 / 63.0 / 1000, 1e-12);
}

// The counter sees what a longer watchdog does not: as a loss if few are, by another name if many.
TEST(Sequence, LossWithinALongWatchdog_IsSeenByTheCounter) {
  SequencePlan plan = plan_of("fs-36-28");
  plan.setup.frame_gap_max = plan.setup.cycle_min * 40;
  plan.add_fault(TransmissionError::loss, {count_1_63, count_1_63}, 1000);
  const auto results = results_of(plan);
  expect_passed(results);
  const SequenceCounts& unheard = results[2].counts;
  EXPECT_EQ(results[2].row.variant_name(), "unheard");
  EXPECT_GT(unheard.told(SafetyVerdict::counter_skipped), 0U);
  EXPECT_GT(unheard.told(SafetyVerdict::counter_foreign), 0U);
  EXPECT_GT(unheard.told(SafetyVerdict::watchdog), 0U);
  EXPECT_LE(unheard.worst_cycles, 40U);
  EXPECT_EQ(results[3].counts.told(SafetyVerdict::watchdog), results[3].counts.events);
}

TEST(Sequence, LearnedCounter_StandsAgainstFaultsAlike) {
  SequencePlan plan = plan_of("rxm");
  plan.add_fault(TransmissionError::repetition, {learned, count_0_63}, 300);
  plan.add_fault(TransmissionError::sequence, {learned, count_1_63}, 300);
  expect_passed(results_of(plan));
}

TEST(Sequence, InsertedFrame_IsAlwaysEarlyWhereTheSetupLooks) {
  for (const std::int64_t gap_ns : {15'000, 16'000}) {
    SequencePlan plan = plan_of("rxm");
    plan.setup.frame_gap_min = nanoseconds(gap_ns);
    plan.add_fault(TransmissionError::insertion, {count_1_63, count_1_63}, 2000);
    const auto results = results_of(plan);
    expect_passed(results);
    EXPECT_EQ(results[1].row.variant_name(), "foreign");
    EXPECT_EQ(results[1].counts.accepted == 0, gap_ns == 16'000);
    EXPECT_EQ(results[1].counts.told(SafetyVerdict::early) == 1000, gap_ns == 16'000);
  }
}

TEST(Sequence, AnyNumberOfThreads_GivesTheSame) {
  SequencePlan plan = weak_plan();
  plan.add_undamaged(SequenceMotion::steps, {count_0_63, count_0_63}, 70'000);
  plan.add_fault(TransmissionError::insertion, {count_1_63, count_1_63}, 2500);
  std::uint64_t last = 0;
  const auto one = run_sequences(plan, 1, [&last](const SequenceProgress& now) {
    EXPECT_EQ(now.done, ++last);
    EXPECT_EQ(now.all, 2U + 2U * 2U);
  });
  const auto three = run_sequences(plan, 3);
  ASSERT_EQ(one->size(), three->size());
  for (std::size_t row = 0; row < one->size(); ++row) {
    EXPECT_EQ((*one)[row].counts, (*three)[row].counts);
    EXPECT_EQ((*one)[row].sigma, (*three)[row].sigma);
  }
}

TEST(Sequence, OddEvent_IsTheSameAgain) {
  SequencePlan plan = weak_plan();
  plan.add_fault(TransmissionError::addressing, {count_1_63, count_1_63}, 6000);
  const SequenceRow& row = plan.rows[0];
  const auto results = results_of(plan);
  ASSERT_FALSE(results[0].counts.odd.empty());
  const std::uint64_t index = results[0].counts.odd.back();
  const auto frame = SequenceFrame::make(plan.format, plan.setup, row.counter, row.encoder_counter);
  bool accepted = false;
  count_sequence(*frame, row, plan.seed, row.blocks().block_of(index),
                 [&](const SequenceStep& step) {
                   if (step.index == index && step.what == "fault")
                     accepted = step.told.position.has_value();
                 });
  EXPECT_TRUE(accepted);
}

TEST(Sequence, WholePlan_HasBothCountersBothMistakesAndEightKinds) {
  const SafetyConfiguration& type = *find_safety_configuration("fs-28-24");
  const SequencePlan plan = whole_plan(type.frame_format(), type.setup, 100, 80);
  std::uint64_t undamaged = 0;
  std::uint64_t mistakes = 0;
  std::uint64_t faults = 0;
  for (const SequenceRow& row : plan.rows) {
    if (row.task == SequenceTask::undamaged) undamaged += row.size;
    if (row.task == SequenceTask::counter_mode) mistakes += row.size;
    if (row.task == SequenceTask::fault) faults += row.size;
  }
  EXPECT_EQ(undamaged, 400U);
  EXPECT_EQ(mistakes, 160U);
  EXPECT_EQ(faults, 640U);
}

TEST(Sequence, FormatThatIsNoPair_GivesNone) {
  SequencePlan plan{.format = *parse_format("pos26,nE,nW,crc6"), .setup = {}};
  plan.add_undamaged(SequenceMotion::max, {count_1_63, count_1_63}, 1);
  EXPECT_FALSE(run_sequences(plan));
}

// A delay may last 128 cycles: at one frame a second that is more than 64 bits of picoseconds times
// 2^20.
TEST(Sequence, DelayAtOneFrameASecond_IsDetectedInTime) {
  SequencePlan plan = plan_of("fs-36-28");
  plan.setup.cycle_min = milliseconds(1000);
  plan.setup = at_cycle(plan.setup, plan.setup.cycle_min);
  plan.add_fault(TransmissionError::delay, {count_1_63, count_1_63}, 600);
  const auto results = results_of(plan);
  expect_passed(results);
  for (const SequenceResult& each : results) {
    EXPECT_EQ(each.counts.accepted, 0U) << each.row.variant_name();
    EXPECT_LE(each.counts.worst_cycles, 1U) << each.row.variant_name();
  }
}

TEST(SequenceResult, AnythingOutOfBounds_HasNotPassed) {
  SequenceResult good;
  good.theory = 0;
  EXPECT_TRUE(good.passed());
  const auto failed = [&good](auto change) {
    SequenceResult result = good;
    change(result);
    return !result.passed();
  };
  EXPECT_TRUE(failed([](SequenceResult& result) { result.counts.false_alarms = 1; }));
  EXPECT_TRUE(failed([](SequenceResult& result) { result.counts.misread = 1; }));
  EXPECT_TRUE(failed([](SequenceResult& result) { result.counts.late = 1; }));
  EXPECT_TRUE(failed([](SequenceResult& result) { result.counts.unexpected = 1; }));
  EXPECT_TRUE(failed([](SequenceResult& result) { result.counts.accepted = 1; }));
  for (const double sigma : {5.1, -5.1}) {
    EXPECT_TRUE(failed([sigma](SequenceResult& result) {
      result.theory = 0.1L;
      result.sigma = sigma;
    }));
  }
  good.theory = 0.1L;
  good.sigma = 4.9;
  good.counts.accepted = 7;
  EXPECT_TRUE(good.passed());
}

TEST(SequenceCounts, OddIndices_AreTheLowestInOrder) {
  SequenceCounts counts;
  SequenceCounts more;
  for (std::uint64_t n = 40; n != 0; --n) (n % 2 == 0 ? counts : more).add_odd(n);
  more.worst_cycles = 3;
  counts.add(more);
  counts.add_odd(7);
  std::vector<std::uint64_t> lowest(odd_kept);
  std::iota(lowest.begin(), lowest.end(), 1U);
  EXPECT_EQ(counts.odd, lowest);
  EXPECT_EQ(counts.worst_cycles, 3U);
}

}  // namespace
}  // namespace biss::lab
