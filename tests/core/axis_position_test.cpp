#include "biss/axis/axis.hpp"

#include "biss/axis/scale.hpp"
#include "tests/core/test.hpp"

namespace biss::axis_position_test {

constexpr Picoseconds cycle = microseconds(100);

constexpr AxisSetup setup_for(BadCycleRule rule) {
  return {.cycle = cycle,
          .to_sampling = microseconds(3),
          .max_step = 100,
          .bad_cycles = rule,
          .trip_after = 3,
          .power_up = {}};
}
constexpr AxisSetup extrapolates = setup_for(BadCycleRule::extrapolate);
constexpr AxisSetup holds = setup_for(BadCycleRule::hold);

// An axis that is called once per cycle.
struct Bench {
  const AxisSetup& setup;
  unsigned position_bits = 12;
  Axis axis{setup, position_bits};
  Picoseconds now{};
  std::uint32_t number = 0;

  constexpr AxisPosition good(std::int64_t position, bool nE = true, bool nW = true) {
    now = wrapping_later(now, setup.cycle);
    const auto count = static_cast<std::uint64_t>(position) & low_mask(position_bits);
    axis.good({count, 0, nE, nW}, now, ++number);
    return axis.position();
  }
  constexpr AxisPosition bad(AxisCause cause = AxisCause::crc) {
    now = wrapping_later(now, setup.cycle);
    ++number;
    axis.bad(cause, now);
    return axis.position();
  }
  // Two good frames of an axis that moves by `step`.
  constexpr AxisPosition start(std::int64_t position, std::int64_t step = 0) {
    good(position - step);
    return good(position);
  }
};

BISS_TEST(Axis, FirstPosition_NeedsTwoFramesThatAgree) {
  Bench a{extrapolates};
  BISS_EXPECT_EQ(a.good(1000).state, AxisState::no_position);
  BISS_EXPECT_EQ(a.axis.position().cause, AxisCause::first);
  BISS_EXPECT_EQ(a.good(1101).state, AxisState::no_position);
  BISS_EXPECT_EQ(a.axis.position().cause, AxisCause::step);
  const AxisPosition position = a.good(1201);
  BISS_EXPECT_EQ(position.state, AxisState::measured);
  BISS_EXPECT_EQ(position.cause, AxisCause::ok);
  BISS_EXPECT_EQ(position.position, 1201);
  BISS_EXPECT_EQ(position.step, 100);
  BISS_EXPECT_EQ(position.uncertainty, 0);
  BISS_EXPECT_EQ(position.number, 3U);
}

BISS_TEST(Axis, BadCycleBetweenTheFirstTwoFrames_AllowsTwoSteps) {
  for (const std::int64_t step : {200, 201}) {
    Bench a{extrapolates};
    a.good(1000);
    a.bad();
    BISS_EXPECT_EQ(a.good(1000 + step).cause, step == 200 ? AxisCause::ok : AxisCause::step);
    BISS_EXPECT_EQ(a.axis.position().step, step == 200 ? 100 : 0);
  }
}

BISS_TEST(Axis, BadCyclesBeforeTheFirst_GiveNoPositionAndThenTrip) {
  Bench a{extrapolates};
  BISS_EXPECT_EQ(a.bad().state, AxisState::no_position);
  BISS_EXPECT_EQ(a.bad().state, AxisState::no_position);
  BISS_EXPECT_EQ(a.bad().state, AxisState::tripped);
}

// Frames that never agree are bad cycles.
BISS_TEST(Axis, FramesThatNeverAgree_Trip) {
  Bench a{extrapolates};
  for (int i = 0; i < 3; ++i) BISS_EXPECT_EQ(a.good(1000 * (i % 2)).state, AxisState::no_position);
  BISS_EXPECT_EQ(a.good(1000).state, AxisState::tripped);
}

BISS_TEST(Axis, BadCyclesInMotion_GoOnAtTheLastSpeed) {
  Bench a{extrapolates};
  a.start(-80 + 4096, -30);
  BISS_EXPECT_EQ(a.bad().position, 4096 - 110);
  const AxisPosition position = a.bad(AxisCause::no_response);
  BISS_EXPECT_EQ(position.position, 4096 - 140);
  BISS_EXPECT_EQ(position.state, AxisState::extrapolated);
  BISS_EXPECT_EQ(position.bad_in_a_row, 2);
  BISS_EXPECT_EQ(position.cause, AxisCause::no_response);
  BISS_EXPECT_EQ(position.uncertainty, 2 * (100 + 30));
  BISS_EXPECT_EQ(position.moment.count, (cycle * std::int64_t{4} + microseconds(3)).count);
  BISS_EXPECT_EQ(position.number, 2U);
}

BISS_TEST(Axis, HoldRule_KeepsTheLastMeasuredPosition) {
  Bench a{holds};
  a.start(20, 10);
  a.bad();
  const AxisPosition position = a.bad();
  BISS_EXPECT_EQ(position.state, AxisState::held);
  BISS_EXPECT_EQ(position.position, 20);
  BISS_EXPECT_EQ(position.uncertainty, 200);
  BISS_EXPECT_EQ(position.moment.count, (cycle * std::int64_t{2} + microseconds(3)).count);
  BISS_EXPECT_EQ(position.age(cycle * std::int64_t{5}).count,
                 (cycle * std::int64_t{3} - microseconds(3)).count);
}

BISS_TEST(Axis, GoodFrameAfterAGap_MeasuresTheSpeedOverTheGap) {
  for (const std::int64_t way : {1, -1}) {
    Bench a{extrapolates};
    a.start(2000, way * 10);
    a.bad();
    a.bad();
    BISS_EXPECT_EQ(a.good(2000 + way * 61).state, AxisState::measured);
    BISS_EXPECT_EQ(a.axis.position().step, way * 20);
    BISS_EXPECT_EQ(a.bad().position, 2000 + way * 81);
  }
}

BISS_TEST(Axis, TripRule_TripsAtOnce) {
  constexpr AxisSetup trips = setup_for(BadCycleRule::trip);
  Bench a{trips};
  a.start(10);
  BISS_EXPECT_EQ(a.bad().state, AxisState::tripped);
}

BISS_TEST(Axis, AfterATrip_TheCauseStaysUntilReset) {
  Bench a{holds};
  a.start(10);
  for (const AxisCause cause : {AxisCause::crc, AxisCause::crc, AxisCause::late}) a.bad(cause);
  a.bad(AxisCause::no_response);
  const AxisPosition position = a.good(11);
  BISS_EXPECT_EQ(position.state, AxisState::tripped);
  BISS_EXPECT_EQ(position.cause, AxisCause::late);
  BISS_EXPECT_EQ(position.position, 10);
  BISS_EXPECT_EQ(position.uncertainty, std::numeric_limits<std::int64_t>::max());
  BISS_EXPECT(!position.usable());
  BISS_EXPECT_EQ(a.axis.counts()[AxisCause::no_response], 1U);
  BISS_EXPECT_EQ(a.axis.counts()[AxisCause::tripped], 1U);
  a.axis.reset();
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::no_position);
  BISS_EXPECT_EQ(a.start(500).state, AxisState::measured);
  BISS_EXPECT_EQ(a.axis.counts()[AxisCause::crc], 2U);
}

