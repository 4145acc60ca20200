// The self test of the safety monitor, run on monitors with one defective part.
#include "biss/safety/monitor.hpp"

#include "tests/core/safety_bench.hpp"
#include "tests/core/test.hpp"

namespace biss::safety_self_test_test {

using enum SafetyVerdict;
using Plan = test::RunPlan;

// The result of a finding in both evaluations, of a finding in the second evaluation, of a verdict
// in the monitor, of a verdict at a time, and the bounds of an expected position. Each test changes
// one of them.
struct Sabotage {
  SafetyFinding (*finding)(SafetyFinding, const BitView&) = [](SafetyFinding found,
                                                               const BitView&) { return found; };
  SafetyFinding (*second)(SafetyFinding) = [](SafetyFinding found) { return found; };
  SafetyVerdict (*step)(SafetyVerdict) = [](SafetyVerdict judged) { return judged; };
  SafetyVerdict (*watch)(SafetyVerdict) = [](SafetyVerdict judged) { return judged; };
  SafetyVerdict (*at)(SafetyVerdict, const TwoClocks&) = [](SafetyVerdict judged,
                                                            const TwoClocks&) { return judged; };
  std::uint64_t expected_shift = 0;
};
constinit Sabotage sabotage;

template <class Plan>
struct FirstOf : FieldEvaluation<Plan> {
  using FieldEvaluation<Plan>::FieldEvaluation;
  static SafetyFinding find(const Plan& plan, const BitView& bits) {
    return sabotage.finding(FieldEvaluation<Plan>::find(plan, bits), bits);
  }
};
template <class Plan>
struct SecondOf : LineEvaluation<Plan> {
  using LineEvaluation<Plan>::LineEvaluation;
  static SafetyFinding find(const Plan& plan, const BitView& bits) {
    return sabotage.second(sabotage.finding(LineEvaluation<Plan>::find(plan, bits), bits));
  }
};
using First = FirstOf<Plan>;
using Second = SecondOf<Plan>;
struct Monitor : SafetyMonitor<Plan, FieldEvaluation<Plan>, LineEvaluation<Plan>> {
  using Sound = SafetyMonitor<Plan, FieldEvaluation<Plan>, LineEvaluation<Plan>>;
  using Sound::Sound;
  SafetyJudgement step(const TwoClocks& now, const SafetyFinding& a, const SafetyFinding& b) {
    SafetyJudgement judged = Sound::step(now, a, b);
    judged.verdict = sabotage.at(sabotage.step(judged.verdict), now);
    return judged;
  }
  void expect_position(std::uint64_t low, std::uint64_t high) {
    Sound::expect_position(low + sabotage.expected_shift, high + sabotage.expected_shift);
  }
  SafetyJudgement watch(const TwoClocks& now) {
    SafetyJudgement judged = Sound::watch(now);
    judged.verdict = sabotage.watch(judged.verdict);
    return judged;
  }
};

bool passes(const Sabotage& with, const auto& change) {
  sabotage = {};
  Monitor monitor(test::plan_of("fs-36-28", [&](SafetySetup& setup) {
    change(setup);
    // The tests below know the size of the frames of the self test.
    setup.bounds = {};
  }));
  if (!monitor.self_test(monitor.plan().fingerprint())) return false;
  // The self test begins with a monitor that has no good frame and does not await the first value.
  const SafetyFinding answer{.life_counter = monitor.plan().setup().counter.first, .cause = safe};
  if (answer.life_counter != any_first_value) {
    monitor.step(OneClock{picoseconds(-2)}, answer, answer);
    monitor.step(OneClock{picoseconds(-1)}, SafetyFinding{}, SafetyFinding{});
  }
  sabotage = with;
  return safety_detail::SelfTest<Monitor, First, Second>(monitor).passes();
}
bool passes(const Sabotage& with, bool latch = true) {
  return passes(with, [&](SafetySetup& setup) { setup.latch = latch; });
}

template <SafetyVerdict From, SafetyVerdict To = safe>
SafetyVerdict turned(SafetyVerdict verdict) {
  return verdict == From ? To : verdict;
}
template <SafetyVerdict From, SafetyVerdict To = safe>
SafetyFinding taken(SafetyFinding found, const BitView&) {
  found.cause = turned<From, To>(found.cause);
  return found;
}

BISS_TEST(SafetySelfTest, OfASoundMonitor_Passes) {
  BISS_EXPECT(passes({}));
  BISS_EXPECT(passes({}, false));
}

BISS_TEST(SafetySelfTest, OfEvaluationsThatTakeOneWrongThing_Fails) {
  BISS_EXPECT(!passes({.finding = taken<cpw_crc>}));
  BISS_EXPECT(!passes({.finding = taken<spw_crc>}));
  BISS_EXPECT(!passes({.finding = taken<no_frame>}));
  BISS_EXPECT(!passes({.finding = taken<cpw_error>}));
  BISS_EXPECT(!passes({.finding = taken<spw_error>}));
  BISS_EXPECT(!passes({.finding = taken<comparison>}));
}

BISS_TEST(SafetySelfTest, OfEvaluationsThatReadWrongly_Fails) {
  BISS_EXPECT(!passes({.finding = taken<safe, comparison>}));
  BISS_EXPECT(!passes({.finding = [](SafetyFinding found, const BitView&) {
    found.cpw_position ^= 1U;
    return found;
  }}));
  BISS_EXPECT(!passes({.finding = [](SafetyFinding found, const BitView&) {
    found.life_counter ^= 1U;
    return found;
  }}));
  // Within the tolerance, but refused.
  BISS_EXPECT(!passes({.finding = [](SafetyFinding found, const BitView&) {
    if (found.cause == safe && found.difference_lsb != 0) found.cause = comparison;
    return found;
  }}));
}

BISS_TEST(SafetySelfTest, OfASecondEvaluationThatLosesUpperBits_Fails) {
  BISS_EXPECT(!passes({.second = [](SafetyFinding found) {
    found.cpw_position &= 0xFFFF'FFFFU;
    return found;
  }}));
}

BISS_TEST(SafetySelfTest, OfAComparisonThatLooksOneWayOnly_Fails) {
  BISS_EXPECT(!passes({.finding = [](SafetyFinding found, const BitView&) {
    if (found.cause == comparison && found.difference_lsb > 0) found.cause = safe;
    return found;
  }}));
  BISS_EXPECT(!passes({.finding = [](SafetyFinding found, const BitView&) {
    if (found.cause == comparison && found.difference_lsb < 0) found.cause = safe;
    return found;
  }}));
}

BISS_TEST(SafetySelfTest, OfEvaluationsThatOverlookTheLine_Fails) {
  // No answer, no START, an end too soon.
  BISS_EXPECT(!passes({.finding = [](SafetyFinding found, const BitView& bits) {
    if (bits.size_bits() < 100) found.cause = safe;
    return found;
  }}));
  // STOP, and CDS after START: 1, 0, 1.
  BISS_EXPECT(!passes({.finding = [](SafetyFinding found, const BitView& bits) {
    if (bits.size_bits() == 101 && bits[100]) found.cause = safe;
    return found;
  }}));
  BISS_EXPECT(!passes({.finding = [](SafetyFinding found, const BitView& bits) {
    if (bits.size_bits() == 101 && bits[3]) found.cause = safe;
    return found;
  }}));
}

BISS_TEST(SafetySelfTest, OfAMonitorThatLetsOneThingPass_Fails) {
  BISS_EXPECT(!passes({.step = turned<safe, early>}));
  BISS_EXPECT(!passes({.step = turned<counter_repeated>}));
  BISS_EXPECT(!passes({.step = turned<counter_skipped>}));
  BISS_EXPECT(!passes({.step = turned<counter_backwards>}));
  BISS_EXPECT(!passes({.step = turned<counter_foreign>}));
  BISS_EXPECT(!passes({.step = turned<counter_foreign, disagreement>}));
  BISS_EXPECT(!passes({.step = turned<watchdog>}));
  BISS_EXPECT(!passes({.watch = turned<watchdog>}));
  BISS_EXPECT(!passes({.step = turned<latched>}));
  BISS_EXPECT(!passes({.step = turned<disagreement>}));
  // A monitor that is never safe; without a latch no other check detects it.
  BISS_EXPECT(!passes({.step = turned<safe, starting>}, false));
}

// Each at a single time of the self test, so that only one of its checks can detect it.
BISS_TEST(SafetySelfTest, OfAMonitorThatIsNeverSafeOrDoesNotLatchOnce_Fails) {
  BISS_EXPECT(!passes({.at = [](SafetyVerdict judged, const TwoClocks& now) {
    return now.now == Picoseconds{} && judged == safe ? starting : judged;
  }}));
  BISS_EXPECT(!passes({.at = [](SafetyVerdict judged, const TwoClocks& now) {
    const Picoseconds gap = find_safety_configuration("fs-36-28")->setup.frame_gap_max;
    return now.now == gap + picoseconds(1) && judged == latched ? starting : judged;
  }}));
}

BISS_TEST(SafetySelfTest, OfAMonitorThatGoesOnAfterAFaultOfTheReceiver_Fails) {
  BISS_EXPECT(!passes({.step = turned<failed>}));
}

BISS_TEST(SafetySelfTest, OfAMonitorThatOverlooksAClock_Fails) {
  BISS_EXPECT(!passes({.step = turned<SafetyVerdict::clock>}));
  BISS_EXPECT(!passes({.watch = turned<SafetyVerdict::clock>}));
  // Clocks that differ, in a frame only.
  BISS_EXPECT(!passes({.at = [](SafetyVerdict judged, const TwoClocks& now) {
    return now.now != now.second ? safe : judged;
  }}));
  // A clock that stands still.
  BISS_EXPECT(!passes({.at = [](SafetyVerdict judged, const TwoClocks& now) {
    return now.now == Picoseconds{} && judged == SafetyVerdict::clock ? safe : judged;
  }}));
  const auto timed = [](SafetySetup& setup) { setup.clocks.bit_period = nanoseconds(100); };
  BISS_EXPECT(passes({}, timed));
  const Sabotage transfer{.at = [](SafetyVerdict judged, const TwoClocks& now) {
    return now.transfer.time > nanoseconds(100) ? safe : judged;
  }};
  BISS_EXPECT(!passes(transfer, timed));
}

// The shortest gap that is checked: a picosecond less is a clock that stands still.
BISS_TEST(SafetySelfTest, WithAShortestGapOfAPicosecond_Passes) {
  for (const std::uint8_t still : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{255}}) {
    BISS_EXPECT(passes({}, [&](SafetySetup& setup) {
      setup.frame_gap_min = picoseconds(1);
      setup.clocks.still_requests = still;
    })) << unsigned{still};
  }
}

