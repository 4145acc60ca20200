#include "lab/sequence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <set>

#include "biss/frame/format_text.hpp"
#include "biss/safety/configurations.hpp"
#include "lab/campaign_theory.hpp"
#include "lab/sequence_block.hpp"
#include "lab/sequence_theory.hpp"

namespace biss::lab {
namespace sequence_test {

using enum CounterMode;

constexpr std::uint64_t seed = 20'261'121;
// Weak checksums, so that many events are accepted and the theory is quick to compute.
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

// Shows that a false alarm would be counted.
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
    EXPECT_EQ(each.counts.verdicts[index_of(SafetyVerdict::counter_mode)], 500U);
    EXPECT_EQ(each.counts.detected(), 500U);
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
      EXPECT_EQ(each.counts.accepted + each.counts.detected(), each.counts.events);
      // With 30 or more expected acceptances, at least one event must be accepted.
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

// The counter detects what a longer watchdog does not: as a loss if few frames are lost, with
// another verdict if many are.
TEST(Sequence, LossWithinALongWatchdog_IsSeenByTheCounter) {
  SequencePlan plan = plan_of("fs-36-28");
  plan.setup.frame_gap_max = plan.setup.cycle_min * 40;
  plan.add_fault(TransmissionError::loss, {count_1_63, count_1_63}, 1000);
  const auto results = results_of(plan);
  expect_passed(results);
  const SequenceCounts& not_called = results[2].counts;
  EXPECT_EQ(results[2].row.variant_name(), "not_called");
  EXPECT_GT(not_called.verdicts[index_of(SafetyVerdict::counter_skipped)], 0U);
  EXPECT_GT(not_called.verdicts[index_of(SafetyVerdict::counter_foreign)], 0U);
  EXPECT_GT(not_called.verdicts[index_of(SafetyVerdict::watchdog)], 0U);
  EXPECT_LE(not_called.worst_cycles, 40U);
  EXPECT_EQ(results[3].counts.verdicts[index_of(SafetyVerdict::watchdog)],
            results[3].counts.events);
}

// With a budget, across restarts of the encoder: see count_constant().
TEST(Sequence, ConstantDelaySincePowerUp_IsNeverSafeAfterAStimulus) {
  for (const CounterMode counter : {count_1_63, count_0_63, learned}) {
    for (const bool latch : {true, false}) {
      SequencePlan plan = plan_of("fs-36-28");
      plan.setup.latch = latch;
      plan.add_fault(TransmissionError::delay,
                     {counter, counter == count_0_63 ? count_0_63 : count_1_63}, 4000);
      std::erase_if(plan.rows, [](const SequenceRow& row) { return !row.is_constant(); });
      ASSERT_EQ(plan.rows.size(), 1U);
      expect_passed(results_of(plan));
      // Without a stimulus nothing shows the delay, and some of the faults are tolerated.
      const SequenceRow& row = plan.rows[0];
      const auto frame =
          SequenceFrame::make(plan.format, plan.setup_of(row), row.counter, row.encoder_counter);
      unsigned safe = 0;
      unsigned tolerated = 0;
      count_sequence(*frame, row, plan.seed, 0, [&](const SequenceStep& step) {
        if (step.judgement.position) ++safe;
        if (step.judgement.tolerated) ++tolerated;
      });
      EXPECT_GT(safe, 1000U);
      EXPECT_GT(tolerated, 100U);
    }
  }
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
    EXPECT_EQ(results[1].counts.verdicts[index_of(SafetyVerdict::early)] == 1000, gap_ns == 16'000);
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
                     accepted = step.judgement.position.has_value();
                 });
  EXPECT_TRUE(accepted);
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

SequenceFrame frame_of(const SafetyConfiguration& type,
                       CounterMode counter = CounterMode::count_1_63) {
  return SequenceFrame::make(type.frame_format(), type.setup, counter, counter).value();
}
SequenceFrame frame_of_type(const char* name) { return frame_of(*find_safety_configuration(name)); }

// CPW less SPW as the monitor sees it.
std::int32_t difference_of(const SequenceFrame& frame, const SequenceWords& words) {
  sim::Random random(seed);
  const FrameBits bits = frame.encode(words, random);
  const SafetyFinding found = FieldEvaluation<SequenceFrame::Plan>::find(frame.plan(), bits.view());
  EXPECT_EQ(found.life_counter, words.life_counter);
  EXPECT_EQ(found.cpw_position, words.cpw);
  return found.difference_lsb;
}

TEST(SequenceEncoder, TruncatedWords_AreTheSamePlace) {
  for (const SafetyConfiguration& type : safety_configurations) {
    const SequenceFrame frame = frame_of(type);
    SequenceEncoder encoder(frame, CounterMode::count_1_63, SequenceMotion::steps,
                            WordRule::truncated, seed);
    for (int n = 0; n < 1000; ++n) ASSERT_EQ(difference_of(frame, encoder.next()), 0) << type.name;
  }
}

TEST(SequenceEncoder, RoundedWords_AreOffByUpToTheTolerance) {
  for (const SafetyConfiguration& type : safety_configurations) {
    const SequenceFrame frame = frame_of(type);
    SequenceEncoder encoder(frame, CounterMode::count_1_63, SequenceMotion::creep,
                            WordRule::rounded, seed);
    std::set<std::int32_t> seen;
    for (int n = 0; n < 2000; ++n) seen.insert(difference_of(frame, encoder.next()));
    EXPECT_EQ(seen, (std::set<std::int32_t>{-1, 0, 1})) << type.name;
  }
}

TEST(SequenceEncoder, FullSpeed_IsJustLessThanHalfATurnBothWays) {
  for (const char* name : {"fs-36-28", "rsm"}) {
    const SequenceFrame frame = frame_of_type(name);
    const ChannelFormat& cpw = frame.words().cpw_format();
    const unsigned turn = cpw.position.present() ? cpw.position.bits : cpw.singleturn.bits;
    SequenceEncoder encoder(frame, CounterMode::count_1_63, SequenceMotion::max,
                            WordRule::truncated, seed);
    std::uint64_t before = encoder.next().cpw;
    unsigned forwards = 0;
    unsigned backwards = 0;
    for (int n = 1; n < 512; ++n) {
      const std::uint64_t now = encoder.next().cpw;
      const std::uint64_t ahead = (now - before) & low_mask(cpw.position_bits());
      const std::uint64_t back = (before - now) & low_mask(cpw.position_bits());
      const std::uint64_t step = std::min(ahead, back);
      EXPECT_LT(step, std::uint64_t{1} << (turn - 1U));
      EXPECT_GT(step, std::uint64_t{7} << (turn - 4U));
      ++(ahead < back ? forwards : backwards);
      before = now;
    }
    EXPECT_EQ(std::min(forwards, backwards), 255U) << name;
    EXPECT_EQ(std::max(forwards, backwards), 256U) << name;
  }
}

TEST(SequenceEncoder, EverySpeed_FromACountToHalfTheRange) {
  const SequenceFrame frame = frame_of_type("fs-28-24");
  SequenceEncoder encoder(frame, CounterMode::count_1_63, SequenceMotion::steps,
                          WordRule::truncated, seed);
  std::set<std::size_t> magnitudes;
  for (int n = 0; n < 1000 * 512; ++n) {
    const std::uint64_t before = encoder.next().cpw;
    if (n % 512 != 0) continue;
    const std::uint64_t ahead = (encoder.next().cpw - before) & low_mask(28);
    magnitudes.insert(std::bit_width(std::min(ahead, (std::uint64_t{1} << 28U) - ahead)));
    ++n;
  }
  for (std::size_t magnitude = 1; magnitude <= 27; ++magnitude) {
    EXPECT_TRUE(magnitudes.count(magnitude)) << magnitude;
  }
}

// A carry of k bits changes k + 1 bits.
TEST(SequenceEncoder, Creep_HasCarriesOfEveryLength) {
  const SequenceFrame frame = frame_of_type("fs-36-28");
  SequenceEncoder encoder(frame, CounterMode::count_1_63, SequenceMotion::creep,
                          WordRule::truncated, seed);
  std::set<std::size_t> carries;
  std::uint64_t before = encoder.next().cpw;
  for (int n = 1; n < 512 * 500; ++n) {
    const std::uint64_t now = encoder.next().cpw;
    if (n % 512 != 0) carries.insert(static_cast<std::size_t>(std::bit_width(before ^ now)));
    before = now;
  }
  EXPECT_EQ(carries.size(), 37U);
}

TEST(SequenceEncoder, EveryMotion_WrapsPositionAndCounter) {
  for (const SafetyConfiguration& type : safety_configurations) {
    const SequenceFrame frame = frame_of(type, CounterMode::count_0_63);
    for (const auto motion : {SequenceMotion::max, SequenceMotion::steps, SequenceMotion::creep}) {
      SequenceEncoder encoder(frame, CounterMode::count_0_63, motion, WordRule::rounded, seed);
      for (int n = 0; n < 6400; ++n) encoder.next();
      EXPECT_GE(encoder.position_wraps(), 3U) << type.name;
      EXPECT_GE(encoder.counter_wraps(), 99U);
      EXPECT_LE(encoder.counter_wraps(), 100U);
    }
  }
}

TEST(SequenceFrame, OtherStarts_AreNeverOurChecksums) {
  const SequenceFrame frame = frame_of_type("fs-36-28");
  sim::Random random(seed);
  for (const SequenceFrame::Codec& other : frame.other_starts()) {
    for (int n = 0; n < 1000; ++n) {
      const std::uint64_t cpw = random.next() & low_mask(38);
      const std::uint64_t spw = random.next() & low_mask(36);
      EXPECT_TRUE(other.crc(0, cpw, false) != frame.codec().crc(0, cpw, false) ||
                  other.crc(1, spw, false) != frame.codec().crc(1, spw, false));
    }
  }
}

TEST(SequenceFrame, WordsThatCannotBeMonitored_AreRefused) {
  const auto counter = CounterMode::count_1_63;
  for (const char* text : {"pos26,nE,nW,crc6", "pos26,nE,nW,crc6+pos26,nE,nW,crc16"}) {
    EXPECT_FALSE(SequenceFrame::make(*parse_format(text), {}, counter, counter)) << text;
  }
}

constexpr std::string_view small_text = "pos6,nE,nW,crc3+pos5,nE,nW,lc6,crc4";

SequenceFrame frame_with(std::string_view text, SafetySetup setup = {}) {
  const CounterMode counter = setup.counter.mode;
  setup.comparison.compare_bits = text == small_text ? 4 : 0;
  return SequenceFrame::make(*parse_format(text), setup, counter, counter).value();
}

SequenceRow row_of(TransmissionError kind, std::string_view variant,
                   CounterMode counter = CounterMode::count_1_63) {
  SequenceRow row{
      .task = SequenceTask::fault, .kind = kind, .counter = counter, .encoder_counter = counter};
  while (row.variant_name() != variant) ++row.variant;
  return row;
}

// The monitor's verdict of a frame after good frames that end with this one.
SafetyVerdict next_of(const SequenceFrame& frame, const SequenceWords& sent,
                      const FrameBits& bits) {
  return frame.words()
      .monitor({sent.cpw, sent.life_counter},
               {bits.view().word(frame.payload_at(bits), frame.words().cpw_bits()),
                bits.view().word(frame.payload_at(bits) + frame.words().cpw_bits(),
                                 frame.words().spw_bits()),
                false})
      .verdict;
}

TEST(SequenceTheory, NoiseInTheSafetyWord_IsWhatAllWordsOfASmallFrameGive) {
  const SequenceFrame frame = frame_with(small_text);
  const unsigned spw_bits = frame.words().spw_bits();
  sim::Random random(1);
  const SequenceWords sent{.cpw = 41, .spw = 20, .life_counter = 63};
  const FrameBits right = frame.encode(sent, random);
  std::uint64_t accepted = 0;
  for (std::uint64_t wrong = 1; wrong < std::uint64_t{1} << spw_bits; ++wrong) {
    FrameBits bits = right;
    for (unsigned bit = 0; bit < spw_bits; ++bit) {
      if (((wrong >> bit) & 1U) != 0) bits.flip(bits.size_bits() - 2U - bit);
    }
    if (next_of(frame, sent, bits) == SafetyVerdict::safe) ++accepted;
  }
  ASSERT_GT(accepted, 0U);
  const auto theory = sequence_theory(frame, row_of(TransmissionError::masquerade, "noise_word"));
  EXPECT_DOUBLE_EQ(static_cast<double>(*theory) * static_cast<double>(1U << spw_bits),
                   static_cast<double>(accepted));
}

TEST(SequenceTheory, AnotherPolynomial_IsWhatAllPositionsAndCountersGive) {
  for (const CounterMode counter : {CounterMode::count_1_63, CounterMode::count_0_63}) {
    const SequenceFrame frame = frame_with(small_text, {.counter = {.mode = counter}});
    sim::Random random(1);
    std::uint64_t accepted = 0;
    std::uint64_t all = 0;
    for (const SequenceFrame::Codec& other : frame.other_polynomials()) {
      for (std::uint64_t position = 0; position < 64; ++position) {
        for (unsigned value = frame.words().first_counter(); value < 64; ++value) {
          const SequenceWords sent{.cpw = position,
                                   .spw = position >> 1U,
                                   .life_counter = static_cast<std::uint8_t>(value)};
          const FrameBits bits = frame.encode(sent, other, random);
          if (next_of(frame, sent, bits) == SafetyVerdict::safe) ++accepted;
          ++all;
        }
      }
    }
    ASSERT_GT(accepted, 0U);
    const auto theory =
        sequence_theory(frame, row_of(TransmissionError::masquerade, "polynomial", counter));
    EXPECT_DOUBLE_EQ(static_cast<double>(*theory),
                     static_cast<double>(accepted) / static_cast<double>(all));
  }
}

TEST(SequenceTheory, NoiseInBothWords_IsTheCampaignsHalfOfAllBits) {
  for (const std::string_view text :
       {small_text, std::string_view("pos12,nE,nW,crc5+pos10,nE,nW,lc6,crc6")}) {
    const SequenceFrame frame = frame_with(text);
    const auto campaign = campaign_theory(frame.words(), *parse_fault("flips:0.5"));
    ASSERT_TRUE(campaign);
    const auto theory = sequence_theory(frame, row_of(TransmissionError::masquerade, "noise"));
    EXPECT_NEAR(static_cast<double>(*theory / (*campaign)[3]), 1, 1e-9);
  }
}

TEST(SequenceTheory, WhatTheCounterSees_IsNeverAccepted) {
  const SequenceFrame frame = frame_with("pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16");
  for (const auto& [kind, variant] : {std::pair{TransmissionError::repetition, "older"},
                                      std::pair{TransmissionError::insertion, "stale"},
                                      std::pair{TransmissionError::sequence, "shuffled"},
                                      std::pair{TransmissionError::loss, "skipped"},
                                      std::pair{TransmissionError::delay, "watched"},
                                      std::pair{TransmissionError::masquerade, "standard"},
                                      std::pair{TransmissionError::addressing, "start_value"}}) {
    EXPECT_EQ(sequence_theory(frame, row_of(kind, variant)), 0.0L) << variant;
  }
}

TEST(SequenceTheory, AnotherSource_FitsOnceInAPeriod) {
  const SequenceFrame frame = frame_with(small_text, {.frame_gap_min = {}});
  for (const auto& [kind, variant] : {std::pair{TransmissionError::repetition, "any_age"},
                                      std::pair{TransmissionError::insertion, "foreign"},
                                      std::pair{TransmissionError::addressing, "one_frame"}}) {
    EXPECT_EQ(sequence_theory(frame, row_of(kind, variant)), 1.0L / 63);
    EXPECT_EQ(sequence_theory(frame, row_of(kind, variant, CounterMode::count_0_63)), 1.0L / 64);
  }
  // A frame between two requests is too early for any encoder whose cycle is known.
  const SequenceRow inserted = row_of(TransmissionError::insertion, "foreign");
  EXPECT_EQ(sequence_theory(frame_with(small_text), inserted), 0.0L);
}

// A word of zeros is a good one there.
TEST(SequenceTheory, ZerosThatMayBeAWord_HaveNone) {
  const SequenceFrame frame = frame_with("pos12,E,crc6:plain+pos12,E,lc6,crc16:plain");
  EXPECT_FALSE(sequence_theory(frame, row_of(TransmissionError::masquerade, "standard")));
}

}  // namespace sequence_test
}  // namespace biss::lab
