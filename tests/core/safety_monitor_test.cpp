// The safety monitor's states: starting, safe, latched; time; the budget; the self test.
#include "biss/safety/monitor.hpp"

#include "biss/master/spi_read.hpp"
#include "tests/core/safety_bench.hpp"
#include "tests/core/test.hpp"

namespace biss::safety_monitor_test {

using enum SafetyVerdict;
using test::RunPlan;
using test::SafetyBench;

BISS_TEST(SafetyMonitor, BeforeItsSelfTest_GivesNothing) {
  SafetyMonitor<RunPlan> monitor(test::plan_of("fs-36-28"));
  const SafetyFinding good{.life_counter = 1, .cause = safe};
  for (int i = 0; i < 5; ++i) {
    const SafetyJudgement judged = monitor.step(OneClock{SafetyBench::cycle * i}, good, good);
    BISS_EXPECT_EQ(judged.verdict, self_test);
    BISS_EXPECT(!judged.position);
  }
  BISS_EXPECT_EQ(monitor.watch(OneClock{}).verdict, self_test);
  monitor.encoder_restarted();
  BISS_EXPECT(!monitor.acknowledge(self_test));
  BISS_EXPECT_EQ(monitor.state(), SafetyState::untested);
  BISS_EXPECT(monitor.self_test(monitor.plan().fingerprint()));
  BISS_EXPECT_EQ(monitor.state(), SafetyState::starting);
}

BISS_TEST(SafetyMonitor, FromTheThirdGoodFrame_IsSafeAndGivesThePosition) {
  SafetyBench bench;
  BISS_EXPECT(bench.passed);
  BISS_EXPECT_EQ(bench.watch(milliseconds(1000)).verdict, starting);
  BISS_EXPECT(!bench.monitor.deadline());
  for (int i = 0; i < 2; ++i) {
    const SafetyJudgement judged = bench.good();
    BISS_EXPECT_EQ(judged.verdict, starting);
    BISS_EXPECT_EQ(judged.state, SafetyState::starting);
    BISS_EXPECT(!judged.position);
  }
  const SafetyJudgement judged = bench.good();
  BISS_EXPECT_EQ(judged.verdict, safe);
  BISS_EXPECT_EQ(judged.state, SafetyState::safe);
  BISS_ASSERT(judged.position.has_value());
  BISS_EXPECT_EQ(judged.position->value, bench.position >> 8U);
  BISS_EXPECT_EQ(judged.life_counter, bench.counter);
  BISS_EXPECT_EQ(judged.difference_lsb, 0);
  BISS_EXPECT(judged.cpw_nW && judged.spw_nW && !judged.tolerated);
  BISS_EXPECT_EQ(bench.watch(bench.now).verdict, safe);
  BISS_EXPECT(!bench.watch(bench.now).position);
}

BISS_TEST(SafetyMonitor, StartFrames_AreCountedAnewAfterAFault) {
  SafetyBench bench([](SafetySetup& setup) { setup.start_frames = 5; });
  bench.good(4);
  BISS_EXPECT_EQ(bench.send_flipped(3).verdict, cpw_crc);
  BISS_EXPECT_EQ(bench.monitor.state(), SafetyState::starting);
  BISS_EXPECT_EQ(bench.good(4).verdict, starting);
  BISS_EXPECT_EQ(bench.good().verdict, safe);
}

BISS_TEST(SafetyMonitor, Warnings_AreToldAndNoFault) {
  SafetyBench bench;
  bench.until_safe();
  SafetyJudgement judged = bench.send_changed([](auto& words) { words.cpw_nW = false; });
  BISS_EXPECT_EQ(judged.verdict, safe);
  BISS_EXPECT(!judged.cpw_nW && judged.spw_nW && judged.position.has_value());
  judged = bench.send_changed([](auto& words) { words.spw_nW = false; });
  BISS_EXPECT_EQ(judged.verdict, safe);
  BISS_EXPECT(judged.cpw_nW && !judged.spw_nW);
}

BISS_TEST(SafetyMonitor, EveryFault_IsNamedInItsFrameAndHoldsUntilAcknowledged) {
  struct Case {
    SafetyVerdict verdict;
    SafetyJudgement (*commit)(SafetyBench&);
  };
  constexpr Case cases[] = {
      {no_frame, [](SafetyBench& b) { return b.silence(); }},
      {cpw_crc, [](SafetyBench& b) { return b.send_flipped(0); }},
      {cpw_crc, [](SafetyBench& b) { return b.send_flipped(43); }},
      {spw_crc, [](SafetyBench& b) { return b.send_flipped(44); }},
      {spw_crc, [](SafetyBench& b) { return b.send_flipped(95); }},
      {no_frame, [](SafetyBench& b) { return b.send_flipped(96); }},
      {cpw_error,
       [](SafetyBench& b) { return b.send_changed([](auto& words) { words.cpw_nE = false; }); }},
      {spw_error,
       [](SafetyBench& b) { return b.send_changed([](auto& words) { words.spw_nE = false; }); }},
      {comparison,
       [](SafetyBench& b) { return b.send_changed([](auto& words) { words.spw += 2; }); }},
      {counter_repeated, [](SafetyBench& b) { return b.send(b.words()); }},
      {counter_skipped, [](SafetyBench& b) { return b.next(), b.good(); }},
      {counter_backwards, [](SafetyBench& b) { return --b.counter, b.send(b.words()); }},
      {counter_foreign, [](SafetyBench& b) { return b.counter = 44, b.good(); }},
      {watchdog, [](SafetyBench& b) { return b.now += SafetyBench::cycle, b.good(); }},
      {watchdog, [](SafetyBench& b) { return b.now -= 2 * SafetyBench::cycle, b.good(); }},
      {SafetyVerdict::clock, [](SafetyBench& b) { return b.now -= SafetyBench::cycle, b.good(); }},
      {early, [](SafetyBench& b) { return b.now -= SafetyBench::cycle / 2, b.good(); }},
  };
  for (const Case& each : cases) {
    SafetyBench bench;
    bench.until_safe();
    SafetyJudgement judged = each.commit(bench);
    BISS_EXPECT_EQ(judged.verdict, each.verdict);
    BISS_EXPECT_EQ(judged.state, SafetyState::latched) << static_cast<int>(each.verdict);
    BISS_EXPECT(!judged.position && !judged.tolerated);
    BISS_EXPECT_EQ(bench.monitor.latched_cause(), each.verdict);
    BISS_EXPECT(!bench.monitor.deadline());
    for (int i = 0; i < 6; ++i) {
      judged = bench.good();
      BISS_EXPECT_EQ(judged.verdict, latched);
      BISS_EXPECT(!judged.position);
    }
    BISS_EXPECT_EQ(bench.watch(bench.now).verdict, latched);
    bench.acknowledge();
    BISS_EXPECT_EQ(bench.good(2).verdict, starting) << static_cast<int>(each.verdict);
    BISS_EXPECT_EQ(bench.good().verdict, safe);
  }
}

BISS_TEST(SafetyMonitor, WithoutLatch_GoodFramesAloneLeadBack) {
  SafetyBench bench([](SafetySetup& setup) { setup.latch = false; });
  bench.until_safe();
  BISS_EXPECT_EQ(bench.silence().state, SafetyState::starting);
  BISS_EXPECT_EQ(bench.good(2).verdict, starting);
  BISS_EXPECT_EQ(bench.good().verdict, safe);
  bench.acknowledge();
  BISS_EXPECT_EQ(bench.good().verdict, safe);
}

BISS_TEST(SafetyMonitor, Watchdog_BitesBehindItsDeadlineAndNotAtIt) {
  SafetyBench bench;
  bench.until_safe();
  BISS_ASSERT(bench.monitor.deadline().has_value());
  const Picoseconds deadline = *bench.monitor.deadline();
  BISS_EXPECT_EQ((deadline - bench.now).count, nanoseconds(46'875).count);
  BISS_EXPECT_EQ(bench.watch(deadline).verdict, safe);
  SafetyJudgement judged = bench.watch(deadline + picoseconds(1));
  BISS_EXPECT_EQ(judged.verdict, watchdog);
  BISS_EXPECT_EQ(judged.state, SafetyState::latched);
  BISS_EXPECT_EQ(bench.watch(deadline + picoseconds(2)).verdict, latched);
}

BISS_TEST(SafetyMonitor, Watchdog_BitesWhileStartingTooAndDoesNotLatch) {
  SafetyBench bench;
  bench.good(2);
  BISS_EXPECT_EQ(bench.watch(bench.now + milliseconds(1)).verdict, watchdog);
  BISS_EXPECT_EQ(bench.monitor.state(), SafetyState::starting);
  BISS_EXPECT_EQ(bench.watch(bench.now + milliseconds(2)).verdict, starting);
  BISS_EXPECT_EQ(bench.good(2).verdict, starting);
  BISS_EXPECT_EQ(bench.good().verdict, safe);
}

BISS_TEST(SafetyMonitor, FramesSoonerThanAnyCycle_AreEarly) {
  SafetyBench bench([](SafetySetup& setup) { setup.frame_gap_min = SafetyBench::cycle; });
  bench.until_safe();
  BISS_EXPECT_EQ(bench.good().verdict, safe);
  bench.now -= picoseconds(1);
  BISS_EXPECT_EQ(bench.good().verdict, early);
}

BISS_TEST(SafetyMonitor, Budget_ToleratesSoManyFaultsInAnyWindow) {
  SafetyBench bench([](SafetySetup& setup) {
    setup.budget = {.faults = 2, .window = SafetyBench::cycle * 10};
    setup.frame_gap_max = SafetyBench::cycle * 4;
  });
  bench.until_safe();
  for (int round = 0; round < 4; ++round) {
    // Faults at 0 and 4, then after 11, of which the first is out of the window.
    for (const unsigned goods : {3U, 6U}) {
      const SafetyJudgement judged = bench.send_flipped(50);
      BISS_EXPECT_EQ(judged.verdict, spw_crc);
      BISS_EXPECT_EQ(judged.state, SafetyState::safe) << round << " " << goods;
      BISS_EXPECT(judged.tolerated && !judged.position);
      const SafetyJudgement after = bench.good(goods);
      BISS_EXPECT_EQ(after.verdict, safe);
      BISS_EXPECT_EQ(after.position->value, bench.position >> 8U);
    }
  }
  BISS_EXPECT(bench.send_flipped(50).tolerated);
  bench.good();
  // Seven cycles after the second last one.
  const SafetyJudgement judged = bench.send_flipped(50);
  BISS_EXPECT_EQ(judged.verdict, spw_crc);
  BISS_EXPECT(!judged.tolerated);
  BISS_EXPECT_EQ(judged.state, SafetyState::latched);
}

BISS_TEST(SafetyMonitor, Budget_WindowEndsJustWhenItIsOver) {
  const auto tolerated_after = [](unsigned goods) {
    SafetyBench bench([](SafetySetup& setup) {
      setup.budget = {.faults = 1, .window = SafetyBench::cycle * 5};
      setup.frame_gap_max = SafetyBench::cycle * 2;
    });
    bench.until_safe();
    bench.send_flipped(0);
    bench.good(goods);
    return bench.send_flipped(0).tolerated;
  };
  BISS_EXPECT(!tolerated_after(4));
  BISS_EXPECT(tolerated_after(5));
}

// A copy made before a fault would undo it, and the count of tolerated faults.
static_assert(!std::is_copy_constructible_v<SafetyMonitor<RunPlan>>);
static_assert(!std::is_move_constructible_v<SafetyMonitor<RunPlan>>);
static_assert(!std::is_copy_assignable_v<SafetyMonitor<RunPlan>>);
static_assert(!std::is_move_assignable_v<SafetyMonitor<RunPlan>>);

BISS_TEST(SafetyMonitor, FiveRestarts_TolerateNoMoreFaultsThanTheBudget) {
  SafetyBench bench([](SafetySetup& setup) {
    setup.budget = {.faults = 1, .window = milliseconds(1000)};
    setup.frame_gap_max = SafetyBench::cycle * 2;
    setup.latch = false;
  });
  unsigned tolerated = 0;
  for (int i = 0; i < 5; ++i) {
    bench.until_safe();
    tolerated += bench.send_flipped(50).tolerated ? 1U : 0U;
    bench.monitor.encoder_restarted();
  }
  BISS_EXPECT_EQ(tolerated, 1);
}

BISS_TEST(SafetyMonitor, Budget_HasNoRoomForTimeOrSetup) {
  SafetyBench bench([](SafetySetup& setup) {
    setup.budget = {.faults = 1, .window = milliseconds(10)};
    setup.counter.mode = CounterMode::count_0_63;
  });
  bench.until_safe();
  BISS_EXPECT(bench.send_flipped(1).tolerated);
  bench.good();
  BISS_EXPECT_EQ(bench.watch(bench.now + milliseconds(1)).state, SafetyState::latched);
  // The counter skips 0: the setup is wrong.
  bench.acknowledge();
  bench.counter = 50;
  bench.until_safe();
  SafetyJudgement judged;
  while (bench.counter != 1) judged = bench.good();
  BISS_EXPECT_EQ(judged.verdict, counter_mode);
  BISS_EXPECT_EQ(judged.state, SafetyState::latched);
}

BISS_TEST(SafetyMonitor, ToleratedLosses_AreExpectedInTheCounterByTheRule) {
  for (const MissedFrames rule : {MissedFrames::counted, MissedFrames::perhaps}) {
    for (const std::uint32_t counted : {0U, 1U, 2U, 3U}) {
      SafetyBench bench([&](SafetySetup& setup) {
        setup.budget = {.faults = 3, .window = milliseconds(10)};
        setup.frame_gap_max = SafetyBench::cycle * 4;
        setup.counter.missed = rule;
      });
      bench.until_safe();
      // Across a roll-over that is not the first one.
      bench.good(64);
      while (bench.counter != 62) bench.good();
      bench.silence();
      bench.silence();
      for (std::uint32_t i = 0; i < counted; ++i) bench.next();
      const SafetyJudgement judged = bench.good();
      const bool right = counted == 2 || (counted < 2 && rule == MissedFrames::perhaps);
      BISS_EXPECT_EQ(judged.verdict == safe, right) << counted;
      BISS_EXPECT_EQ(judged.position.has_value(), right) << counted;
      if (right) {
        BISS_EXPECT_EQ(bench.good().verdict, safe);
      } else {
        BISS_EXPECT_EQ(judged.verdict, counted == 3 ? counter_skipped : counter_backwards);
      }
    }
  }
}

BISS_TEST(SafetyMonitor, Restart_ForgetsWhereItWas) {
  SafetyBench bench;
  bench.until_safe();
  bench.silence();
  bench.monitor.encoder_restarted();
  BISS_EXPECT_EQ(bench.good().verdict, latched);
  BISS_EXPECT(bench.acknowledge());
  bench.good(2);
  bench.monitor.encoder_restarted();
  bench.now += milliseconds(100);
  bench.counter = 33;
  BISS_EXPECT_EQ(bench.good(2).verdict, starting);
  BISS_EXPECT_EQ(bench.good().verdict, safe);
}

BISS_TEST(SafetyMonitor, ReadersResult_IsJudgedAsTheBitsAre) {
  SafetyBench bench;
  bench.until_safe();
  const auto bits = test::bits_of(bench.plan(), bench.next());
  bench.now += SafetyBench::cycle;
  const auto frame = decode_frame(bits.view(), bench.plan().codec());
  const SafetyJudgement judged = bench.monitor.step(OneClock{bench.now}, bits.view(), frame);
  BISS_EXPECT_EQ(judged.verdict, safe);
  BISS_EXPECT_EQ(judged.position->value, bench.position >> 8U);
  // A reader with another frame than the line.
  const auto other = test::bits_of(bench.plan(), bench.next());
  bench.now += SafetyBench::cycle;
  BISS_EXPECT_EQ(bench.monitor.step(OneClock{bench.now}, other.view(), frame).verdict,
                 disagreement);
  BISS_EXPECT_EQ(bench.monitor.latched_cause(), disagreement);
  BISS_EXPECT_EQ(bench.monitor.step(OneClock{bench.now}, other.view(), frame).verdict, failed);
}

// Readers have bounds of their own: their faults, and frames that only their bounds accept, are
// faults of the line.
BISS_TEST(SafetyMonitor, ReaderWithOtherBounds_IsNoReceiverFault) {
  const auto judge = [](const FrameBounds& of_reader, const FrameBounds& of_monitor,
                        std::size_t flipped) {
    SafetyBench bench([&](SafetySetup& setup) { setup.bounds = of_monitor; });
    bench.until_safe();
    auto bits = test::bits_of(bench.plan(), bench.next());
    if (flipped != 0) bits.flip(flipped);
    bench.now += SafetyBench::cycle;
    const auto frame = decode_frame(bits.view(), bench.plan().codec(), of_reader);
    return bench.monitor.step(OneClock{bench.now}, bits.view(), frame).verdict;
  };
  const FrameBounds wide{};
  const FrameBounds long_ack{.ack_min_clocks = test::ack_clocks + 1};
  const FrameBounds short_ack{.ack_max_clocks = test::ack_clocks};
  constexpr std::size_t in_cpw = 2U + test::ack_clocks + 2U + 5U;
  BISS_EXPECT_EQ(judge(wide, short_ack, 0), safe);
  BISS_EXPECT_EQ(judge(long_ack, wide, 0), no_frame);
  BISS_EXPECT_EQ(judge(long_ack, wide, in_cpw), no_frame);
  BISS_EXPECT_EQ(judge(wide, short_ack, in_cpw), cpw_crc);
  // START one clock late: ACK is too long for the monitor.
  constexpr std::size_t at_start = 2U + test::ack_clocks;
  BISS_EXPECT_EQ(judge(wide, short_ack, at_start), no_frame);
}

// A reader accepts zeros of the cycle before, and refuses a 1 behind STOP; the monitor's bounds may
// say otherwise.
BISS_TEST(SafetyMonitor, SpiReadersResult_IsNoReceiverFault) {
  const SpiSetup spi{.period = nanoseconds(100)};
  const auto judge = [&](std::uint16_t late_max_clocks, std::size_t flipped) {
    SafetyBench bench([&](SafetySetup& setup) { setup.bounds.late_max_clocks = late_max_clocks; });
    bench.until_safe();
    const auto sent = test::bits_of(bench.plan(), bench.next());
    std::array<std::uint8_t, 32> bytes{};
    for (std::size_t i = 0; i < sent.view().size_bits(); ++i) {
      if (sent.view()[i]) bytes[i / 8] = static_cast<std::uint8_t>(bytes[i / 8] | 0x80U >> i % 8);
    }
    bytes[flipped / 8] = static_cast<std::uint8_t>(bytes[flipped / 8] ^ 0x80U >> flipped % 8);
    const SpiReader reader(bench.plan().codec(), spi, renishaw_timing);
    bench.now += SafetyBench::cycle;
    return bench.monitor.step(OneClock{bench.now}, BitView(bytes), reader.read(bytes)).verdict;
  };
  BISS_EXPECT_EQ(judge(1, 0), safe);
  BISS_EXPECT_EQ(judge(0, 0), no_frame);
  BISS_EXPECT_EQ(judge(1, 8 * 32 - 1), no_frame);
}

BISS_TEST(SafetyMonitor, Disagreement_OfAnyPartLatchesAtOnce) {
  const SafetyFinding good{.cpw_position = 5, .life_counter = 1, .cause = safe};
  const auto verdict_of = [&](const auto& change, bool latch) {
    SafetyMonitor<RunPlan> monitor(
        test::plan_of("fs-36-28", [&](SafetySetup& setup) { setup.latch = latch; }));
    if (!monitor.self_test(monitor.plan().fingerprint())) return self_test;
    SafetyFinding other = good;
    change(other);
    const SafetyJudgement judged = monitor.step(OneClock{}, good, other);
    BISS_EXPECT_EQ(judged.state, SafetyState::failed);
    return judged.verdict;
  };
  for (const bool latch : {true, false}) {
    BISS_EXPECT_EQ(verdict_of([](auto& f) { f.cpw_position ^= 1U; }, latch), disagreement);
    BISS_EXPECT_EQ(verdict_of([](auto& f) { f.spw_position ^= 1U; }, latch), disagreement);
    BISS_EXPECT_EQ(verdict_of([](auto& f) { f.difference_lsb = 1; }, latch), disagreement);
    BISS_EXPECT_EQ(verdict_of([](auto& f) { f.life_counter ^= 1U; }, latch), disagreement);
    BISS_EXPECT_EQ(verdict_of([](auto& f) { f.nW ^= 2U; }, latch), disagreement);
    BISS_EXPECT_EQ(verdict_of([](auto& f) { f.nW ^= 1U; }, latch), disagreement);
    BISS_EXPECT_EQ(verdict_of([](auto& f) { f.cause = spw_crc; }, latch), disagreement);
  }
}

// A CRC engine that is wrong for one value of the data.
struct Broken : CrcFast {
  constexpr Broken() = default;
  constexpr explicit Broken(const CrcSpec& spec) : CrcFast(spec) {}
  constexpr std::uint16_t operator()(std::uint64_t data, unsigned bits) const {
    return static_cast<std::uint16_t>(CrcFast::operator()(data, bits) ^ (data == 3 ? 1U : 0U));
  }
};

// A second evaluation that lets any counter pass, or finds nothing wrong.
template <class Plan>
struct Trusting : LineEvaluation<Plan> {
  using LineEvaluation<Plan>::LineEvaluation;
  constexpr bool counter_follows(std::uint8_t) const { return true; }
};
template <class Plan>
struct Blind : LineEvaluation<Plan> {
  using LineEvaluation<Plan>::LineEvaluation;
  static constexpr SafetyFinding find(const Plan& plan, const BitView& bits) {
    SafetyFinding finding = LineEvaluation<Plan>::find(plan, bits);
    if (finding.cause == spw_error) finding.cause = safe;
    return finding;
  }
};

// A second evaluation that has learned another range, or calculates another safe position.
template <class Plan>
struct Unlearned : LineEvaluation<Plan> {
  using LineEvaluation<Plan>::LineEvaluation;
  static constexpr std::optional<CounterMode> counter_mode() { return CounterMode::count_0_63; }
};
template <class Plan>
struct Elsewhere : LineEvaluation<Plan> {
  using LineEvaluation<Plan>::LineEvaluation;
  static constexpr SafePosition safe_position(const Plan& plan, const SafetyFinding& finding) {
    SafePosition position = LineEvaluation<Plan>::safe_position(plan, finding);
    ++position.high;
    return position;
  }
};

BISS_TEST(SafetyMonitor, SelfTest_FindsBrokenParts) {
  using Sound = SafetyPlan<2>;
  const SafetyConfiguration& type = *find_safety_configuration("fs-36-28");
  const Sound sound(type.frame_format(), type.setup);
  SafetyMonitor<SafetyPlan<2, Broken>> crc(SafetyPlan<2, Broken>(type.frame_format(), type.setup));
  BISS_EXPECT(!crc.self_test(crc.plan().fingerprint()));
  SafetyMonitor<Sound, FieldEvaluation<Sound>, Trusting<Sound>> trusting(sound);
  BISS_EXPECT(!trusting.self_test(sound.fingerprint()));
  SafetyMonitor<Sound, FieldEvaluation<Sound>, Blind<Sound>> blind(sound);
  BISS_EXPECT(!blind.self_test(sound.fingerprint()));
  SafetyMonitor<Sound, FieldEvaluation<Sound>, Unlearned<Sound>> unlearned(sound);
  BISS_EXPECT(!unlearned.self_test(sound.fingerprint()));
  SafetyMonitor<Sound, FieldEvaluation<Sound>, Elsewhere<Sound>> elsewhere(sound);
  BISS_EXPECT(!elsewhere.self_test(sound.fingerprint()));
  const SafetyFinding good{.life_counter = 1, .cause = safe};
  BISS_EXPECT_EQ(blind.step(OneClock{}, good, good).verdict, self_test);
  BISS_EXPECT_EQ(blind.state(), SafetyState::untested);
}

BISS_TEST(SafetyMonitor, SelfTest_PassesWithEveryConfigurationAndSetup) {
  for (const SafetyConfiguration& each : safety_configurations) {
    for (const unsigned variant : {0U, 1U, 2U, 3U}) {
      SafetySetup setup = each.setup;
      setup.counter.mode = static_cast<CounterMode>(variant % 3U);
      setup.latch = variant != 1;
      if (variant == 1) setup.start_frames = 255, setup.counter.learn_rollovers = 1;
      if (variant == 2) setup.budget = {.faults = 4, .window = setup.frame_gap_max};
      if (variant == 3) setup.bounds = {.lead_min_clocks = 2, .ack_min_clocks = 32};
      SafetyMonitor<RunPlan> monitor(RunPlan(each.frame_format(), UnratedSafetySetup(setup)));
      BISS_EXPECT(monitor.self_test(monitor.plan().fingerprint())) << variant;
    }
  }
}

// A plan known at compile time, and all steps in a constant expression.
constexpr bool works_while_compiling() {
  constexpr const SafetyConfiguration& type = *find_safety_configuration("rsm");
  SafetyMonitor<FixedSafetyPlan<type.frame_format(), type.setup, CrcBitwise>> monitor;
  const SafetyFinding good{.life_counter = 1, .cause = safe};
  return monitor.step(OneClock{}, good, good).verdict == self_test && sizeof(monitor) <= 256;
}
static_assert(works_while_compiling());

}  // namespace biss::safety_monitor_test