BISS_TEST(SafetySelfTest, OfAMonitorThatTakesAnyPosition_Fails) {
  BISS_EXPECT(!passes({.step = turned<stimulus>}));
  // Or that is done with it in the next frame.
  const auto once = [](SafetyVerdict judged, const TwoClocks& now) {
    const Picoseconds gap = find_safety_configuration("fs-36-28")->setup.frame_gap_max;
    const bool is_next = now.now == 2 * gap;
    return is_next && (judged == stimulus || judged == latched) ? starting : judged;
  };
  BISS_EXPECT(!passes({.at = once}, true));
  BISS_EXPECT(!passes({.at = once}, false));
  // Or that expects another one.
  BISS_EXPECT(!passes({.expected_shift = 1}));
  BISS_EXPECT(!passes({.expected_shift = 5}));
}

BISS_TEST(SafetySelfTest, OfAMonitorThatTakesAnyFirstValue_Fails) {
  // 20 is the counter's value in the frames of the self test.
  for (const std::uint8_t first : {std::uint8_t{1}, std::uint8_t{20}}) {
    const auto awaits = [&](SafetySetup& setup) { setup.counter.first = first; };
    BISS_EXPECT(passes({}, awaits));
    BISS_EXPECT(!passes({.step = turned<counter_first>}, awaits));
    const Sabotage second{.at = [](SafetyVerdict judged, const TwoClocks& now) {
      return now.now != Picoseconds{} && judged == counter_first ? starting : judged;
    }};
    BISS_EXPECT(!passes(second, awaits));
  }
}

