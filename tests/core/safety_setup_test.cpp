// Setups that cannot be monitored, the named configurations, and the table of faults.
#include "biss/safety/setup.hpp"

#include "biss/base/wrapping_time.hpp"
#include "biss/frame/encode.hpp"
#include "biss/safety/configurations.hpp"
#include "biss/safety/field_evaluation.hpp"
#include "biss/safety/monitor.hpp"
#include "biss/safety/verdict.hpp"
#include "tests/core/frames.hpp"
#include "tests/core/test.hpp"

namespace biss::safety_setup_test {

using test::format_of;

constexpr std::string_view good_text = "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0";

void expect_mistake(std::string_view format, SafetySetupError mistake,
                    const SafetySetup& setup = {}) {
  const auto found = check_safety(format_of(format), UnratedSafetySetup(setup));
  BISS_ASSERT(found.has_value());
  BISS_EXPECT_EQ(*found, mistake);
}

void expect_mistake(SafetySetupError mistake, const auto& change) {
  SafetySetup setup;
  change(setup);
  expect_mistake(good_text, mistake, setup);
}

BISS_TEST(SafetySetup, OfFormatsThatLackSomething_IsRefused) {
  using enum SafetySetupError;
  BISS_EXPECT(!check_safety(format_of(good_text), SafetySetup()));
  expect_mistake("pos36,nE,nW,crc6", channels);
  expect_mistake(good_text, channels, {.cpw = 2});
  expect_mistake(good_text, channels, {.cpw = 0, .spw = 0});
  expect_mistake("pos36,nE,nW+pos28,nE,nW,lc6,crc16", no_crc);
  expect_mistake("pos36,nE,nW,crc6+pos28,nE,nW,lc6", no_crc);
  expect_mistake("pos36,nW,crc6+pos28,nE,nW,lc6,crc16", no_error_bit);
  expect_mistake("pos36,nE,nW,crc6+pos28,nW,lc6,crc16", no_error_bit);
  expect_mistake("pad36,nE,nW,crc6+pos28,nE,nW,lc6,crc16", no_position);
  expect_mistake("mt12,nE,nW,crc6+pos28,nE,nW,lc6,crc16", no_position);
  expect_mistake("mt12,st16:gray,nE,nW,crc6+pos28,nE,nW,lc6,crc16", gray);
  expect_mistake("pos36,nE,nW,crc6+pos28,nE,nW,crc16", no_counter);
  expect_mistake("pos36,nE,nW,crc6+pos28,nE,nW,lc7,crc16", no_counter);
}

// Not even a setup without a rating takes a checksum that is done wrong.
BISS_TEST(SafetySetup, OfACrcWithAMakersError_IsRefused) {
  for (const char* text : {"pos36,nE,nW,crc6:reversed+pos28,nE,nW,lc6,crc16",
                           "pos36,nE,nW,crc6:no-flags+pos28,nE,nW,lc6,crc16",
                           "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16:cds",
                           "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16:previous"}) {
    const auto found = check_safety(format_of(text), UnratedSafetySetup(SafetySetup()));
    BISS_EXPECT(found == SafetySetupError::checksum) << text;
  }
}

BISS_TEST(SafetySetup, OutOfRange_IsRefusedAndTheLastOneWithinIsNot) {
  using enum SafetySetupError;
  const auto accepts = [](const auto& change) {
    SafetySetup setup;
    change(setup);
    return !check_safety(format_of(good_text), UnratedSafetySetup(setup));
  };
  BISS_EXPECT(accepts([](auto& s) { s.comparison.compare_bits = 28; }));
  expect_mistake(compare_bits, [](auto& s) { s.comparison.compare_bits = 29; });
  expect_mistake("pos20,nE,nW,crc6+pos28,nE,nW,lc6,crc16", compare_bits,
                 {.comparison = {.compare_bits = 21}});
  BISS_EXPECT(accepts([](auto& s) { s.comparison = {.compare_bits = 3, .tolerance_lsb = 3}; }));
  expect_mistake(tolerance,
                 [](auto& s) { s.comparison = {.compare_bits = 3, .tolerance_lsb = 4}; });
  BISS_EXPECT(accepts([](auto& s) { s.start_frames = 2; }));
  expect_mistake(start_frames, [](auto& s) { s.start_frames = 1; });
  BISS_EXPECT(accepts([](auto& s) { s.counter.near_frames = 30; }));
  expect_mistake(counter, [](auto& s) { s.counter.near_frames = 31; });
  BISS_EXPECT(accepts([](auto& s) { s.counter.learn_rollovers = 1; }));
  expect_mistake(counter, [](auto& s) { s.counter.learn_rollovers = 0; });
  BISS_EXPECT(accepts([](auto& s) { s.counter.first = 63; }));
  expect_mistake(counter, [](auto& s) { s.counter.first = 64; });
  expect_mistake(counter, [](auto& s) { s.counter.first = 254; });
  // A counter from 1 on never has 0.
  expect_mistake(counter, [](auto& s) { s.counter.first = 0; });
  BISS_EXPECT(accepts([](auto& s) {
    s.counter.first = 0;
    s.counter.mode = CounterMode::count_0_63;
  }));
  BISS_EXPECT(accepts([](auto& s) { s.clocks.tolerance = {}; }));
  BISS_EXPECT(accepts([](auto& s) { s.clocks.tolerance = s.frame_gap_max - picoseconds(1); }));
  expect_mistake(clocks, [](auto& s) { s.clocks.tolerance = s.frame_gap_max; });
  expect_mistake(clocks, [](auto& s) { s.clocks.tolerance = picoseconds(-1); });
  expect_mistake(clocks, [](auto& s) { s.clocks.bit_period = picoseconds(-1); });
  expect_mistake(clocks, [](auto& s) { s.clocks.bit_period = max_bit_period + picoseconds(1); });
  BISS_EXPECT(accepts([](auto& s) { s.bounds = {402, 402, 400, 400, 0}; }));
  expect_mistake(bounds, [](auto& s) { s.bounds.lead_min_clocks = 403; });
  expect_mistake(bounds, [](auto& s) { s.bounds = {403, 403, 1, 1, 0}; });
  expect_mistake(bounds, [](auto& s) { s.bounds = {0, 0, 1, 1, 0}; });
  expect_mistake(bounds, [](auto& s) { s.bounds = {1, 1, 32, 2, 0}; });
  expect_mistake(bounds, [](auto& s) { s.bounds = {1, 1, 401, 401, 0}; });
  expect_mistake(bounds, [](auto& s) { s.bounds = {1, 1, 0, 0, 0}; });
  BISS_EXPECT(accepts([](auto& s) { s.budget = {4, s.frame_gap_max}; }));
  expect_mistake(budget, [](auto& s) { s.budget = {5, s.frame_gap_max}; });
  expect_mistake(budget, [](auto& s) { s.budget = {1, s.frame_gap_max - picoseconds(1)}; });
}

constexpr std::array modes{CounterMode::count_1_63, CounterMode::count_0_63, CounterMode::learned};

BISS_TEST(SafetySetup, Watchdog_IsShorterThanTheCountersPeriod) {
  using enum SafetySetupError;
  for (const CounterMode mode : modes) {
    const unsigned period = mode == CounterMode::count_0_63 ? 64 : 63;
    BISS_EXPECT_EQ(counter_period(mode), period);
    // A shortest gap that encoders keep, one below what they can do, and none.
    constexpr Picoseconds fastest = nanoseconds(31'250) - nanoseconds(31'250) / 32;
    for (const Picoseconds least :
         {fastest, nanoseconds(60'000), milliseconds(900), picoseconds(1), Picoseconds{}}) {
      const Picoseconds count = std::max(least, fastest);
      SafetySetup setup{.frame_gap_min = least};
      setup.counter.mode = mode;
      setup.frame_gap_max = count * period - picoseconds(1);
      BISS_EXPECT(!check_safety(format_of(good_text), UnratedSafetySetup(setup))) << least.count;
      setup.frame_gap_max += picoseconds(1);
      expect_mistake(good_text, frame_gap, setup);
    }
    // An encoder with a shorter cycle counts sooner.
    SafetySetup fast{.cycle_min = microseconds(16), .frame_gap_min = {}};
    fast.counter.mode = mode;
    fast.frame_gap_max = nanoseconds(15'500) * period - picoseconds(1);
    BISS_EXPECT(!check_safety(format_of(good_text), UnratedSafetySetup(fast)));
    fast.frame_gap_max += picoseconds(1);
    expect_mistake(good_text, frame_gap, fast);
  }
  expect_mistake(frame_gap, [](auto& s) { s.frame_gap_min = s.frame_gap_max; });
  expect_mistake(frame_gap, [](auto& s) { s.frame_gap_min = picoseconds(-1); });
  BISS_EXPECT_EQ(at_cycle({}, microseconds(100)).frame_gap_max.count, microseconds(150).count);
}

BISS_TEST(SafetySetup, CycleAboveTheShortestGap_PermitsNoLongerWatchdog) {
  const auto refused = [](Picoseconds cycle, Picoseconds most, Picoseconds least) {
    SafetySetup setup = find_safety_configuration("fs-36-28")->setup;
    setup.cycle_min = cycle;
    setup.frame_gap_max = most;
    setup.frame_gap_min = least;
    const FrameFormat format = format_of(good_text);
    const auto mistake = check_safety(format, UnratedSafetySetup(setup));
    BISS_EXPECT(check_safety(format, setup) == mistake);
    SafetyMonitor<SafetyPlan<2>> monitor(SafetyPlan<2>(format, UnratedSafetySetup(setup)));
    BISS_EXPECT_EQ(monitor.self_test(monitor.plan().fingerprint()), !mistake);
    return mistake == SafetySetupError::frame_gap;
  };
  constexpr Picoseconds usual = SafetySetup{}.frame_gap_min;
  constexpr Picoseconds longest{std::numeric_limits<std::int64_t>::max()};
  BISS_EXPECT(refused(milliseconds(2), milliseconds(3), usual));
  BISS_EXPECT(refused(milliseconds(2), milliseconds(3), nanoseconds(47'619)));
  BISS_EXPECT(!refused(milliseconds(2), milliseconds(3), nanoseconds(47'620)));
  BISS_EXPECT(refused(longest, max_frame_gap, usual));
  BISS_EXPECT(refused(longest, max_frame_gap, milliseconds(96'000)));
  BISS_EXPECT(refused(max_frame_gap + picoseconds(1), max_frame_gap, milliseconds(96'000)));
  BISS_EXPECT(!refused(max_frame_gap, max_frame_gap, milliseconds(96'000)));
  BISS_EXPECT(refused({}, nanoseconds(46'875), usual));
  BISS_EXPECT(refused(picoseconds(-1), nanoseconds(46'875), usual));
}

BISS_TEST(SafetySetup, AtAnyIntervalFromTheShortestCycleOn_IsValid) {
  const auto sweep = [](const auto& judge) {
    for (Picoseconds interval = safety_cycle; interval < max_frame_gap;
         interval += interval / static_cast<std::int64_t>(test::rounds(50, 5)) + picoseconds(7)) {
      judge(interval);
    }
    for (const std::int64_t us : {62, 1'312, 1'313, 1'314, 2'000, 66'666'666, 66'666'667}) {
      judge(microseconds(us));
    }
    judge(max_frame_gap);
  };
  for (const SafetyConfiguration& each : safety_configurations) {
    const FrameFormat format = each.frame_format();
    sweep([&](Picoseconds interval) {
      SafetySetup setup = at_cycle(each.setup, interval);
      if (interval < each.setup.cycle_min) return;
      for (const CounterMode mode : modes) {
        setup.counter.mode = mode;
        BISS_EXPECT(!check_safety(format, setup)) << interval.count;
      }
      BISS_EXPECT(setup.cycle_min == interval && setup.frame_gap_min <= interval);
      BISS_EXPECT(setup.frame_gap_max >= interval && setup.clocks.tolerance == interval / 32);
      BISS_EXPECT(setup.frame_gap_min.count > interval.count / 100 * 95);
    });
  }
}

// What no interval is has no setup, and no calculation runs over.
constexpr bool is_refused_at(Picoseconds interval) {
  const auto mistake = check_safety(parse_format(good_text).value(), at_cycle({}, interval));
  return mistake == SafetySetupError::frame_gap;
}
static_assert(is_refused_at({}) && is_refused_at(picoseconds(-1)));
static_assert(is_refused_at(max_frame_gap + picoseconds(1)));
static_assert(is_refused_at(Picoseconds{std::numeric_limits<std::int64_t>::max()}));
static_assert(is_refused_at(Picoseconds{std::numeric_limits<std::int64_t>::min()}));

// Frames at a rate below the highest one reach the safe state, and one that is missing is late.
BISS_TEST(SafetySetup, AtSlowIntervals_IsSafeAndMissesOneFrame) {
  for (const Picoseconds interval : {nanoseconds(62'500), microseconds(1'314), milliseconds(2),
                                     milliseconds(1'000), max_frame_gap}) {
    const SafetyPlan<2> plan(format_of(good_text), at_cycle({}, interval));
    SafetyMonitor<SafetyPlan<2>> monitor(plan);
    BISS_ASSERT(monitor.self_test(plan.fingerprint()));
    SafetyFinding finding{.life_counter = 1, .nW = 3, .cause = SafetyVerdict::safe};
    Picoseconds now{};
    const auto step = [&] {
      ++finding.life_counter;
      return monitor.step(OneClock{now += interval}, finding, finding).verdict;
    };
    BISS_EXPECT_EQ(step(), SafetyVerdict::starting);
    BISS_EXPECT_EQ(step(), SafetyVerdict::starting);
    for (int i = 0; i < 5; ++i) BISS_EXPECT_EQ(step(), SafetyVerdict::safe) << interval.count;
    now += interval;
    ++finding.life_counter;
    BISS_EXPECT_EQ(step(), SafetyVerdict::watchdog) << interval.count;
  }
}

// ---- The loss of a whole period

// A random time up to `most`, as often short as long.
Picoseconds some_time(auto& random, Picoseconds most) {
  const auto bits = static_cast<unsigned>(random.below(64));
  return picoseconds(
      static_cast<std::int64_t>((random.next() >> bits) % static_cast<std::uint64_t>(most.count)));
}

// Any setup that check_safety() accepts.
SafetySetup some_setup(auto& random, const FrameFormat& format) {
  while (true) {
    SafetySetup setup{.start_frames = 2, .latch = false};
    setup.counter = {.mode = modes[random.below(3)],
                     .missed = static_cast<MissedFrames>(random.below(2)),
                     .learn_rollovers = 1};
    if (random.below(4) == 0) {
      setup = at_cycle(setup, some_time(random, max_frame_gap));
    } else {
      constexpr Picoseconds longest{std::numeric_limits<std::int64_t>::max()};
      setup.cycle_min = some_time(random, longest);
      setup.frame_gap_min = random.below(3) == 0 ? Picoseconds{} : some_time(random, max_frame_gap);
      const Picoseconds most = setup.frame_gap_min * static_cast<std::int64_t>(random.below(66));
      setup.frame_gap_max = random.below(2) == 0 ? most : some_time(random, max_frame_gap);
      setup.clocks.tolerance = {};
    }
    setup.budget = {static_cast<std::uint8_t>(random.below(5)), setup.frame_gap_max};
    if (!check_safety(format, UnratedSafetySetup(setup))) return setup;
  }
}

// Frames are lost at every interval that is not `early` and that encoders can count at; some of them
// are faults that the budget tolerates. Then the counter may have the expected value again.
BISS_TEST(SafetySetup, LossOfAWholePeriodWithAnyValidSetup_IsNeverSafe) {
  BISS_RANDOM(random, 0x5AFE'0025);
  const FrameFormat format = format_of(good_text);
  const auto setups = test::rounds(2'000, 30);
  unsigned fitting = 0;
  for (unsigned n = 0; n < setups; ++n) {
    const SafetySetup setup = some_setup(random, format);
    const SafetyPlan<2> plan(format, UnratedSafetySetup(setup));
    SafetyMonitor<SafetyPlan<2>> monitor(plan);
    BISS_ASSERT(monitor.self_test(plan.fingerprint()));
    const bool has_zero = setup.counter.mode == CounterMode::count_0_63 ||
                          (setup.counter.mode == CounterMode::learned && random.below(2) == 0);
    SafetyFinding good{.life_counter = 5, .nW = 3, .cause = SafetyVerdict::safe};
    Picoseconds now{};
    const auto request = [&](Picoseconds interval) {
      now = wrapping_later(now, interval);
      good.life_counter = good.life_counter == 63 ? !has_zero : good.life_counter + 1U;
    };
    const auto step = [&](const SafetyFinding& finding) {
      return monitor.step(OneClock{now}, finding, finding);
    };
    // The encoder's shortest interval, and one that the monitor accepts.
    const Picoseconds fastest = std::min(setup.cycle_min, nanoseconds(31'250));
    const Picoseconds least = std::max(setup.frame_gap_min, fastest - fastest / 32);
    for (unsigned lost = 62; lost <= 64; ++lost) {
      for (unsigned seen = 0; seen <= setup.budget.faults; ++seen) {
        for (int i = 0; i < 500 && monitor.state() != SafetyState::safe; ++i) {
          request(setup.frame_gap_max);
          step(good);
        }
        BISS_ASSERT(monitor.state() == SafetyState::safe);
        const std::uint8_t last = good.life_counter;
        const Picoseconds interval = least + some_time(random, least + picoseconds(2)) / 64;
        for (unsigned i = 0; i < lost; ++i) {
          request(interval);
          if (i < seen) step(SafetyFinding{});
        }
        request(interval);
        if (good.life_counter == last + 1U) ++fitting;
        BISS_EXPECT(step(good).verdict != SafetyVerdict::safe)
            << setup.cycle_min.count << " " << setup.frame_gap_max.count << " "
            << setup.frame_gap_min.count << " lost " << lost << " seen " << seen;
      }
    }
  }
  BISS_EXPECT(fitting >= setups);
}

BISS_TEST(SafetyConfigurations, AreRenishawsFiveRowsAndTheNineTypes) {
  struct Row {
    std::string_view name;
    unsigned cpw_turns, cpw, spw_turns, spw, compare_bits;
    std::int64_t cycle_ns;
  };
  // Renishaw's table, and PROTOCOL 5.2 (Safety Concept A5, table 1).
  constexpr Row rows[] = {
      {"fs-32-32", 0, 32, 0, 32, 0, 31'250},
      {"fs-28-24", 0, 28, 0, 24, 0, 31'250},
      {"fs-36-28", 0, 36, 0, 28, 0, 31'250},
      {"fortis-fs-36-28-10nm", 0, 36, 0, 28, 0, 31'250},
      {"fortis-fs-36-28-1nm", 0, 36, 0, 28, 0, 31'250},
      {"rxm", 0, 16, 0, 12, 9, 31'250},
      {"rxh", 0, 24, 0, 16, 13, 31'250},
      {"rsm", 12, 16, 12, 12, 9, 31'250},
      {"rsh", 12, 24, 12, 16, 13, 62'500},
      {"rlm", 24, 16, 24, 12, 9, 62'500},
      {"rlh", 24, 24, 24, 16, 13, 62'500},
      {"rum", 12, 16, 0, 12, 9, 31'250},
      {"ruh", 12, 24, 0, 16, 13, 62'500},
      {"lmm", 16, 16, 16, 16, 11, 62'500},
  };
  BISS_EXPECT_EQ(safety_configurations.size(), std::size(rows));
  for (const Row& row : rows) {
    const SafetyConfiguration* found = find_safety_configuration(row.name);
    BISS_ASSERT(found != nullptr);
    const FrameFormat format = found->frame_format();
    BISS_EXPECT(!check_safety(format, found->setup));
    const ChannelFormat& cpw = format.channel_list[0];
    const ChannelFormat& spw = format.channel_list[1];
    BISS_EXPECT_EQ(cpw.multiturn.bits, row.cpw_turns);
    BISS_EXPECT_EQ(spw.multiturn.bits, row.spw_turns);
    BISS_EXPECT_EQ(cpw.position_bits(), row.cpw_turns + row.cpw);
    BISS_EXPECT_EQ(spw.position_bits(), row.spw_turns + row.spw);
    BISS_EXPECT(cpw.crc == crc6 && spw.crc == crc16);
    BISS_EXPECT(cpw.error.present && cpw.warning.present && spw.warning.present);
    BISS_EXPECT_EQ(found->setup.comparison.compare_bits, row.compare_bits);
    BISS_EXPECT_EQ(found->setup.cycle_min.count, nanoseconds(row.cycle_ns).count);
    BISS_EXPECT_EQ(found->setup.frame_gap_max.count, nanoseconds(row.cycle_ns * 3 / 2).count);
    BISS_EXPECT(!found->source.empty());
    BISS_EXPECT(found->resolution.empty() == (row.compare_bits != 0));
  }
  BISS_EXPECT(find_safety_configuration("rxl") == nullptr);
}

// 10 MHz: START not before 3.225 us after LAT, ACK at most 16 us, the line delay of 100 m.
BISS_TEST(SafetyConfigurations, FrameThatNoEncoderSends_IsRefusedByItsTiming) {
  for (const char* name : {"fs-32-32", "fs-36-28", "fortis-fs-36-28-10nm", "fortis-fs-36-28-1nm"}) {
    const SafetyConfiguration& type = *find_safety_configuration(name);
    const SafetyPlan<2> plan(type.frame_format(), type.setup);
    const auto cause_of = [&](std::uint16_t lead, std::uint16_t ack) {
      BasicFrame<2> frame;
      frame.channel_count = 2;
      frame.lead_clocks = lead;
      frame.ack_clocks = ack;
      frame.channel_list[1].life_counter = 1;
      const auto bits = encode_frame(frame, plan.codec());
      BISS_EXPECT(bits.ok());
      const auto found = FieldEvaluation<SafetyPlan<2>>::find(plan, bits->view());
      BISS_EXPECT(found == LineEvaluation<SafetyPlan<2>>::find(plan, bits->view()));
      return found.cause;
    };
    using enum SafetyVerdict;
    BISS_EXPECT_EQ(cause_of(2, 1), no_frame);
    BISS_EXPECT_EQ(cause_of(2, 31), no_frame);
    BISS_EXPECT_EQ(cause_of(2, 32), safe);
    BISS_EXPECT_EQ(cause_of(2, 160), safe);
    BISS_EXPECT_EQ(cause_of(2, 161), no_frame);
    BISS_EXPECT_EQ(cause_of(2, 400), no_frame);
    BISS_EXPECT_EQ(cause_of(13, 32), safe);
    BISS_EXPECT_EQ(cause_of(14, 32), no_frame);
    // 0.1 us after the last frame.
    BISS_EXPECT(type.setup.frame_gap_min > microseconds(30));
    BISS_EXPECT(type.setup.frame_gap_min < nanoseconds(31'250));
  }
}

// ---- The floor under a configuration

SafetySetup rated(const FrameFormat& format, std::uint64_t residual_e24) {
  SafetySetup setup;
  SafetyRating& rating = setup.rating;
  rating.words = rated_words(format.channel_list[0], format.channel_list[1], setup.comparison);
  rating.residual_e24 = residual_e24;
  rating.check = rating_check(rating.words, residual_e24);
  return setup;
}

BISS_TEST(SafetyRating, WeakChecksums_AreRefusedWhateverTheirRating) {
  for (const char* text :
       {"pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc3;cds0", "pos36,nE,nW,crc5+pos28,nE,nW,lc6,crc16;cds0",
        "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16:0x11021;cds0"}) {
    const FrameFormat format = format_of(text);
    const SafetySetup setup = rated(format, 1);
    BISS_EXPECT(check_safety(format, setup) == SafetySetupError::checksum) << text;
    BISS_EXPECT(!check_safety(format, UnratedSafetySetup(setup))) << text;
    SafetyMonitor<SafetyPlan<2>> monitor(SafetyPlan<2>(format, setup));
    BISS_EXPECT(!monitor.self_test(monitor.plan().fingerprint())) << text;
  }
}

BISS_TEST(SafetyRating, FewComparedBitsOrAWideTolerance_AreRefused) {
  const FrameFormat format = format_of(good_text);
  const auto mistake_of = [&](std::uint8_t bits, std::uint8_t tolerance) {
    SafetySetup setup;
    setup.comparison = {.compare_bits = bits, .tolerance_lsb = tolerance};
    BISS_EXPECT(!check_safety(format, UnratedSafetySetup(setup)));
    return check_safety(format, setup);
  };
  BISS_EXPECT(mistake_of(2, 0) == SafetySetupError::weak_comparison);
  BISS_EXPECT(mistake_of(8, 1) == SafetySetupError::weak_comparison);
  BISS_EXPECT(mistake_of(0, 2) == SafetySetupError::weak_comparison);
  BISS_EXPECT(mistake_of(0, 255) == SafetySetupError::weak_comparison);
  // Nine bits are enough bits, but nothing rates them.
  BISS_EXPECT(mistake_of(9, 1) == SafetySetupError::unrated);
  BISS_EXPECT(!mistake_of(0, 1));
}

BISS_TEST(SafetyRating, OfOtherWordsOrCopiedWrongly_IsRefused) {
  const FrameFormat format = format_of("pos35,nE,nW,crc6+pos27,nE,nW,lc6,crc16;cds0");
  BISS_EXPECT(check_safety(format, SafetySetup()) == SafetySetupError::unrated);
  const SafetySetup good = rated(format, 5'000'000);
  BISS_EXPECT(!check_safety(format, good));
  for (unsigned bit = 0; bit < 64; ++bit) {
    for (std::uint64_t SafetyRating::*const member :
         {&SafetyRating::words, &SafetyRating::residual_e24, &SafetyRating::check}) {
      SafetySetup wrong = good;
      wrong.rating.*member ^= std::uint64_t{1} << bit;
      BISS_EXPECT(check_safety(format, wrong) == SafetySetupError::unrated) << bit;
    }
  }
  // A mistake of another kind comes first.
  BISS_EXPECT(check_safety(format, SafetySetup{.spw = 0}) == SafetySetupError::channels);
  const FrameFormat other = format_of("pos35,nE,nW,crc6+pos26,nE,nW,lc6,crc16;cds0");
  BISS_EXPECT(check_safety(other, good) == SafetySetupError::unrated);
}

BISS_TEST(SafetyRating, MoreErrorsThanTheLimitAtTheHighestRate_AreRefused) {
  const FrameFormat format = format_of("pos35,nE,nW,crc6+pos27,nE,nW,lc6,crc16;cds0");
  // 118 916 128 frames an hour: 1e-9 an hour are 8.409288e-18 a frame.
  SafetySetup setup = rated(format, 8'409'288);
  BISS_EXPECT(!check_safety(format, setup));
  setup = rated(format, 8'409'289);
  BISS_EXPECT(check_safety(format, setup) == SafetySetupError::residual);
  setup.residual_max_e15 = 1'000'100;
  BISS_EXPECT(!check_safety(format, setup));
  // The limit times 1e9 is above 2^64.
  setup.residual_max_e15 = 18'446'744'074;
  BISS_EXPECT(!check_safety(format, setup));
  // The part of a frame at the end of the hour counts as a frame.
  setup = rated(format, 8'333'333);
  setup.frame_gap_min = microseconds(30) - picoseconds(1);
  BISS_EXPECT(check_safety(format, setup) == SafetySetupError::residual);
  setup.frame_gap_min = microseconds(30) + picoseconds(1);
  BISS_EXPECT(!check_safety(format, setup));
  // Half the rate, half the errors.
  setup = rated(format, 16'818'576);
  BISS_EXPECT(check_safety(format, setup) == SafetySetupError::residual);
  setup.frame_gap_min = setup.frame_gap_min * 2;
  setup.frame_gap_max = setup.frame_gap_max * 2;
  BISS_EXPECT(!check_safety(format, setup));
  // Without a shortest gap there is no highest rate.
  setup.frame_gap_min = {};
  BISS_EXPECT(check_safety(format, setup) == SafetySetupError::residual);
}

// ---- The fingerprint

// Calls `visit` with every field. A struct that gets a further one does not compile here.
void each_field(SafetySetup& setup, const auto& visit) {
  const auto all = [&](auto&... fields) { (visit(fields), ...); };
  auto& [cpw, spw, start_frames, latch, comparison, counter, cycle_min, frame_gap_max,
         frame_gap_min, clocks, budget, bounds, rating, residual_max_e15] = setup;
  all(cpw, spw, start_frames, latch, cycle_min, frame_gap_max, frame_gap_min, residual_max_e15);
  auto& [compare_bits, tolerance_lsb, multiturn] = comparison;
  all(compare_bits, tolerance_lsb, multiturn);
  auto& [mode, missed, near_frames, learn_rollovers, first] = counter;
  all(mode, missed, near_frames, learn_rollovers, first);
  auto& [tolerance, still_requests, bit_period] = clocks;
  all(tolerance, still_requests, bit_period);
  auto& [faults, window] = budget;
  all(faults, window);
  auto& [lead_min, lead_max, ack_min, ack_max, late_max] = bounds;
  all(lead_min, lead_max, ack_min, ack_max, late_max);
  auto& [words, residual_e24, check] = rating;
  all(words, residual_e24, check);
}
void each_field(ChannelFormat& channel, const auto& visit) {
  const auto all = [&](auto&... fields) { (visit(fields), ...); };
  auto& [data_bits, position, multiturn, singleturn, pos_gray, mt_gray, st_gray, pos_lsb, mt_lsb,
         st_lsb, error, warning, counter, crc] = channel;
  visit(data_bits);
  // No reference can be bound to one bit.
  const auto all_flags = [&](auto&... flags) { (visit(flags), ...); };
  bool flags[6] = {pos_gray, mt_gray, st_gray, pos_lsb, mt_lsb, st_lsb};
  all_flags(flags[0], flags[1], flags[2], flags[3], flags[4], flags[5]);
  pos_gray = flags[0];
  mt_gray = flags[1];
  st_gray = flags[2];
  pos_lsb = flags[3];
  mt_lsb = flags[4];
  st_lsb = flags[5];
  for (Field* field : {&position, &multiturn, &singleturn, &counter}) {
    auto& [shift, bits] = *field;
    all(shift, bits);
  }
  for (FlagField* flag : {&error, &warning}) {
    auto& [shift, present, active_high] = *flag;
    all(shift, present, active_high);
  }
  auto& [polynomial, start, width_bits, inverted, reversed, no_flags, cds, previous] = crc;
  all(polynomial, start, width_bits);
  bool of_crc[5] = {inverted, reversed, no_flags, cds, previous};
  all_flags(of_crc[0], of_crc[1], of_crc[2], of_crc[3], of_crc[4]);
  inverted = of_crc[0];
  reversed = of_crc[1];
  no_flags = of_crc[2];
  cds = of_crc[3];
  previous = of_crc[4];
}
void each_field(FrameFormat& format, const auto& visit) {
  auto& [channels, channel_count, cds0] = format;
  for (std::size_t k = 0; k < 2; ++k) each_field(channels[k], visit);
  visit(channel_count);
  visit(cds0);
}

// Inverts a bit. \return false where the field does not have it
template <std::integral Number>
bool invert(Number& field, unsigned bit) {
  if (bit >= 8U * sizeof field) return false;
  field = static_cast<Number>(field ^ static_cast<Number>(Number{1} << bit));
  return true;
}
bool invert(bool& field, unsigned bit) {
  field = !field;
  return bit == 0;
}
bool invert(Picoseconds& field, unsigned bit) {
  if (bit >= 63) return false;
  field.count ^= std::int64_t{1} << bit;
  return true;
}
template <class Enum>
requires std::is_enum_v<Enum>
bool invert(Enum& field, unsigned bit) {
  return invert(reinterpret_cast<std::underlying_type_t<Enum>&>(field), bit);
}

// Inverts each bit of each field in turn. \return the number of fields
unsigned each_change(const auto& whole, const auto& judge) {
  unsigned fields = 0;
  for (bool more = true; more; fields += more ? 1U : 0U) {
    more = false;
    for (unsigned bit = 0; bit < 64; ++bit) {
      auto changed = whole;
      bool has_bit = false;
      unsigned at = 0;
      each_field(changed, [&](auto& field) {
        if (at++ == fields) has_bit = invert(field, bit);
      });
      if (!has_bit) continue;
      more = true;
      judge(changed, fields);
    }
  }
  return fields;
}

BISS_TEST(SafetyFingerprint, EveryFieldOfTheSetup_ChangesIt) {
  const FrameFormat format = format_of(good_text);
  const SafetySetup setup;
  const unsigned fields = each_change(setup, [&](const SafetySetup& changed, unsigned field) {
    BISS_EXPECT(SafetyFingerprint(format, changed) != SafetyFingerprint(format, setup)) << field;
    BISS_EXPECT(SafetyFingerprint(format, UnratedSafetySetup(changed)) !=
                SafetyFingerprint(format, UnratedSafetySetup(setup)))
        << field;
  });
  BISS_EXPECT_EQ(fields, 29U);
  const SafetyFingerprint unrated(format, UnratedSafetySetup(setup));
  BISS_EXPECT(unrated != SafetyFingerprint(format, setup));
  struct Own : UnratedSafetySetup {};
  BISS_EXPECT(unrated == SafetyFingerprint(format, Own()));
  BISS_EXPECT(SafetyPlan<2>(format, setup).fingerprint() == SafetyFingerprint(format, setup));
  BISS_EXPECT(SafetyPlan<2>(format, UnratedSafetySetup(setup)).fingerprint() ==
              SafetyFingerprint(format, UnratedSafetySetup(setup)));
}

BISS_TEST(SafetyFingerprint, EveryFieldOfTheFormat_ChangesIt) {
  FrameFormat format = format_of(good_text);
  // A number of channels above the room for them, too.
  for (const std::size_t channels : {std::size_t{2}, max_channels}) {
    format.channel_count = static_cast<std::uint8_t>(channels);
    const unsigned fields = each_change(format, [&](const FrameFormat& changed, unsigned field) {
      BISS_EXPECT(SafetyFingerprint(changed, {}) != SafetyFingerprint(format, {})) << field;
    });
    BISS_EXPECT_EQ(fields, 2U * 29U + 2U);
  }
}

// Whether a monitor of one setup passes its self test with the fingerprint of the other.
template <class Setup, class Expected>
bool passes_with(const Setup& setup, const Expected& expected) {
  const FrameFormat format = format_of(good_text);
  BISS_EXPECT(!check_safety(format, setup) && !check_safety(format, expected));
  SafetyMonitor<SafetyPlan<2>> monitor(SafetyPlan<2>(format, setup));
  return monitor.self_test(SafetyFingerprint(format, expected));
}

BISS_TEST(SafetySelfTest, WithTheFingerprintOfAnotherLimitOrRating_Fails) {
  const SafetySetup strict;
  SafetySetup wide;
  wide.residual_max_e15 = 2'500'000;
  SafetySetup own = rated(format_of(good_text), 1'000'000);
  for (const SafetySetup& setup : {strict, wide, own}) {
    for (const SafetySetup& expected : {strict, wide, own}) {
      const bool same = setup == expected;
      BISS_EXPECT_EQ(passes_with(setup, expected), same);
      const UnratedSafetySetup unrated(setup);
      BISS_EXPECT_EQ(passes_with(unrated, UnratedSafetySetup(expected)), same);
      BISS_EXPECT(!passes_with(unrated, expected));
      BISS_EXPECT(!passes_with(setup, UnratedSafetySetup(expected)));
    }
  }
}

// A constant expression refuses what lies outside of an array.
constexpr std::optional<SafetySetupError> mistake_of_plan(std::string_view text,
                                                          const SafetySetup& setup) {
  return SafetyPlan<2>(parse_format(text).value(), UnratedSafetySetup(setup)).mistake();
}
static_assert(!mistake_of_plan(good_text, {}));
static_assert(mistake_of_plan("pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16+pad8;cds0", {}) ==
              SafetySetupError::channels);
static_assert(mistake_of_plan(good_text, {.cpw = 200}) == SafetySetupError::channels);
static_assert(mistake_of_plan(good_text, {.spw = 255}) == SafetySetupError::channels);

// Nothing can be monitored with such a plan.
BISS_TEST(SafetyPlan, OfAMistake_GivesAMonitorThatFailsItsSelfTest) {
  const auto fails = [](std::string_view text, const SafetySetup& setup) {
    const FrameFormat format = format_of(text);
    SafetyMonitor<SafetyPlan<2>> monitor(SafetyPlan<2>(format, UnratedSafetySetup(setup)));
    return !monitor.self_test(SafetyFingerprint(format, UnratedSafetySetup(setup))) &&
           monitor.step(OneClock{}, BitView()).verdict == SafetyVerdict::self_test;
  };
  BISS_EXPECT(!fails(good_text, {}));
  BISS_EXPECT(fails("pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16+pad8;cds0", {}));
  BISS_EXPECT(fails(good_text, {.cpw = 200}));
  BISS_EXPECT(fails(good_text, {.spw = 255}));
  BISS_EXPECT(
      fails("pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0", {.comparison = {.compare_bits = 200}}));
}

// Renishaw's encoders are ready 31.25 us after the beginning of a request. Where the next one begins
// then, a cable delays the answer to that by some clocks.
BISS_TEST(SafetySetup, OfRenishawsEncoders_AcceptsTheFirstClocksOfTheNextRequest) {
  const auto bounds_at = [](Hertz clock, Picoseconds delay) {
    return with_timing({}, renishaw_timing, period_of(clock), delay).bounds;
  };
  // 1.0425 us: 100 m and the encoder. The first sample is taken half a period after the request's
  // beginning.
  BISS_EXPECT_EQ(bounds_at(megahertz(10), renishaw_line_delay_max).late_max_clocks, 10);
  BISS_EXPECT_EQ(bounds_at(megahertz(10), biss_line_delay_max).late_max_clocks, 10);
  BISS_EXPECT_EQ(bounds_at(megahertz(10), nanoseconds(242)).late_max_clocks, 2);
  BISS_EXPECT_EQ(bounds_at(megahertz(10), {}).late_max_clocks, 0);
  // ACK is at least one clock there.
  BISS_EXPECT_EQ(bounds_at(kilohertz(250), renishaw_line_delay_max).late_max_clocks, 0);
  BISS_EXPECT_EQ(with_timing({}, {}, nanoseconds(100)).bounds.late_max_clocks, 0);
  for (const SafetyConfiguration& each : safety_configurations) {
    const bool is_cycle = each.timing.timeout.rule == TimeoutRule::cycle;
    BISS_EXPECT_EQ(each.setup.bounds.late_max_clocks, is_cycle ? 10 : 0);
  }
}

BISS_TEST(SafetySetup, WithTiming_HasTheShortestCycleOfTheEncoder) {
  DeviceTiming timing = renishaw_timing;
  timing.cycle_min = microseconds(40);
  const SafetySetup setup = with_timing({}, timing, nanoseconds(100));
  BISS_EXPECT_EQ(setup.cycle_min.count, microseconds(40).count);
  BISS_EXPECT_EQ(setup.frame_gap_min.count, nanoseconds(38'750).count);
  BISS_EXPECT(!check_safety(format_of(good_text), setup));
  // A device whose cycle is not known leaves them as they are.
  BISS_EXPECT(with_timing(setup, {}, nanoseconds(100)).frame_gap_min == setup.frame_gap_min);
}

BISS_TEST(SafetySetup, WithTimingAboveTheClockOfTheEncoder_IsRefused) {
  const auto error_at = [](Picoseconds period, Hertz clock_max) {
    DeviceTiming timing = renishaw_timing;
    timing.clock_max = clock_max;
    return check_safety(format_of(good_text), with_timing({}, timing, period));
  };
  BISS_EXPECT(!error_at(nanoseconds(100), megahertz(10)));
  BISS_EXPECT(error_at(picoseconds(99'999), megahertz(10)) == SafetySetupError::bounds);
  BISS_EXPECT(error_at(nanoseconds(25), megahertz(10)) == SafetySetupError::bounds);
  BISS_EXPECT(error_at(nanoseconds(100), megahertz(5)) == SafetySetupError::bounds);
  BISS_EXPECT(!error_at(nanoseconds(200), megahertz(5)));
}

BISS_TEST(SafetyVerdicts, HaveNamesAndTellFaultsFromStates) {
  using enum SafetyVerdict;
  BISS_EXPECT(name_of(safe) == "safe" && name_of(counter_foreign) == "counter_foreign");
  BISS_EXPECT(name_of(watchdog) == "watchdog" && name_of(comparison) == "comparison");
  BISS_EXPECT(name_of(TransmissionError::corruption) == "corruption");
  BISS_EXPECT(name_of(TransmissionError::addressing) == "addressing");
  for (std::size_t i = 0; i < safety_verdict_count; ++i) {
    const SafetyVerdict verdict = verdict_of(i);
    BISS_EXPECT_EQ(index_of(verdict), i);
    BISS_EXPECT(!name_of(verdict).empty() && name_of(verdict) != "invalid");
    BISS_EXPECT_EQ(is_fault(verdict), i > 3) << i;
    const bool of_line = verdict == early || verdict == no_frame || verdict == cpw_crc ||
                         verdict == spw_crc || verdict == counter_repeated ||
                         verdict == counter_skipped || verdict == counter_backwards ||
                         verdict == counter_foreign;
    BISS_EXPECT_EQ(is_tolerable(verdict), of_line) << i;
  }
  BISS_EXPECT(name_of(SafetyVerdict{}) == "invalid" && is_fault(SafetyVerdict{}));
}

BISS_TEST(SafetyVerdicts, EveryKindOfFault_HasAMeasureThatIsAFault) {
  using enum SafetyVerdict;
  for (std::size_t i = 0; i < transmission_error_count; ++i) {
    const SafetyMeasure& measure = safety_measures[i];
    BISS_EXPECT_EQ(static_cast<std::size_t>(measure.error), i);
    BISS_EXPECT(is_fault(measure.verdict) && measure.may_be(measure.verdict));
    for (const SafetyVerdict never : {safe, starting, latched, self_test, disagreement}) {
      BISS_EXPECT(!measure.may_be(never)) << i;
    }
  }
  BISS_EXPECT(safety_measures[1].verdict == counter_repeated &&
              !safety_measures[1].may_be(spw_crc));
  BISS_EXPECT(safety_measures[0].may_be(cpw_crc) && safety_measures[3].may_be(watchdog));
}

// Any distance may be an old frame repeated, or a loss of more than the near frames between two
// requests.
BISS_TEST(SafetyVerdicts, CounterOfAnyDistance_IsARepetitionsAndALossesToo) {
  LifeCounter counter(CounterMode::count_1_63);
  for (std::uint8_t value = 60; value != 3; value = value == 63 ? 1 : value + 1) {
    counter.accept(value, 0, 2);
  }
  for (std::uint8_t value = 1; value < 64; ++value) {
    if (value == 3) continue;
    const SafetyVerdict judged = counter.judge(value, 0, {});
    BISS_EXPECT(judged != SafetyVerdict::safe);
    BISS_EXPECT(safety_measures[1].may_be(judged)) << value;
    BISS_EXPECT(safety_measures[3].may_be(judged)) << value;
  }
}

}  // namespace biss::safety_setup_test
