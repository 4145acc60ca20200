// The safety monitor and time: a clock that wraps around, stops or jumps; the budget of faults
// across start-ups and across ages.
#include <iterator>

#include "biss/base/wrapping_time.hpp"
#include "biss/safety/monitor.hpp"
#include "tests/core/monitor_bytes.hpp"
#include "tests/core/safety_bench.hpp"
#include "tests/core/test.hpp"

namespace biss::safety_time_test {

using enum SafetyVerdict;
using test::SafetyBench;

constexpr Picoseconds end_of_time{std::numeric_limits<std::int64_t>::max()};
constexpr Picoseconds begin_of_time{std::numeric_limits<std::int64_t>::min()};

// A bench with this time at its first frame.
struct BenchAt : SafetyBench {
  explicit BenchAt(Picoseconds first) { now = wrapping_later(first, -cycle); }
};

BISS_TEST(SafetyTime, ClockThatWrapsAround_IsNoFault) {
  for (std::int64_t cycles = 0; cycles < 7; ++cycles) {
    BenchAt bench(end_of_time - SafetyBench::cycle * cycles);
    for (int i = 0; i < 8; ++i) {
      BISS_EXPECT_EQ(bench.good().verdict, i < 2 ? starting : safe) << cycles << " " << i;
      BISS_EXPECT_EQ(bench.watch(bench.now).verdict, i < 2 ? starting : safe);
    }
    BISS_EXPECT(bench.now < Picoseconds{});
  }
}

BISS_TEST(SafetyTime, DeadlineBehindTheClocksEnd_IsAtItsBegin) {
  BenchAt bench(end_of_time - SafetyBench::cycle * 2);
  bench.good(3);
  BISS_EXPECT_EQ(bench.now.count, end_of_time.count);
  const Picoseconds deadline = *bench.monitor.deadline();
  BISS_EXPECT_EQ((deadline - begin_of_time).count,
                 (bench.plan().setup().frame_gap_max - picoseconds(1)).count);
  BISS_EXPECT_EQ(bench.watch(deadline).verdict, safe);
  BISS_EXPECT_EQ(bench.watch(deadline + picoseconds(1)).verdict, watchdog);
}

BISS_TEST(SafetyTime, ClockThatGoesBackwards_IsTheWatchdogsInAFrameAndInATick) {
  for (const Picoseconds back : {picoseconds(1), SafetyBench::cycle, end_of_time}) {
    SafetyBench bench;
    bench.until_safe();
    const Picoseconds last = bench.now;
    bench.now = wrapping_later(wrapping_later(last, -SafetyBench::cycle), -back);
    BISS_EXPECT_EQ(bench.good().verdict, watchdog);
    SafetyBench watched;
    watched.until_safe();
    const SafetyJudgement judged = watched.watch(wrapping_later(watched.now, -back));
    BISS_EXPECT_EQ(judged.verdict, watchdog);
    BISS_EXPECT_EQ(judged.state, SafetyState::latched);
  }
}

BISS_TEST(SafetyTime, ATickBeforeTheFirstFrame_IsNoFaultWhateverTheClockShows) {
  SafetyBench bench;
  for (const Picoseconds now : {begin_of_time, picoseconds(-1), Picoseconds{}, end_of_time}) {
    BISS_EXPECT_EQ(bench.watch(now).verdict, starting);
  }
}

BISS_TEST(SafetyTime, AnyJumpOfTheClock_IsAFault) {
  for (std::int64_t jump = SafetyBench::cycle.count; jump > 0 && jump < end_of_time.count / 2;
       jump *= 2) {
    SafetyBench bench;
    bench.until_safe();
    bench.now += picoseconds(jump);
    BISS_EXPECT_EQ(bench.good().verdict, watchdog);
  }
}

BISS_TEST(SafetyTime, WatchThatBites_LeavesNothingToTheFrameBehindIt) {
  SafetyBench bench([](SafetySetup& setup) { setup.latch = false; });
  bench.until_safe();
  const Picoseconds late = *bench.monitor.deadline() + picoseconds(1);
  BISS_EXPECT_EQ(bench.watch(late).state, SafetyState::starting);
  BISS_EXPECT_EQ(bench.good(2).verdict, starting);
  BISS_EXPECT_EQ(bench.good().verdict, safe);
}

// One fault per window is tolerated. Good frames follow for a second start-up, then a second fault.
BISS_TEST(SafetyTime, Budget_IsOfAWindowWhateverStartUpsItHolds) {
  const auto one_fault = [](SafetySetup& setup) {
    setup.budget = {.faults = 1, .window = SafetyBench::cycle * 20};
    setup.frame_gap_max = SafetyBench::cycle * 2;
  };
  for (const bool latch : {true, false}) {
    for (const unsigned goods : {3U, 18U, 19U}) {
      SafetyBench bench([&](SafetySetup& setup) {
        one_fault(setup);
        setup.latch = latch;
      });
      bench.until_safe();
      BISS_EXPECT(bench.send_flipped(50).tolerated);
      BISS_EXPECT(!bench.send_flipped(50).tolerated);
      bench.acknowledge();
      BISS_EXPECT_EQ(bench.good(goods).state, SafetyState::safe);
      BISS_EXPECT_EQ(bench.send_flipped(50).tolerated, goods == 19) << goods;
    }
  }
  // A restart of the encoder, or several of them, is not a new budget.
  for (const unsigned goods : {3U, 18U, 19U}) {
    SafetyBench bench(one_fault);
    bench.until_safe();
    BISS_EXPECT(bench.send_flipped(50).tolerated);
    bench.good();
    for (int i = 0; i < 3; ++i) bench.monitor.encoder_restarted();
    BISS_EXPECT_EQ(bench.good(goods).state, SafetyState::safe);
    BISS_EXPECT_EQ(bench.send_flipped(50).tolerated, goods == 19) << goods;
  }
}

BISS_TEST(SafetyTime, Budget_IsNotSpentByFaultsOfTheClocksLastRound) {
  for (const std::uint8_t faults : {std::uint8_t{1}, std::uint8_t{2}, std::uint8_t{3}}) {
    SafetyBench bench([&](SafetySetup& setup) {
      setup.budget = {.faults = faults, .window = SafetyBench::cycle * 20};
      setup.frame_gap_max = SafetyBench::cycle * 2;
      setup.latch = false;
    });
    bench.until_safe();
    for (unsigned i = 0; i < faults; ++i) {
      BISS_EXPECT(bench.send_flipped(50).tolerated);
      bench.good();
    }
    bench.good(20);
    // As if these good frames had lasted for half a round of the clock.
    bench.now = wrapping_later(bench.now, end_of_time - SafetyBench::cycle * 2);
    BISS_EXPECT_EQ(bench.good().verdict, watchdog);
    bench.until_safe();
    for (unsigned i = 0; i < faults; ++i) {
      BISS_EXPECT(bench.send_flipped(50).tolerated) << unsigned{faults} << " " << i;
      bench.good();
    }
    BISS_EXPECT(!bench.send_flipped(50).tolerated);
  }
}

// The budget's contract: no window contains more faults than the budget. Checked on a list of all
// tolerated faults.
BISS_TEST(SafetyTime, Budget_HoldsInEverySpanOfRandomFaults) {
  BISS_RANDOM(random, 0x5AFE'0010);
  for (const std::uint8_t faults :
       {std::uint8_t{1}, std::uint8_t{2}, std::uint8_t{3}, std::uint8_t{4}}) {
    constexpr std::int64_t window = 30;
    SafetyBench bench([&](SafetySetup& setup) {
      setup.budget = {.faults = faults, .window = SafetyBench::cycle * window};
      setup.frame_gap_max = SafetyBench::cycle * 6;
      setup.latch = false;
    });
    std::array<std::int64_t, 5> last{};
    last.fill(-1000);
    const auto cycles = static_cast<std::int64_t>(test::rounds(5'000, 500));
    for (std::int64_t at = 0; at < cycles; ++at) {
      const bool was_safe = bench.monitor.state() == SafetyState::safe;
      const bool spoil = random.below(16) == 0;
      const SafetyJudgement judged = spoil ? bench.send_flipped(50) : bench.good();
      if (!spoil) continue;
      const bool room = at - last[faults - 1U] > window;
      BISS_ASSERT_EQ(judged.tolerated, was_safe && room) << unsigned{faults};
      if (!judged.tolerated) continue;
      for (std::size_t i = last.size() - 1U; i != 0; --i) last[i] = last[i - 1U];
      last[0] = at;
    }
  }
}

BISS_TEST(SafetyTime, SetupsOfAnyTimes_AreJudgedWithoutARunOver) {
  const FrameFormat format = find_safety_configuration("fs-36-28")->frame_format();
  constexpr std::array times{begin_of_time,
                             picoseconds(-1),
                             Picoseconds{},
                             picoseconds(1),
                             SafetyBench::cycle,
                             max_frame_gap,
                             max_frame_gap + picoseconds(1),
                             end_of_time};
  for (const Picoseconds cycle : times) {
    for (const Picoseconds most : times) {
      for (const Picoseconds least : times) {
        const SafetySetup setup{.cycle_min = cycle,
                                .frame_gap_max = most,
                                .frame_gap_min = least,
                                .clocks = {.tolerance = {}}};
        const bool order = least.count >= 0 && least < most && most <= max_frame_gap &&
                           cycle.count > 0 && cycle <= max_frame_gap;
        const std::int64_t fastest = std::min(cycle, SafetyBench::cycle).count;
        const bool period = most.count / 63 < std::max(least.count, fastest - fastest / 32);
        const auto mistake = check_safety(format, UnratedSafetySetup(setup));
        BISS_EXPECT_EQ(!mistake, order && period) << cycle.count << " " << most.count;
        if (mistake) continue;
        SafetySetup slow = setup;
        slow.counter.mode = CounterMode::learned;
        slow.counter.learn_rollovers = 255;
        slow.start_frames = 255;
        SafetyMonitor<test::RunPlan> monitor(test::RunPlan(format, UnratedSafetySetup(slow)));
        BISS_EXPECT(monitor.self_test(monitor.plan().fingerprint()))
            << cycle.count << " " << most.count;
      }
    }
  }
}

// ---- Two clocks

constexpr Picoseconds tolerance = SafetyClocks{}.tolerance;

// The next good frame, at these times.
SafetyJudgement good_at(SafetyBench& bench, const TwoClocks& time) {
  bench.now = time.now;
  const FrameBits bits = test::bits_of(bench.plan(), bench.next());
  return bench.monitor.step(time, bits.view());
}
// A bench that is safe with a second clock that runs ahead.
constexpr Picoseconds ahead = milliseconds(3);
void make_safe(SafetyBench& bench) {
  for (int i = 0; i < 4; ++i) {
    const Picoseconds now = bench.now + SafetyBench::cycle;
    good_at(bench, {now, now + ahead});
  }
}

BISS_TEST(SafetyClock, StoppedOrJumpingClock_IsAFaultWhicheverOfTheTwoItIs) {
  for (const Picoseconds error :
       {tolerance + picoseconds(1), -tolerance - picoseconds(1), SafetyBench::cycle * 5}) {
    for (const bool first : {true, false}) {
      SafetyBench bench;
      make_safe(bench);
      BISS_ASSERT(bench.monitor.state() == SafetyState::safe);
      TwoClocks time{bench.now + SafetyBench::cycle, bench.now + SafetyBench::cycle + ahead};
      (first ? time.now : time.second) += error;
      BISS_EXPECT_EQ(test::MonitorBytes(bench.monitor).monitor().watch(time).verdict,
                     SafetyVerdict::clock);
      const SafetyJudgement judged = good_at(bench, time);
      BISS_EXPECT_EQ(judged.verdict, SafetyVerdict::clock);
      BISS_EXPECT(!judged.position && judged.state == SafetyState::latched);
    }
  }
}

BISS_TEST(SafetyClock, ClocksThatDifferByTheTolerance_AreSafe) {
  for (const Picoseconds error : {tolerance, -tolerance}) {
    SafetyBench bench([](SafetySetup& setup) { setup.frame_gap_min = {}; });
    make_safe(bench);
    const Picoseconds now = bench.now + SafetyBench::cycle;
    BISS_EXPECT_EQ(good_at(bench, {now, now + ahead + error}).verdict, safe);
  }
}

// Each clock's time is checked, so that a second clock cannot lag behind step by step.
BISS_TEST(SafetyClock, BothClocks_AreWatched) {
  SafetyBench late([](SafetySetup& setup) { setup.frame_gap_max = SafetyBench::cycle; });
  make_safe(late);
  const Picoseconds now = late.now + SafetyBench::cycle;
  BISS_EXPECT_EQ(good_at(late, {now, now + ahead + picoseconds(1)}).verdict, watchdog);
  SafetyBench soon([](SafetySetup& setup) { setup.frame_gap_min = SafetyBench::cycle; });
  make_safe(soon);
  BISS_EXPECT_EQ(good_at(soon, {now, now + ahead - picoseconds(1)}).verdict, early);
}

BISS_TEST(SafetyClock, TimeThatStandsStill_IsAFaultAfterTheRequestsThatAreAllowed) {
  for (const std::uint8_t allowed : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{7}}) {
    // Nothing else measures time in this setup.
    SafetyBench bench([&](SafetySetup& setup) {
      setup.clocks.still_requests = allowed;
      setup.frame_gap_min = {};
    });
    bench.until_safe();
    for (unsigned i = 0; i < allowed; ++i) {
      BISS_EXPECT_EQ(good_at(bench, OneClock{bench.now}).verdict, safe) << unsigned{allowed};
    }
    BISS_EXPECT_EQ(good_at(bench, OneClock{bench.now}).verdict, SafetyVerdict::clock);
  }
}

// The number of such requests does not begin again.
BISS_TEST(SafetyClock, TimeThatStandsStillForEver_IsNeverSafeAgain) {
  for (const std::uint8_t allowed : {std::uint8_t{7}, std::uint8_t{255}}) {
    SafetyBench bench([&](SafetySetup& setup) {
      setup.clocks.still_requests = allowed;
      setup.frame_gap_min = {};
      setup.latch = false;
    });
    bench.until_safe();
    for (unsigned i = 0; i < 1000; ++i) {
      const SafetyVerdict verdict = good_at(bench, OneClock{bench.now}).verdict;
      BISS_EXPECT_EQ(verdict, i < allowed ? safe : SafetyVerdict::clock) << i;
    }
  }
}

// The first request may have any time, 0 too.
BISS_TEST(SafetyClock, FirstRequestAtZero_DoesNotStandStill) {
  BenchAt bench(Picoseconds{});
  BISS_EXPECT_EQ(bench.good().verdict, starting);
  BISS_EXPECT_EQ(bench.good(2).verdict, safe);
}

// Their difference then needs more bits than a time has.
BISS_TEST(SafetyClock, ClocksThatJumpApartByHalfTheirRange_Differ) {
  constexpr Picoseconds far{end_of_time.count / 4 * 3};
  for (const Picoseconds error : {far, -far}) {
    SafetyBench bench;
    make_safe(bench);
    const TwoClocks time{bench.now + error, bench.now + ahead - error};
    BISS_EXPECT_EQ(test::MonitorBytes(bench.monitor).monitor().watch(time).verdict,
                   SafetyVerdict::clock);
    BISS_EXPECT_EQ(good_at(bench, time).verdict, SafetyVerdict::clock);
  }
}

// The SPI clock as the second measure of time.
BISS_TEST(SafetyClock, TransferOfAWrongTime_IsAFault) {
  static constexpr Picoseconds bit = nanoseconds(100);
  const auto verdict_of = [](Picoseconds error, bool measured) {
    SafetyBench bench([](SafetySetup& setup) { setup.clocks.bit_period = bit; });
    SafetyJudgement judged;
    for (int i = 0; i < 4; ++i) {
      const FrameBits bits = test::bits_of(bench.plan(), bench.next());
      bench.now += SafetyBench::cycle;
      const auto nominal = bit * static_cast<std::int64_t>(bits.size_bits());
      const Picoseconds time = nominal + (i == 3 ? error : Picoseconds{});
      const OneClock clock{bench.now, {.time = measured || i < 3 ? time : Picoseconds{}}};
      judged = bench.monitor.step(clock, bits.view());
    }
    return judged.verdict;
  };
  BISS_EXPECT_EQ(verdict_of({}, true), safe);
  BISS_EXPECT_EQ(verdict_of(tolerance, true), safe);
  BISS_EXPECT_EQ(verdict_of(-tolerance, true), safe);
  BISS_EXPECT_EQ(verdict_of(tolerance + picoseconds(1), true), SafetyVerdict::clock);
  BISS_EXPECT_EQ(verdict_of(-tolerance - picoseconds(1), true), SafetyVerdict::clock);
  // A time that was not measured is not a transfer's time.
  BISS_EXPECT_EQ(verdict_of({}, false), SafetyVerdict::clock);
}

BISS_TEST(SafetyClock, TransferOfAReadersFrame_IsTimedToo) {
  SafetyBench bench([](SafetySetup& setup) { setup.clocks.bit_period = nanoseconds(100); });
  for (int i = 0; i < 4; ++i) {
    const FrameBits bits = test::bits_of(bench.plan(), bench.next());
    bench.now += SafetyBench::cycle;
    const auto time = nanoseconds(100) * static_cast<std::int64_t>(bits.size_bits());
    const OneClock clock{bench.now, {.time = i == 3 ? 2 * time : time}};
    const auto frame = decode_frame(bits.view(), bench.plan().codec());
    const SafetyVerdict verdict = bench.monitor.step(clock, bits.view(), frame).verdict;
    BISS_EXPECT_EQ(verdict, i < 2 ? starting : i == 2 ? safe : SafetyVerdict::clock) << i;
  }
}

BISS_TEST(SafetyClock, FindingWithoutItsTransfer_IsAFaultWhereTransfersAreTimed) {
  SafetyBench bench([](SafetySetup& setup) { setup.clocks.bit_period = nanoseconds(100); });
  const auto verdict_of = [&](const OneClock& clock) {
    const FrameBits bits = test::bits_of(bench.plan(), bench.next());
    const test::Findings<test::RunPlan> findings(bench.plan(), bits.view());
    return bench.monitor.step(clock, findings.first, findings.second).verdict;
  };
  bench.now += SafetyBench::cycle;
  BISS_EXPECT_EQ(verdict_of({bench.now, {nanoseconds(10'000), 100}}), starting);
  bench.now += SafetyBench::cycle;
  BISS_EXPECT_EQ(verdict_of({bench.now}), SafetyVerdict::clock);
  // A missing answer is not a transfer.
  BISS_EXPECT_EQ(bench.silence().verdict, no_frame);
}

// ---- Answers that are late by a constant number of requests

BISS_TEST(SafetyDelay, AnswersFromBeforeTheFirstRequest_AreRefusedByTheFirstValue) {
  const auto verdict_after = [](unsigned late) {
    SafetyBench bench([](SafetySetup& setup) { setup.counter.first = 1; });
    // A buffer gives nothing first, then the first answer.
    bench.counter = 63;
    for (unsigned i = 0; i < late; ++i) bench.silence();
    return bench.good(10).verdict;
  };
  BISS_EXPECT_EQ(verdict_after(0), safe);
  BISS_EXPECT_EQ(verdict_after(1), counter_first);
  BISS_EXPECT_EQ(verdict_after(40), counter_first);
}

BISS_TEST(SafetyDelay, FirstAnswerWithAnotherValue_IsRefusedUntilTheEncoderRestarts) {
  SafetyBench bench([](SafetySetup& setup) { setup.counter.first = 1; });
  for (int i = 0; i < 80; ++i) BISS_EXPECT_EQ(bench.good().verdict, counter_first);
  bench.monitor.encoder_restarted();
  bench.counter = 63;
  BISS_EXPECT_EQ(bench.good(2).verdict, starting);
  BISS_EXPECT_EQ(bench.good().verdict, safe);
}

BISS_TEST(SafetyDelay, FirstAnswerWithAnotherFault_IsRefusedUntilTheEncoderRestarts) {
  using Send = SafetyJudgement (*)(SafetyBench&);
  constexpr Send sends[] = {
      [](SafetyBench& b) { return b.send_flipped(50); },
      [](SafetyBench& b) { return b.send_changed([](auto& words) { words.cpw_nE = false; }); },
      [](SafetyBench& b) { return b.send_changed([](auto& words) { words.spw += 2; }); },
  };
  for (const Send send : sends) {
    SafetyBench bench([](SafetySetup& setup) { setup.counter.first = 1; });
    bench.counter = 63;
    BISS_EXPECT(is_fault(send(bench).verdict));
    for (int i = 0; i < 80; ++i) BISS_EXPECT_EQ(bench.good().verdict, counter_first) << i;
  }
}

// Nothing has judged the first answer: a later one with this value proves nothing.
BISS_TEST(SafetyDelay, FirstAnswerWhileNothingIsJudged_IsRefusedUntilTheEncoderRestarts) {
  const auto awaits = [](SafetySetup& setup) { setup.counter.first = 1; };
  // Before the self test.
  const auto plan = test::plan_of("fs-36-28", awaits);
  SafetyMonitor<test::RunPlan> untested(plan);
  Picoseconds now{};
  const auto step = [&](std::uint8_t counter) {
    now += SafetyBench::cycle;
    const SafetyFinding good{.life_counter = counter, .cause = safe};
    return untested.step(OneClock{now}, good, good).verdict;
  };
  BISS_EXPECT_EQ(step(63), self_test);
  BISS_EXPECT(untested.self_test(plan.fingerprint()));
  BISS_EXPECT_EQ(step(1), counter_first);
  BISS_EXPECT_EQ(step(2), counter_first);
  untested.encoder_restarted();
  BISS_EXPECT_EQ(step(1), starting);
  // While a fault is latched.
  SafetyBench bench(awaits);
  bench.counter = 63;
  bench.until_safe();
  bench.silence();
  bench.monitor.encoder_restarted();
  BISS_EXPECT_EQ(bench.good().verdict, latched);
  BISS_EXPECT(bench.acknowledge());
  bench.counter = 63;
  for (int i = 0; i < 80; ++i) BISS_EXPECT_EQ(bench.good().verdict, counter_first) << i;
  // Acknowledged before the first request.
  bench.monitor.encoder_restarted();
  bench.counter = 63;
  BISS_EXPECT_EQ(bench.good(3).verdict, safe);
}

// An encoder behind a line whose answers all belong to the third request before.
class StaleLine {
 public:
  explicit StaleLine(const auto& change) : bench_(change) {
    for (auto& words : past_) words = bench_.next();
  }
  SafetyBench& bench() { return bench_; }
  SafetyJudgement request() {
    const test::SafetyWords sent = past_[0];
    std::copy(past_ + 1, past_ + late, past_);
    past_[late - 1U] = bench_.next();
    return bench_.send(sent);
  }
  // The axis moves; the next answer of the encoder has that position.
  void stimulus() {
    bench_.position += 0x1'0000'0000U;
    const std::uint64_t at = ((bench_.position + 1000U) & low_mask(36)) >> 8U;
    bench_.monitor.expect_position(at - 1U, at + 1U);
  }

 private:
  static constexpr std::size_t late = 3;
  SafetyBench bench_;
  test::SafetyWords past_[late];
};

BISS_TEST(SafetyDelay, StaleAnswersSincePowerUp_AreNeverSafeAfterAStimulus) {
  for (const bool latch : {true, false}) {
    // The stimulus before the first request, while starting, with the first safe frame, and later.
    for (unsigned before = 0; before < 6; ++before) {
      StaleLine line([&](SafetySetup& setup) { setup.latch = latch; });
      for (unsigned i = 0; i < before; ++i) line.request();
      line.stimulus();
      BISS_EXPECT_EQ(line.request().verdict, stimulus) << before;
      for (int i = 0; i < 200; ++i) {
        line.bench().acknowledge();
        const SafetyJudgement judged = line.request();
        BISS_EXPECT(judged.verdict == stimulus && !judged.position) << before << " " << i;
        BISS_EXPECT_EQ(judged.state, SafetyState::starting);
      }
    }
  }
}

// What comes between expect_position() and the next good frame.
using Between = void (*)(SafetyBench&);
constexpr Between betweens[] = {
    [](SafetyBench&) {},
    [](SafetyBench& b) { b.silence(); },
    [](SafetyBench& b) { b.send_flipped(0); },
    [](SafetyBench& b) { b.send_flipped(50); },
    [](SafetyBench& b) { b.send_changed([](auto& words) { words.cpw_nE = false; }); },
    [](SafetyBench& b) { b.send_changed([](auto& words) { words.spw_nE = false; }); },
    [](SafetyBench& b) { b.send_changed([](auto& words) { words.spw += 2; }); },
    [](SafetyBench& b) { b.send(b.words()); },
    [](SafetyBench& b) { b.next(), b.good(); },
    [](SafetyBench& b) { --b.counter, b.send(b.words()); },
    [](SafetyBench& b) { b.counter = (b.counter + 30) % 63 + 1, b.good(); },
    [](SafetyBench& b) { b.now -= SafetyBench::cycle / 2, b.good(); },
    [](SafetyBench& b) { b.now -= SafetyBench::cycle, b.good(); },
    [](SafetyBench& b) { b.now += SafetyBench::cycle * 9, b.good(); },
    [](SafetyBench& b) { b.watch(b.now += SafetyBench::cycle * 9); },
    [](SafetyBench& b) { b.watch(b.now); },
    [](SafetyBench& b) { BISS_EXPECT(b.monitor.self_test(b.plan().fingerprint())); },
    [](SafetyBench& b) { b.silence(), b.good(2), b.acknowledge(); },
    [](SafetyBench& b) { b.monitor.encoder_restarted(); },
};

BISS_TEST(SafetyDelay, NothingButAGoodFrame_EndsAnExpectation) {
  for (const bool latch : {true, false}) {
    for (const std::uint8_t faults : {std::uint8_t{0}, std::uint8_t{2}}) {
      for (const unsigned before : {0U, 1U, 2U, 3U, 9U}) {
        for (std::size_t k = 0; k < std::size(betweens); ++k) {
          for (const bool inside : {true, false}) {
            SafetyBench bench([&](SafetySetup& setup) {
              setup.latch = latch;
              setup.budget = {.faults = faults, .window = milliseconds(1)};
              setup.frame_gap_max = SafetyBench::cycle * 4;
            });
            bench.good(before);
            if (inside) {
              bench.monitor.expect_position(0x1'0000U, 0xFFF'FFFFU);
            } else {
              bench.monitor.expect_position(5'000'000, 5'000'100);
            }
            betweens[k](bench);
            bench.acknowledge();
            SafetyJudgement judged = bench.good();
            for (int i = 0; i < 3 && is_fault(judged.verdict) && judged.verdict != stimulus; ++i) {
              bench.acknowledge();
              judged = bench.good();
            }
            BISS_EXPECT_EQ(judged.verdict == stimulus, !inside)
                << latch << " " << before << " " << k << " " << static_cast<int>(faults);
          }
        }
      }
    }
  }
}

BISS_TEST(SafetyDelay, PositionOutsideAnExpectation_HoldsUntilTheEncoderRestarts) {
  for (const bool latch : {true, false}) {
    for (const unsigned before : {0U, 1U, 2U, 3U, 9U}) {
      SafetyBench bench([&](SafetySetup& setup) {
        setup.latch = latch;
        setup.counter.first = 11;
      });
      bench.good(before);
      const bool was_safe = bench.monitor.state() == SafetyState::safe;
      bench.monitor.expect_position(5'000'000, 5'000'100);
      BISS_EXPECT_EQ(bench.good().verdict, stimulus) << before;
      BISS_EXPECT_EQ(bench.monitor.state(),
                     was_safe && latch ? SafetyState::latched : SafetyState::starting);
      BISS_EXPECT_EQ(bench.acknowledge(), was_safe && latch);
      for (int i = 0; i < 80; ++i) BISS_EXPECT_EQ(bench.good().verdict, stimulus) << i;
      // Neither another expectation, nor a self test, nor another fault.
      bench.monitor.expect_position(0, ~std::uint64_t{0});
      BISS_EXPECT_EQ(bench.good().verdict, stimulus);
      BISS_EXPECT(bench.monitor.self_test(bench.plan().fingerprint()));
      BISS_EXPECT_EQ(bench.silence().verdict, no_frame);
      for (int i = 0; i < 80; ++i) BISS_EXPECT_EQ(bench.good().verdict, stimulus) << i;
      // The expectation that was not met has ended.
      bench.monitor.encoder_restarted();
      bench.counter = 10;
      BISS_EXPECT_EQ(bench.good(2).verdict, starting);
      BISS_EXPECT_EQ(bench.good().verdict, safe);
    }
  }
}

// Given while the fault holds: after the restart it is the first thing to be met.
BISS_TEST(SafetyDelay, ExpectationBeforeARestart_IsMetAfterIt) {
  SafetyBench bench;
  bench.monitor.expect_position(5'000'000, 5'000'100);
  BISS_EXPECT_EQ(bench.good().verdict, stimulus);
  bench.monitor.expect_position(6'000'000, 6'000'100);
  BISS_EXPECT_EQ(bench.good().verdict, stimulus);
  bench.monitor.encoder_restarted();
  BISS_EXPECT_EQ(bench.good().verdict, stimulus);
  bench.monitor.encoder_restarted();
  BISS_EXPECT_EQ(bench.good(3).verdict, safe);
  bench.monitor.expect_position(6'000'000, 6'000'100);
  bench.monitor.encoder_restarted();
  bench.position = 5'000'000U << 8U;
  BISS_EXPECT_EQ(bench.good().verdict, stimulus);
}

BISS_TEST(SafetyDelay, OldPositionAfterAStimulus_IsAFault) {
  const auto verdict_of = [](std::uint64_t low, std::uint64_t high) {
    SafetyBench bench;
    bench.until_safe();
    bench.position = 1000U << 8U;
    bench.monitor.expect_position(low, high);
    const SafetyJudgement judged = bench.good();
    BISS_EXPECT(judged.position.has_value() == (judged.verdict == safe));
    return judged.verdict;
  };
  const std::uint64_t at = ((1000U << 8U) + 1000U) >> 8U;
  BISS_EXPECT_EQ(verdict_of(at, at), safe);
  BISS_EXPECT_EQ(verdict_of(at - 1U, at + 1U), safe);
  BISS_EXPECT_EQ(verdict_of(at + 1U, at + 5U), stimulus);
  BISS_EXPECT_EQ(verdict_of(at - 5U, at - 1U), stimulus);
  // Across the wrap-around.
  BISS_EXPECT_EQ(verdict_of(at + 100U, at + 1U), safe);
  BISS_EXPECT_EQ(verdict_of(at + 100U, at - 1U), stimulus);
  BISS_EXPECT_EQ(verdict_of(at, at - 100U), safe);
  BISS_EXPECT_EQ(verdict_of(at + 1U, at - 100U), stimulus);
  // It holds for one frame.
  SafetyBench bench;
  bench.until_safe();
  const std::uint64_t next = (bench.position + 1000U) >> 8U;
  bench.monitor.expect_position(next, next);
  BISS_EXPECT_EQ(bench.good(5).verdict, safe);
}

}  // namespace biss::safety_time_test
