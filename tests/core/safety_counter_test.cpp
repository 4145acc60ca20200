// The sign of life: every value after every other, both ranges, learning, and a wrong setup.
#include "biss/safety/field_evaluation.hpp"
#include "tests/core/safety_bench.hpp"
#include "tests/core/test.hpp"

namespace biss::safety_counter_test {

using enum SafetyVerdict;
using test::SafetyBench;

// The expected verdict, computed frame by frame.
SafetyVerdict expected_verdict(unsigned last, unsigned value, unsigned lowest, unsigned near) {
  if (value == last) return counter_repeated;
  if (value < lowest) return value == 0 && last == 63 ? counter_mode : counter_foreign;
  const auto after = [&](unsigned v) { return v == 63 ? lowest : v + 1U; };
  unsigned at = after(last);
  if (at == value) return safe;
  if (lowest == 0 && last == 63 && value == 1) return counter_mode;
  for (unsigned i = 0; i < near; ++i) {
    at = after(at);
    if (at == value) return counter_skipped;
  }
  at = value;
  for (unsigned i = 0; i < near; ++i) {
    at = after(at);
    if (at == last) return counter_backwards;
  }
  return counter_foreign;
}

BISS_TEST(SafetyCounter, EveryValueBehindEveryOther_HasItsVerdict) {
  for (const CounterMode mode : {CounterMode::count_1_63, CounterMode::count_0_63}) {
    const unsigned lowest = mode == CounterMode::count_1_63 ? 1 : 0;
    for (const unsigned near : {0U, 8U, 30U}) {
      const SafetyCounter setup{.mode = mode, .near_frames = static_cast<std::uint8_t>(near)};
      for (unsigned last = lowest; last < 64; ++last) {
        LifeCounter counter(mode);
        counter.accept(static_cast<std::uint8_t>(last), 0, 2);
        for (unsigned value = 0; value < 64; ++value) {
          BISS_EXPECT_EQ(counter.judge(static_cast<std::uint8_t>(value), 0, setup),
                         expected_verdict(last, value, lowest, near))
              << last << " then " << value << ", lowest " << lowest << ", near " << near;
        }
      }
    }
  }
}

// A counter with this range, already detected, and the last value `last`.
LifeCounter counter_at(unsigned last, unsigned lowest) {
  LifeCounter counter(lowest == 1 ? CounterMode::count_1_63 : CounterMode::count_0_63);
  counter.accept(63, 0, 2);
  for (unsigned value = lowest; value <= last; ++value) {
    counter.accept(static_cast<std::uint8_t>(value), 0, 2);
  }
  return counter;
}

BISS_TEST(SafetyCounter, EveryValueBehindMissedFrames_HasItsVerdict) {
  for (const unsigned lowest : {0U, 1U}) {
    const unsigned period = 64U - lowest;
    for (const unsigned near : {0U, 8U}) {
      const SafetyCounter setup{.near_frames = static_cast<std::uint8_t>(near)};
      for (unsigned last = lowest; last < 64; ++last) {
        const LifeCounter counter = counter_at(last, lowest);
        for (unsigned missed = 1; missed <= max_tolerated_faults; ++missed) {
          for (unsigned value = lowest; value < 64; ++value) {
            const unsigned ahead = (value + period - last) % period;
            const SafetyVerdict expected = ahead == 0                    ? counter_repeated
                                           : ahead <= missed             ? counter_backwards
                                           : ahead == missed + 1U        ? safe
                                           : ahead <= missed + 1U + near ? counter_skipped
                                           : ahead >= period - near      ? counter_backwards
                                                                         : counter_foreign;
            BISS_EXPECT_EQ(counter.judge(static_cast<std::uint8_t>(value), missed, setup), expected)
                << last << " then " << value << ", missed " << missed << ", near " << near;
          }
        }
      }
    }
  }
}

// Both evaluations' counters, for every place, every number of missed frames and every value.
BISS_TEST(SafetyCounter, BothEvaluations_AgreeForAllValuesAndMissedFrames) {
  using Line = LineEvaluation<test::RunPlan>;
  for (const CounterMode mode : {CounterMode::count_1_63, CounterMode::count_0_63}) {
    for (const MissedFrames rule : {MissedFrames::counted, MissedFrames::perhaps}) {
      const SafetyCounter setup{.mode = mode, .missed = rule};
      for (unsigned last = mode == CounterMode::count_1_63 ? 1 : 0; last < 64; ++last) {
        LifeCounter field(mode);
        const SafetySetup whole{.counter = setup};
        Line line{whole};
        field.accept(static_cast<std::uint8_t>(last), 0, 2);
        line.accept_counter(static_cast<std::uint8_t>(last), whole);
        for (unsigned missed = 0; missed <= max_tolerated_faults; ++missed) {
          for (unsigned v = 0; v < 64; ++v) {
            const auto value = static_cast<std::uint8_t>(v);
            BISS_EXPECT_EQ(line.counter_follows(value), field.judge(value, missed, setup) == safe)
                << last << " " << missed << " " << v;
          }
          line.miss_counter(rule);
        }
      }
    }
  }
}

BISS_TEST(SafetyCounter, FirstValue_IsAnyButAZeroThatCannotBe) {
  for (unsigned v = 0; v < 64; ++v) {
    const auto value = static_cast<std::uint8_t>(v);
    BISS_EXPECT_EQ(LifeCounter(CounterMode::count_1_63).judge(value, 0, {}),
                   v == 0 ? counter_mode : safe);
    BISS_EXPECT_EQ(LifeCounter(CounterMode::count_0_63).judge(value, 0, {}), safe);
    BISS_EXPECT_EQ(LifeCounter(CounterMode::learned).judge(value, 0, {}), safe);
    using Line = LineEvaluation<test::RunPlan>;
    const auto follows = [&](CounterMode mode) {
      return Line(SafetySetup{.counter = {.mode = mode}}).counter_follows(value);
    };
    BISS_EXPECT_EQ(follows(CounterMode::count_1_63), v != 0);
    BISS_EXPECT(follows(CounterMode::count_0_63));
    BISS_EXPECT(follows(CounterMode::learned));
  }
}

BISS_TEST(SafetyCounter, BothRanges_RunForEverWithTheirSetup) {
  for (const CounterMode mode : {CounterMode::count_1_63, CounterMode::count_0_63}) {
    SafetyBench bench([&](SafetySetup& setup) { setup.counter.mode = mode; });
    bench.lowest = mode == CounterMode::count_1_63 ? 1 : 0;
    bench.until_safe();
    for (unsigned i = 0; i < 1000; ++i) BISS_EXPECT_EQ(bench.good().verdict, safe) << i;
    BISS_EXPECT(bench.monitor.counter_mode() == mode);
  }
}

BISS_TEST(SafetyCounter, WrongRangeInTheSetup_IsNamedAtTheFirstRollOver) {
  for (const std::uint32_t lowest : {0U, 1U}) {
    SafetyBench bench([&](SafetySetup& setup) {
      setup.counter.mode = lowest == 1 ? CounterMode::count_0_63 : CounterMode::count_1_63;
    });
    bench.lowest = lowest;
    bench.until_safe();
    SafetyJudgement judged = bench.good();
    for (unsigned i = 0; i < 64 && judged.verdict == safe; ++i) judged = bench.good();
    BISS_EXPECT_EQ(judged.verdict, counter_mode) << lowest;
    BISS_EXPECT_EQ(bench.counter, lowest);
    BISS_EXPECT_EQ(judged.state, SafetyState::latched);
    // The verdict is the same after each acknowledgement.
    bench.acknowledge();
    judged = {};
    for (unsigned i = 0; i < 70 && judged.verdict != counter_mode; ++i) judged = bench.good();
    BISS_EXPECT_EQ(judged.verdict, counter_mode);
  }
}

BISS_TEST(SafetyCounter, WrongRange_IsNamedBehindAMissedFrameToo) {
  for (const std::uint32_t lowest : {0U, 1U}) {
    SafetyBench bench([&](SafetySetup& setup) {
      setup.counter.mode = lowest == 1 ? CounterMode::count_0_63 : CounterMode::count_1_63;
      setup.budget = {.faults = 1, .window = milliseconds(10)};
      setup.frame_gap_max = SafetyBench::cycle * 3;
    });
    bench.lowest = lowest;
    bench.until_safe();
    while (bench.counter != 62) bench.good();
    bench.next();
    BISS_EXPECT(bench.silence().tolerated);
    BISS_EXPECT_EQ(bench.good().verdict, counter_mode);
  }
}

BISS_TEST(SafetyCounter, ARangeThatWasSeen_MakesTheSameStepALoss) {
  // 0…63 is set up and has been seen; then the frame with 0 is lost on its own.
  SafetyBench bench([](SafetySetup& setup) { setup.counter.mode = CounterMode::count_0_63; });
  bench.lowest = 0;
  bench.until_safe();
  bench.good(64);
  while (bench.counter != 63) bench.good();
  bench.next();
  BISS_EXPECT_EQ(bench.good().verdict, counter_skipped);
  // The learned range is kept until another device may be connected.
  bench.acknowledge();
  bench.until_safe();
  while (bench.counter != 63) bench.good();
  bench.next();
  BISS_EXPECT_EQ(bench.good().verdict, counter_skipped);
  bench.acknowledge();
  bench.monitor.encoder_restarted();
  bench.until_safe();
  while (bench.counter != 63) bench.good();
  bench.next();
  BISS_EXPECT_EQ(bench.good().verdict, counter_mode);
}

BISS_TEST(SafetyCounter, ARollOverWithAMissedFrame_IsNoProofOfTheRange) {
  SafetyBench bench([](SafetySetup& setup) {
    setup.counter = {.mode = CounterMode::count_0_63, .missed = MissedFrames::perhaps};
    setup.budget = {.faults = 1, .window = milliseconds(1)};
    setup.frame_gap_max = SafetyBench::cycle * 3;
  });
  bench.until_safe();
  while (bench.counter != 63) bench.good();
  // The encoder skips 0, which could also be in the missing frame.
  BISS_EXPECT(bench.silence().tolerated);
  BISS_EXPECT_EQ(bench.good().verdict, safe);
  BISS_EXPECT_EQ(bench.counter, 1);
  while (bench.counter != 63) BISS_EXPECT_EQ(bench.good().verdict, safe);
  BISS_EXPECT_EQ(bench.good().verdict, counter_mode);
}

BISS_TEST(SafetyCounter, Learned_ReportsTheRangeAndIsSafeFromTheSecondRollOver) {
  for (const std::uint32_t lowest : {0U, 1U}) {
    for (const std::uint8_t rollovers : {std::uint8_t{1}, std::uint8_t{2}, std::uint8_t{5}}) {
      SafetyBench bench([&](SafetySetup& setup) {
        setup.counter.mode = CounterMode::learned;
        setup.counter.learn_rollovers = rollovers;
      });
      bench.lowest = lowest;
      BISS_EXPECT(!bench.monitor.counter_mode());
      // From 11 to 63, then the further rounds.
      const unsigned frames = 53U + (rollovers - 1U) * (64U - lowest) + 1U;
      BISS_EXPECT_EQ(bench.until_safe(400), frames) << lowest;
      BISS_EXPECT(bench.monitor.counter_mode() ==
                  (lowest == 1 ? CounterMode::count_1_63 : CounterMode::count_0_63));
      for (unsigned i = 0; i < 200; ++i) BISS_EXPECT_EQ(bench.good().verdict, safe) << i;
      // From here on the range is as strict as a configured one.
      while (bench.counter != 63) bench.good();
      bench.counter = lowest == 0 ? 0 : 63;
      auto words = bench.words();
      words.life_counter = lowest == 0 ? 1 : 0;
      BISS_EXPECT(is_fault(bench.send(words).verdict));
    }
  }
}

BISS_TEST(SafetyCounter, Learned_BeginsAnewWhereTheRollOversDiffer) {
  SafetyBench bench([](SafetySetup& setup) { setup.counter.mode = CounterMode::learned; });
  bench.lowest = 0;
  while (bench.counter != 0) bench.good();
  // The next 0 is lost, so the range is undecided.
  while (bench.counter != 63) bench.good();
  bench.next();
  BISS_EXPECT_EQ(bench.good().verdict, starting);
  BISS_EXPECT(!bench.monitor.counter_mode());
  // Two consecutive roll-overs decide it again, with the right range.
  while (bench.counter != 0) bench.good();
  BISS_EXPECT(!bench.monitor.counter_mode());
  bench.good(64);
  BISS_EXPECT(bench.monitor.counter_mode() == CounterMode::count_0_63);
}

BISS_TEST(SafetyCounter, Learned_CountsRollOversInARowWithoutAFault) {
  SafetyBench bench([](SafetySetup& setup) { setup.counter.mode = CounterMode::learned; });
  while (bench.counter != 1) bench.good();
  BISS_EXPECT_EQ(bench.silence().verdict, no_frame);
  bench.good(63);
  BISS_EXPECT_EQ(bench.counter, 1);
  BISS_EXPECT(!bench.monitor.counter_mode());
  bench.good(63);
  BISS_EXPECT(bench.monitor.counter_mode() == CounterMode::count_1_63);
}

BISS_TEST(SafetyCounter, Learned_IsForgottenByBothEvaluationsAtARestart) {
  SafetyBench bench([](SafetySetup& setup) { setup.counter.mode = CounterMode::learned; });
  bench.until_safe();
  BISS_EXPECT(bench.monitor.counter_mode() == CounterMode::count_1_63);
  bench.monitor.encoder_restarted();
  BISS_EXPECT(!bench.monitor.counter_mode());
  bench.lowest = 0;
  bench.until_safe();
  BISS_EXPECT(bench.monitor.counter_mode() == CounterMode::count_0_63);
  for (unsigned i = 0; i < 100; ++i) BISS_EXPECT_EQ(bench.good().verdict, safe) << i;
}

BISS_TEST(SafetyCounter, Learned_NamesFaultsWhileItLearns) {
  SafetyBench bench([](SafetySetup& setup) { setup.counter.mode = CounterMode::learned; });
  bench.good(5);
  BISS_EXPECT_EQ(bench.send(bench.words()).verdict, counter_repeated);
  bench.good(5);
  bench.next();
  BISS_EXPECT_EQ(bench.good().verdict, counter_skipped);
  while (bench.counter != 63) bench.good();
  bench.counter = 1;
  BISS_EXPECT_EQ(bench.good().verdict, counter_skipped);
  BISS_EXPECT_EQ(bench.monitor.state(), SafetyState::starting);
}

}  // namespace biss::safety_counter_test