BISS_TEST(SafetySelfTest, OfAMonitorThatTakesFramesAtAnyTime_FailsWithAShortestGapToo) {
  for (const auto step : {turned<early>, turned<watchdog>}) {
    sabotage = {};
    Monitor monitor(
        test::plan_of("fs-36-28", [](SafetySetup& s) { s.frame_gap_min = s.cycle_min; }));
    BISS_EXPECT(monitor.self_test(monitor.plan().fingerprint()));
    sabotage.step = step;
    const bool passed = safety_detail::SelfTest<Monitor, First, Second>(monitor).passes();
    BISS_EXPECT(!passed);
  }
}

BISS_TEST(SafetySelfTest, ThatFailsInOperation_IsFinal) {
  sabotage = {};
  SafetyMonitor<Plan, First, Second> monitor(test::plan_of("fs-36-28"));
  BISS_EXPECT(monitor.self_test(monitor.plan().fingerprint()));
  sabotage.finding = taken<cpw_crc>;
  BISS_EXPECT(!monitor.self_test(monitor.plan().fingerprint()));
  BISS_EXPECT_EQ(monitor.state(), SafetyState::failed);
  BISS_EXPECT_EQ(monitor.latched_cause(), self_test);
  BISS_EXPECT_EQ(monitor.watch(OneClock{}).verdict, failed);
  // Its checks work again, and it still gives no position.
  sabotage = {};
  BISS_EXPECT(!monitor.self_test(monitor.plan().fingerprint()));
  BISS_EXPECT_EQ(monitor.state(), SafetyState::failed);
}