BISS_TEST(Axis, TripByTheCaller_HoldsTheDrive) {
  Bench a{holds};
  a.start(10);
  a.axis.trip();
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::tripped);
  BISS_EXPECT_EQ(a.axis.position().cause, AxisCause::tripped);
}

BISS_TEST(Axis, StepBeyondTheLimit_IsABadCycleEitherWay) {
  Bench a{holds};
  a.start(0);
  BISS_EXPECT_EQ(a.good(100).state, AxisState::measured);
  BISS_EXPECT_EQ(a.good(201).cause, AxisCause::step);
  BISS_EXPECT_EQ(a.good(-101).cause, AxisCause::step);
  BISS_EXPECT_EQ(a.good(400).position, 400);
}

BISS_TEST(Axis, StepAfterAGap_MayBeTheLimitForEachCycle) {
  for (const std::int64_t step : {200, 201, -200, -201}) {
    Bench a{holds};
    a.start(1000);
    a.bad();
    const bool allowed = step == 200 || step == -200;
    BISS_EXPECT_EQ(a.good(1000 + step).state, allowed ? AxisState::measured : AxisState::held)
        << step;
  }
}

BISS_TEST(Axis, ErrorBit_IsABadCycle) {
  Bench a{holds};
  a.start(10);
  BISS_EXPECT_EQ(a.good(12, false).cause, AxisCause::error_bit);
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::held);
  BISS_EXPECT_EQ(a.axis.position().position, 10);
}