BISS_TEST(SafetySelfTest, AfterAFaultOfTheReceiver_Fails) {
  sabotage = {};
  test::SafetyBench bench;
  bench.until_safe();
  bench.monitor.step(OneClock{bench.now}, SafetyFinding{.cause = safe}, SafetyFinding{});
  BISS_EXPECT_EQ(bench.monitor.state(), SafetyState::failed);
  BISS_EXPECT(!bench.monitor.self_test(bench.plan().fingerprint()));
  BISS_EXPECT_EQ(bench.monitor.latched_cause(), disagreement);
}

BISS_TEST(SafetySelfTest, InOperation_ChangesNothingAndClearsNoFault) {
  sabotage = {};
  test::SafetyBench bench([](SafetySetup& setup) { setup.counter.mode = CounterMode::learned; });
  const auto passes_again = [&] { return bench.monitor.self_test(bench.plan().fingerprint()); };
  bench.until_safe();
  BISS_EXPECT(passes_again());
  BISS_EXPECT_EQ(bench.monitor.state(), SafetyState::safe);
  BISS_EXPECT(bench.monitor.counter_mode().has_value());
  BISS_EXPECT_EQ(bench.good().verdict, safe);
  BISS_EXPECT_EQ(bench.silence().state, SafetyState::latched);
  BISS_EXPECT(passes_again());
  BISS_EXPECT_EQ(bench.monitor.state(), SafetyState::latched);
  BISS_EXPECT_EQ(bench.monitor.latched_cause(), no_frame);
  BISS_EXPECT_EQ(bench.good().verdict, latched);
}

BISS_TEST(SafetySelfTest, InOperation_DoesNotAwaitTheFirstValueAgain) {
  sabotage = {};
  test::SafetyBench bench([](SafetySetup& setup) { setup.counter.first = 1; });
  bench.counter = 63;
  BISS_EXPECT_EQ(bench.good(3).verdict, safe);
  BISS_EXPECT(bench.monitor.self_test(bench.plan().fingerprint()));
  BISS_EXPECT_EQ(bench.good().verdict, safe);
}

BISS_TEST(SafetySelfTest, WithTheFingerprintOfAnotherSetup_Fails) {
  sabotage = {};
  const test::RunPlan other =
      test::plan_of("fs-36-28", [](SafetySetup& setup) { setup.comparison.tolerance_lsb = 0; });
  SafetyMonitor<Plan> monitor(test::plan_of("fs-36-28"));
  BISS_EXPECT(!monitor.self_test(other.fingerprint()));
  BISS_EXPECT_EQ(monitor.state(), SafetyState::untested);
  BISS_EXPECT(monitor.self_test(monitor.plan().fingerprint()));
}

BISS_TEST(SafetySelfTest, WithBoundsThatNoFrameMeets_Fails) {
  sabotage = {};
  SafetyMonitor<Plan> monitor(
      test::plan_of("fs-36-28", [](SafetySetup& setup) { setup.bounds.ack_min_clocks = 401; }));
  BISS_EXPECT(!monitor.self_test(monitor.plan().fingerprint()));
}

BISS_TEST(SafetySelfTest, OfAFrameWithMoreChannels_PassesAndKnowsWhoseCrcIsWhose) {
  sabotage = {};
  const UnratedSafetySetup setup(SafetySetup{.cpw = 2, .spw = 1});
  const auto format = test::format_of("pos9,crc6+pos20,nE,nW,lc6,crc16+pos24,nE,nW,crc6+pad8");
  SafetyMonitor<SafetyPlan<4>> monitor(SafetyPlan<4>(format, setup));
  BISS_EXPECT(monitor.self_test(monitor.plan().fingerprint()));
  // A monitor that ignores the third channel's CRC.
  using Wide = SafetyPlan<4>;
  SafetyMonitor<Wide, FirstOf<Wide>, SecondOf<Wide>> blind(Wide(format, setup));
  BISS_EXPECT(blind.self_test(blind.plan().fingerprint()));
  sabotage.finding = [](SafetyFinding found, const BitView& bits) {
    const std::size_t whole = 1U + 1U + 2U + 15U + 44U + 32U + 8U + 1U;
    const bool other = bits.size_bits() == whole && !bits[whole - 1U];
    if (other && found.cause == no_frame) found.cause = safe;
    return found;
  };
  BISS_EXPECT(!blind.self_test(blind.plan().fingerprint()));
}

}  // namespace biss::safety_self_test_test