BISS_TEST(Axis, Warning_FollowsItsRule) {
  AxisSetup setup = holds;
  for (const WarningRule rule : {WarningRule::measure, WarningRule::bad, WarningRule::trip}) {
    setup.warnings = rule;
    Bench a{setup};
    a.start(10);
    const AxisPosition position = a.good(12, true, false);
    BISS_EXPECT_EQ(position.cause, AxisCause::warning);
    BISS_EXPECT_EQ(a.axis.counts()[AxisCause::warning], 1U);
    constexpr AxisState states[] = {AxisState::measured, AxisState::held, AxisState::tripped};
    BISS_EXPECT_EQ(position.state, states[static_cast<std::size_t>(rule)]);
  }
}

BISS_TEST(Axis, Turns_AreCountedBothWaysAndCanBeSet) {
  Bench a{holds};
  a.start(4090, 5);
  BISS_EXPECT_EQ(a.good(4097).position, 4097);
  BISS_EXPECT_EQ(a.axis.turns(), 1);
  a.good(4090);
  BISS_EXPECT_EQ(a.axis.turns(), 0);
  for (int i = 0; i < 50; ++i) a.good(4090 - i * 100);
  BISS_EXPECT_EQ(a.axis.position().position, 4090 - 4900);
  BISS_EXPECT_EQ(a.axis.turns(), -1);
  BISS_EXPECT(a.axis.set_turns(-7));
  BISS_EXPECT_EQ(a.axis.position().position, 4090 - 4900 - 6 * 4096);
  BISS_EXPECT_EQ(a.good(4090 - 4800).position, 4090 - 4800 - 6 * 4096);
  BISS_EXPECT(!a.axis.set_turns(std::int64_t{1} << 50U));
  BISS_EXPECT(!a.axis.set_turns(std::numeric_limits<std::int64_t>::min()));
  BISS_EXPECT_EQ(a.axis.turns(), -7);
  BISS_EXPECT(!Bench{holds}.axis.set_turns(1));
}

// 30 cycles without a frame: 41 × 100 counts are more than half a turn of 4096.
BISS_TEST(Axis, GapInWhichHalfATurnIsPossible_LosesTheTurns) {
  AxisSetup setup = holds;
  setup.trip_after = 50;
  for (const int gap : {18, 19, 20}) {
    Bench a{setup};
    a.start(1000);
    for (int i = 0; i < gap; ++i) a.bad();
    const AxisPosition position = a.good(1000);
    BISS_EXPECT_EQ(position.cause, gap < 20 ? AxisCause::ok : AxisCause::turns) << gap;
    BISS_EXPECT_EQ(position.uncertainty, gap < 20 ? 0 : 2100);
  }
}

BISS_TEST(Axis, DirectionAndOffset_ApplyToPositionAndSpeed) {
  AxisSetup setup = extrapolates;
  setup.reversed = true;
  setup.offset = 5000;
  Bench a{setup};
  a.start(1000, 10);
  BISS_EXPECT_EQ(a.axis.position().position, 4000);
  BISS_EXPECT_EQ(a.axis.position().step, -10);
  BISS_EXPECT_EQ(a.bad().position, 3990);
}

// ---- Time

// The control interrupt of two cycles was lost.
BISS_TEST(Axis, CyclesWithoutARequest_CountInSpeedLimitAndUncertainty) {
  Bench a{extrapolates};
  a.start(1000, 10);
  a.now += cycle * std::int64_t{2};
  BISS_EXPECT_EQ(a.good(1030).step, 10);
  a.now += cycle;
  const AxisPosition position = a.bad();
  BISS_EXPECT_EQ(position.position, 1050);
  BISS_EXPECT_EQ(position.uncertainty, 2 * 110);
  a.now += cycle;
  BISS_EXPECT_EQ(a.bad().state, AxisState::tripped);
}

BISS_TEST(Axis, RequestThatIsLate_IsOneCycleUpToAnEighth) {
  for (const std::int64_t late_ns : {0, 12'500, 12'501, 112'500, 112'501}) {
    Bench a{holds};
    a.start(1000);
    a.now += nanoseconds(late_ns);
    const std::int64_t cycles = late_ns > 112'500 ? 3 : late_ns > 12'500 ? 2 : 1;
    const AxisPosition position = a.bad();
    const std::int64_t all = std::numeric_limits<std::int64_t>::max();  // tripped
    BISS_EXPECT_EQ(position.uncertainty, cycles < 3 ? cycles * 100 : all) << late_ns;
  }
}

BISS_TEST(Axis, RequestWithinAnEighthOfACycle_IsMeasuredAndEarly) {
  for (const Picoseconds passed : {Picoseconds{}, cycle / 8 - picoseconds(1), cycle / 8, cycle / 2,
                                   cycle + cycle / 8, cycle + cycle / 8 + picoseconds(1)}) {
    Bench a{extrapolates};
    a.start(1000, 50);
    const Picoseconds before = a.now;
    a.now = before - cycle + passed;
    const AxisPosition position = a.good(1040);
    BISS_EXPECT_EQ(position.state, AxisState::measured);
    BISS_EXPECT_EQ(position.cause, passed < cycle / 8 ? AxisCause::early : AxisCause::ok);
    BISS_EXPECT_EQ(position.position, 1040);
    BISS_EXPECT_EQ(position.step, passed > cycle + cycle / 8 ? 20 : 40);
    a.now = a.now - cycle;
    BISS_EXPECT_EQ(a.good(1141).cause, AxisCause::step);
  }
}

BISS_TEST(Axis, EarlyRequests_NeverTripAndNeverHideAWarning) {
  Bench a{extrapolates};
  a.good(1000);
  for (unsigned i = 0; i < 100; ++i) {
    a.now = a.now - cycle + cycle / 1000;
    BISS_EXPECT_EQ(a.good(1000).cause, AxisCause::early);
  }
  BISS_EXPECT_EQ(a.axis.counts()[AxisCause::early], 100U);
  a.now = a.now - cycle;
  BISS_EXPECT_EQ(a.good(1000, true, false).cause, AxisCause::warning);
  BISS_EXPECT_EQ(a.axis.position().state, AxisState::measured);
}

BISS_TEST(Axis, GapsOfAnyLength_HaveTheirNumberOfCycles) {
  AxisSetup setup = holds;
  setup.trip_after = 0xFFFF;
  setup.max_step = 1;
  BISS_RANDOM(random, 0xB155'9A95);
  for (std::uint64_t i = 0; i < test::rounds(20'000, 500); ++i) {
    Bench a{setup, 40};
    a.start(1000);
    const std::int64_t cycles = 1 + random.below(i % 2 != 0 ? 20 : 65'000);
    a.now += cycle * (cycles - 1);
    BISS_EXPECT_EQ(a.bad().uncertainty, cycles);
  }
  for (const std::int64_t days : {1, 107, 200}) {
    Bench a{setup, 40};
    a.start(1000);
    a.now = wrapping_later(a.now, milliseconds(43'200'000) * days);
    a.now = wrapping_later(a.now, milliseconds(43'200'000) * days);
    BISS_EXPECT_EQ(a.bad().state, AxisState::tripped) << days;
  }
}

BISS_TEST(Axis, PowerUp_EndsWithItsTimeOrTheFirstPosition) {
  AxisSetup setup = holds;
  setup.power_up = milliseconds(1);
  for (const bool wraps : {false, true}) {
    Bench a{setup};
    if (wraps) a.now = Picoseconds{std::numeric_limits<std::int64_t>::max() - 5};
    for (int i = 0; i < 10; ++i) BISS_EXPECT_EQ(a.bad().state, AxisState::no_position) << i;
    BISS_EXPECT_EQ(a.bad().state, AxisState::tripped);
  }
  Bench a{setup};
  a.start(1000);
  a.bad();
  a.bad();
  BISS_EXPECT_EQ(a.bad().state, AxisState::tripped);
}

// The numbers of requests wrap around.
BISS_TEST(Axis, AnyNumberOfARequest_HasAPosition) {
  Bench a{holds};
  a.start(1000);
  a.number = 0xFFFF'FFFE;
  for (int i = 0; i < 3; ++i) {
    BISS_EXPECT_EQ(a.good(1010).position, 1010);
    BISS_EXPECT_EQ(a.axis.position().uncertainty, 0);
  }
  BISS_EXPECT_EQ(a.bad().position, 1010);
}

// More cycles than are counted: a whole turn may have passed.
BISS_TEST(Axis, VeryLongGapAndClockThatJumpsBack_LoseTheTurns) {
  for (const bool back : {false, true}) {
    Bench a{holds, 40};
    a.start(1000);
    a.now += back ? microseconds(-500) : cycle * std::int64_t{80'000};
    BISS_EXPECT_EQ(a.good(1000).cause, AxisCause::turns);
  }
}

// The end of a transfer that was late comes after the bad cycle of the request after it.
BISS_TEST(Axis, BadEndOfALateTransfer_LeavesTheUncertaintyOfTheLaterCycle) {
  Bench a{holds};
  a.start(1000);
  const Picoseconds asked = a.now + cycle;
  a.now = asked;
  BISS_EXPECT_EQ(a.bad(AxisCause::late).uncertainty, 200);
  a.axis.bad(AxisCause::crc, asked);
  BISS_EXPECT_EQ(a.axis.position().uncertainty, 200);
}

// The same before the first position: the axis still powers up.
BISS_TEST(Axis, BadEndOfAFirstLateTransfer_DoesNotTrip) {
  AxisSetup setup = holds;
  setup.power_up = milliseconds(1);
  setup.trip_after = 1;
  Bench a{setup};
  BISS_EXPECT_EQ(a.bad(AxisCause::late).state, AxisState::no_position);
  a.axis.bad(AxisCause::no_response, a.now - cycle);
  BISS_EXPECT_EQ(a.axis.state(), AxisState::no_position);
}

// The time of the first request is any number.
BISS_TEST(Axis, FirstRequestAtTheEndOfTime_IsJudged) {
  Bench a{extrapolates};
  a.axis.bad(AxisCause::crc, Picoseconds{std::numeric_limits<std::int64_t>::min()});
  BISS_EXPECT_EQ(a.axis.state(), AxisState::no_position);
}

BISS_TEST(Axis, SecondRequestAfterMonths_IsNotInTheTimeToPowerUp) {
  AxisSetup setup = holds;
  setup.power_up = milliseconds(1'000);
  for (const std::int64_t days : {1, 106, 107, 200, 213}) {
    Bench a{setup};
    a.bad();
    for (std::int64_t i = 0; i < days; ++i) {
      a.now = wrapping_later(a.now, milliseconds(86'400'000));
    }
    a.bad();
    BISS_EXPECT_EQ(a.bad().state, AxisState::tripped) << days;
  }
}

BISS_TEST(Axis, LostControlInterruptBetweenTheFirstFrames_CountsAsACycle) {
  Bench a{extrapolates};
  a.good(1000);
  a.now += cycle;
  BISS_EXPECT_EQ(a.good(1200).state, AxisState::measured);
  BISS_EXPECT_EQ(a.axis.position().step, 100);
}

BISS_TEST(Axis, AfterATrip_NothingReplacesItsCause) {
  Bench a{holds};
  a.start(10);
  for (int i = 0; i < 3; ++i) a.bad();
  a.axis.trip();
  BISS_EXPECT_EQ(a.axis.position().cause, AxisCause::crc);
  BISS_EXPECT_EQ(a.axis.counts()[AxisCause::tripped], 0U);
  a.good(10, false);
  BISS_EXPECT_EQ(a.axis.counts()[AxisCause::error_bit], 1U);
  Bench never{holds};
  never.axis.trip();
  BISS_EXPECT(!never.axis.set_turns(1));
}

// ---- The ends of the range

constexpr AxisSetup unlimited{.cycle = cycle,
                              .to_sampling = microseconds(3),
                              .max_step = no_step_limit,
                              .trip_after = 9,
                              .power_up = {}};

BISS_TEST(Axis, PositionsAtTheEndOfTheRange_AreNeverWrong) {
  Bench a{unlimited, 62};
  const std::int64_t half = std::int64_t{1} << 61U;
  a.start(half + half / 2);
  for (int i = 0; i < 100; ++i) {
    const AxisPosition before = a.axis.position();
    const AxisPosition position = a.good(before.position + half / 3);
    if (position.state != AxisState::measured) {
      BISS_EXPECT_EQ(position.cause, AxisCause::turns);
      BISS_EXPECT(before.position + half / 3 >= axis_position_max);
      break;
    }
    BISS_EXPECT_EQ(position.position, before.position + half / 3);
  }
  BISS_EXPECT(a.axis.counts()[AxisCause::turns] > 0);
  BISS_EXPECT_EQ(a.bad().state, AxisState::held);  // beyond the range
}

BISS_TEST(Axis, TurnsThatAnExtrapolationCannotHave_AreRefused) {
  Bench a{unlimited, 60};
  a.start(std::int64_t{1} << 59U, (std::int64_t{1} << 59U) - 1);
  for (int i = 0; i < 4; ++i) a.bad();
  const AxisPosition before = a.axis.position();
  BISS_EXPECT_EQ(before.state, AxisState::extrapolated);
  BISS_EXPECT(!a.axis.set_turns(3));
  BISS_EXPECT_EQ(a.axis.position().position, before.position);
  BISS_EXPECT(a.axis.set_turns(-1));
}

BISS_TEST(Axis, UncertaintyThatDoesNotFit_IsTheLargest) {
  Bench a{unlimited, 62};
  a.start(std::int64_t{1} << 60U);
  BISS_EXPECT_EQ(a.bad().uncertainty, (std::int64_t{1} << 61U) - 1);
  for (int i = 0; i < 4; ++i) a.bad();
  BISS_EXPECT_EQ(a.axis.position().uncertainty, std::numeric_limits<std::int64_t>::max());
}

BISS_TEST(Axis, SetupThatCannotWork_HasItsCause) {
  const auto error = [](auto change, unsigned bits = 12) {
    AxisSetup setup = holds;
    change(setup);
    return check_axis(setup, bits);
  };
  const auto nothing = [](AxisSetup&) {};
  BISS_EXPECT(!error(nothing));
  BISS_EXPECT(error(nothing, 0) == AxisError::format);
  BISS_EXPECT(error(nothing, 63) == AxisError::format);
  BISS_EXPECT(error([](AxisSetup& s) { s.cycle = {}; }) == AxisError::cycle);
  BISS_EXPECT(error([](AxisSetup& s) { s.cycle = axis_cycle_max + Picoseconds{1}; }) ==
              AxisError::cycle);
  BISS_EXPECT(error([](AxisSetup& s) { s.to_sampling = {}; }) == AxisError::cycle);
  BISS_EXPECT(error([](AxisSetup& s) { s.max_step = 0; }) == AxisError::max_step);
  BISS_EXPECT(error([](AxisSetup& s) { s.max_step = 2048; }) == AxisError::max_step);
  BISS_EXPECT(!error([](AxisSetup& s) { s.max_step = 2047; }));
  BISS_EXPECT(error([](AxisSetup& s) { s.offset = axis_position_max; }) == AxisError::offset);
  BISS_EXPECT(!error([](AxisSetup& s) { s.offset = 1 - axis_position_max; }));
}

// ---- The table of the states

// Every step of an axis on random input is one of the table.
BISS_TEST(Axis, EveryStep_IsInTheTable) {
  BISS_RANDOM(random, 0xB155'57A7);
  std::array<std::array<bool, 5>, 5> seen{};
  for (std::uint64_t round = 0; round < test::rounds(2'000, 100); ++round) {
    AxisSetup setup = setup_for(static_cast<BadCycleRule>(random.below(3)));
    setup.power_up = cycle * std::int64_t{random.below(10)};
    Bench a{setup};
    for (int i = 0; i < 40; ++i) {
      const AxisState before = a.axis.state();
      switch (random.below(12)) {
        case 0:
          a.axis.reset();
          break;
        case 1:
          if (random.below(4) == 0) a.axis.trip();
          break;
        case 2:
        case 3:
          a.bad();
          break;
        default:
          a.good(random.below(8) == 0 ? 1000 : 10);
      }
      const AxisState after = a.axis.state();
      seen[static_cast<std::size_t>(before)][static_cast<std::size_t>(after)] = true;
      const auto& row = axis_states[static_cast<std::size_t>(before)];
      BISS_EXPECT(before == after || std::find(row.begin(), row.end(), after) != row.end());
    }
  }
  for (std::size_t from = 0; from < 5; ++from) {
    for (const AxisState to : axis_states[from]) {
      // Only at the end of the range an axis that extrapolates has to hold.
      const bool rare =
          (from == 2 && to == AxisState::extrapolated) || (from == 3 && to == AxisState::held);
      if (rare) continue;
      BISS_EXPECT(seen[from][static_cast<std::size_t>(to)]) << from << " " << int(to);
    }
  }
}

// ---- Units

static_assert(*AxisScale{360'000'000, 1 << 26}(1 << 26) == 360'000'000);
static_assert(*AxisScale{1, 2}(1) == 1 && *AxisScale{1, 2}(-1) == 0 && *AxisScale{1, 2}(-3) == -1);
static_assert(!AxisScale{0, 1}(1) && !AxisScale{1, 0}(1) && !AxisScale{1, -1}(1));

BISS_TEST(AxisScale, AnyScale_RoundsToTheNearest) {
  BISS_RANDOM(random, 0xB155'5CA1);
  for (std::uint64_t i = 0; i < test::rounds(100'000, 2'000); ++i) {
    const auto numerator = static_cast<std::int32_t>(1 + random.bits(1 + random.below(30)));
    const auto denominator = static_cast<std::int32_t>(1 + random.bits(1 + random.below(30)));
    const auto counts = static_cast<std::int64_t>(random.next()) >> (1 + random.below(62));
    const auto scaled = AxisScale{numerator, denominator}(counts);
    // The error of the result, in units of 1 / denominator, fits 64 bits if nothing wrapped around.
    const auto error = static_cast<std::int64_t>(
        static_cast<std::uint64_t>(counts) * static_cast<std::uint64_t>(std::int64_t{numerator}) -
        static_cast<std::uint64_t>(scaled.value_or(0)) *
            static_cast<std::uint64_t>(std::int64_t{denominator}));
    const bool nearest = error <= denominator / 2 && error >= -((denominator + 1) / 2);
    constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
    const bool too_large = axis_detail::magnitude(counts) / denominator > most / numerator / 2;
    BISS_EXPECT(scaled ? nearest : too_large);
  }
}

}  // namespace biss::axis_position_test
