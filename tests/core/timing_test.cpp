#include "biss/frame/frame.hpp"
#include "biss/timing/cable.hpp"
#include "biss/timing/cycle.hpp"
#include "biss/timing/device_timing.hpp"
#include "biss/timing/step.hpp"
#include "tests/core/test.hpp"

namespace biss::timing_test {

constexpr DeviceTiming renishaw{
    .clock_min = kilohertz(250),
    .clock_max = megahertz(10),
    .start_min = nanoseconds(3'225),
    .ack_max = microseconds(16),
    .timeout = {TimeoutRule::cycle, nanoseconds(31'250)},
    .internal_delay_max = picoseconds(42'500),
    .cycle_min = nanoseconds(31'250),
};
constexpr Picoseconds internal = renishaw.internal_delay_max;

/// The time of the frame alone, as in the published figures.
constexpr Picoseconds frame_time(unsigned payload_bits, Hertz clock) {
  const CycleBudget budget = cycle_budget({payload_bits}, renishaw, clock, {});
  return budget.total - budget.timeout - budget.idle;
}

constexpr unsigned plain(unsigned position_bits) { return position_bits + 2 + 6; }
constexpr unsigned safety(unsigned cpw_bits, unsigned spw_bits) {
  return cpw_bits + 2 + 6 + spw_bits + 2 + 6 + 16;
}

static_assert(frame_time(plain(18), megahertz(10)) == nanoseconds(19'100));
static_assert(AckBounds{}.max_clocks == FrameBounds{}.ack_max_clocks);
static_assert(cable_max_uncompensated(megahertz(1), internal) == metres(20));

BISS_TEST(Cycle, RenishawPlainWords_TakeThePublishedTimes) {
  struct Row {
    Hertz clock;
    Picoseconds shortest;  // 18 bit
    Picoseconds longest;   // 36 bit
  };
  constexpr std::array rows{
      Row{megahertz(10), nanoseconds(19'100), nanoseconds(20'900)},
      Row{megahertz(5), nanoseconds(22'200), nanoseconds(25'800)},
      Row{megahertz(2), nanoseconds(31'500), nanoseconds(40'500)},
      Row{megahertz(1), nanoseconds(47'000), nanoseconds(65'000)},
  };
  for (const Row& row : rows) {
    BISS_EXPECT_EQ(frame_time(plain(18), row.clock).count, row.shortest.count);
    BISS_EXPECT_EQ(frame_time(plain(36), row.clock).count, row.longest.count);
  }
}

BISS_TEST(Cycle, RenishawSafetyWords_TakeThePublishedTimes) {
  BISS_EXPECT_EQ(frame_time(safety(36, 28), megahertz(10)).count, 26'100'000);
  BISS_EXPECT_EQ(frame_time(safety(32, 32), megahertz(10)).count, 26'100'000);
  BISS_EXPECT_EQ(frame_time(safety(36, 28), megahertz(5)).count, 36'200'000);
  BISS_EXPECT_EQ(frame_time(safety(32, 32), megahertz(5)).count, 36'200'000);
  BISS_EXPECT_EQ(frame_time(safety(28, 24), megahertz(5)).count, 33'800'000);
}

BISS_TEST(Cycle, Renishaw_Reaches32kHzWhereTheFrameFits) {
  const auto feasible = [](unsigned bits, Hertz clock) {
    return is_feasible(cycle_budget({bits}, renishaw, clock, {}), kilohertz(32));
  };
  BISS_EXPECT(feasible(plain(36), megahertz(10)));
  BISS_EXPECT(feasible(plain(36), megahertz(5)));
  BISS_EXPECT(!feasible(plain(18), megahertz(2)));
  BISS_EXPECT(!feasible(plain(18), megahertz(1)));
  BISS_EXPECT(feasible(safety(36, 28), megahertz(10)));
  BISS_EXPECT(!feasible(safety(28, 24), megahertz(5)));
}

BISS_TEST(Cycle, CycleRule_FillsUpToItsTimeAndThenIsTheRelease) {
  const CycleBudget fast = cycle_budget({plain(26)}, renishaw, megahertz(10), {});
  BISS_EXPECT_EQ(fast.total.count, 31'250'000);
  BISS_EXPECT_EQ(fast.timeout.count, 31'250'000 - 19'900'000);
  BISS_EXPECT_EQ(fast.request_rate_max.count, 32'000);
  const CycleBudget slow = cycle_budget({plain(26)}, renishaw, megahertz(1), {});
  // SLO low for 1.5 periods, so that STOP can be read.
  BISS_EXPECT_EQ(slow.timeout.count, 1'500'000);
  BISS_EXPECT_EQ(slow.total.count, 56'500'000);
  BISS_EXPECT_EQ(slow.request_rate_max.count, 17'699);
  DeviceTiming other = renishaw;
  other.timeout.release_half_periods = 8;
  BISS_EXPECT_EQ(cycle_budget({plain(26)}, other, megahertz(1), {}).total.count, 59'000'000);
  // A frame of 31.2 us leaves no time to read STOP within the cycle.
  BISS_EXPECT_EQ(cycle_budget({147}, renishaw, megahertz(10), {}).total.count, 31'350'000);
}

BISS_TEST(Cycle, Parts_AddUpToTheTotal) {
  const DeviceTiming slow{.ack_max = nanoseconds(1'250),
                          .timeout = {TimeoutRule::fixed, microseconds(20)},
                          .cycle_min = microseconds(50)};
  for (const DeviceTiming& timing : {renishaw, DeviceTiming{}, slow}) {
    for (const std::uint32_t clock : {80'000U, 333'333U, 2'270'000U, 10'000'000U}) {
      const CycleBudget b = cycle_budget({34}, timing, hertz(clock), nanoseconds(542));
      BISS_EXPECT_EQ(b.total.count, (b.lat + b.ack + b.start_cds + b.payload + b.stop +
                                     b.line_delay + b.timeout + b.idle)
                                        .count)
          << "at " << clock;
      BISS_EXPECT(b.total >= timing.cycle_min);
      BISS_EXPECT(b.lat + b.ack + b.start_cds + b.payload + b.stop == b.frame_clocks * b.period);
    }
  }
}

BISS_TEST(Cycle, AckFixedInClocks_TakesJustThose) {
  // Lenz: 4 clocks of ACK, at most 13.2 µs of timeout, 32 bits at 5 MHz.
  const DeviceTiming lenz{.ack_clocks = 4, .timeout = {TimeoutRule::fixed, nanoseconds(13'200)}};
  const CycleBudget budget = cycle_budget({32}, lenz, megahertz(5), {});
  BISS_EXPECT_EQ(budget.ack.count, 800'000);
  BISS_EXPECT_EQ(budget.frame_clocks, 1 + 4 + 2 + 32 + 1);
  BISS_EXPECT_EQ(budget.total.count, 8'000'000 + 13'200'000);
  BISS_EXPECT_EQ(budget.request_rate_max.count, 47'169);
}

BISS_TEST(Cycle, Chain_TakesOneClockMoreForEachFurtherSlave) {
  const CycleBudget one = cycle_budget({96, 1}, {}, megahertz(1), {});
  const CycleBudget three = cycle_budget({96, 3}, {}, megahertz(1), {});
  BISS_EXPECT_EQ(three.frame_clocks - one.frame_clocks, 2);
  BISS_EXPECT_EQ((three.total - one.total).count, 2'000'000);
  BISS_EXPECT_EQ(cycle_budget({96, 0}, {}, megahertz(1), {}).frame_clocks, one.frame_clocks);
}

BISS_TEST(Cycle, LineDelay_CostsTimeAndWholeClocks) {
  const CycleBudget near = cycle_budget({34}, {}, megahertz(10), {});
  const CycleBudget far = cycle_budget({34}, {}, megahertz(10), nanoseconds(501));
  BISS_EXPECT_EQ(near.clocks_to_send, near.frame_clocks);
  BISS_EXPECT_EQ(far.clocks_to_send, far.frame_clocks + 6);
  BISS_EXPECT_EQ((far.total - near.total).count, 600'000);
}

BISS_TEST(Cycle, ProcessingTimeBetweenClocks_IsRoundedUp) {
  const DeviceTiming timing{.ack_max = nanoseconds(101), .timeout = {TimeoutRule::adaptive, {}}};
  const CycleBudget budget = cycle_budget({34}, timing, megahertz(10), {});
  BISS_EXPECT_EQ(budget.ack.count, 300'000);
  BISS_EXPECT_EQ(budget.timeout.count, 200'000);
}

BISS_TEST(Cycle, LongerThanASecond_HasNoWholeRate) {
  const CycleBudget budget = cycle_budget({34}, {}, hertz(1), {});
  BISS_EXPECT_EQ(budget.request_rate_max.count, 0);
  BISS_EXPECT(!is_feasible(budget, hertz(1)));
}

BISS_TEST(Timeout, EachRule_CountsFromItsOwnStart) {
  const Picoseconds period = nanoseconds(440);
  // iC-MHM at 2.27 MHz: 1.32 µs measured.
  BISS_EXPECT_EQ(
      timeout_after({TimeoutRule::adaptive, nanoseconds(660)}, period, microseconds(9)).count,
      1'320'000);
  BISS_EXPECT_EQ(timeout_after({TimeoutRule::adaptive, {}}, period, {}).count, 880'000);
  BISS_EXPECT_EQ(
      timeout_after({TimeoutRule::fixed, microseconds(20)}, period, microseconds(9)).count,
      46 * 440'000);
  const Timeout cycle{TimeoutRule::cycle, nanoseconds(31'250)};
  BISS_EXPECT_EQ(timeout_after(cycle, period, microseconds(9)).count, 22'250'000);
  BISS_EXPECT_EQ(timeout_after(cycle, period, nanoseconds(31'250)).count, 660'000);
  BISS_EXPECT_EQ(timeout_after(cycle, period, microseconds(60)).count, 660'000);
  BISS_EXPECT_EQ(release_time({TimeoutRule::cycle, {}, 5}, picoseconds(3)).count, 8);
}

BISS_TEST(DeviceTiming, Clock_IsAcceptedWithinItsBounds) {
  BISS_EXPECT(!accepts_clock(renishaw, hertz(249'999)));
  BISS_EXPECT(accepts_clock(renishaw, kilohertz(250)));
  BISS_EXPECT(accepts_clock(renishaw, megahertz(10)));
  BISS_EXPECT(!accepts_clock(renishaw, hertz(10'000'001)));
}

BISS_TEST(AckBounds, FollowTheDeviceAndStayWithinTheProtocol) {
  BISS_EXPECT(ack_bounds(renishaw, nanoseconds(100)) == AckBounds{32, 160});
  BISS_EXPECT(ack_bounds(renishaw, microseconds(4)) == AckBounds{1, 4});
  BISS_EXPECT(ack_bounds({}, nanoseconds(100)) == AckBounds{1, 400});
  BISS_EXPECT(ack_bounds({}, nanoseconds(80)) == AckBounds{1, 400});
  BISS_EXPECT(ack_bounds({.ack_max = {}}, nanoseconds(100)) == AckBounds{1, 1});
  BISS_EXPECT(ack_bounds({.ack_clocks = 4}, nanoseconds(200)) == AckBounds{4, 4});
}

BISS_TEST(Cable, WithoutCompensation_IsTheDataSheetsTable) {
  struct Row {
    std::uint32_t hertz;
    std::int64_t millimetres;
  };
  constexpr std::array rows{Row{250'000, 95'000},  Row{1'000'000, 20'000}, Row{1'500'000, 12'000},
                            Row{2'000'000, 8'000}, Row{3'000'000, 4'000},  Row{4'000'000, 2'000},
                            Row{5'000'000, 500}};
  for (const Row& row : rows) {
    const auto longest = cable_max_uncompensated(hertz(row.hertz), internal);
    BISS_ASSERT(longest.has_value()) << "at " << row.hertz;
    BISS_EXPECT_EQ(longest->count, row.millimetres) << "at " << row.hertz;
    BISS_EXPECT(!needs_compensation(hertz(row.hertz), *longest, internal));
    BISS_EXPECT(needs_compensation(hertz(row.hertz), millimetres(longest->count + 1), internal));
  }
  BISS_EXPECT(!cable_max_uncompensated(megahertz(10), internal).has_value());
  BISS_EXPECT(needs_compensation(megahertz(10), {}, internal));
}

BISS_TEST(Cable, WithoutCompensation_NeverBeatsTheCableItself) {
  BISS_EXPECT(cable_max_uncompensated(kilohertz(80), internal) == metres(100));
  // The encoder uses a quarter of the period, or more.
  BISS_EXPECT(!cable_max_uncompensated(megahertz(1), nanoseconds(246)).has_value());
  BISS_EXPECT(!cable_max_uncompensated(megahertz(1), nanoseconds(251)).has_value());
  BISS_EXPECT(cable_max_uncompensated(megahertz(1), nanoseconds(245)) == millimetres(500));
  BISS_EXPECT(cable_max_uncompensated(megahertz(1), nanoseconds(240)) == metres(1));
}

BISS_TEST(Cable, WithCompensation_Is100mUpTo5MHzAnd50mUpTo10MHz) {
  BISS_EXPECT(cable_max_compensated(kilohertz(250)) == metres(100));
  BISS_EXPECT(cable_max_compensated(megahertz(5)) == metres(100));
  BISS_EXPECT(cable_max_compensated(hertz(5'000'001)) == metres(50));
  BISS_EXPECT(cable_max_compensated(megahertz(10)) == metres(50));
  BISS_EXPECT(!cable_max_compensated(hertz(10'000'001)).has_value());
  BISS_EXPECT(!cable_max_uncompensated(hertz(10'000'001), {}).has_value());
}

BISS_TEST(Cable, DataSheet_HasFiveClocks) {
  unsigned published = 0;
  for (std::uint32_t kilo = 10; kilo <= 12'000; kilo += 10) {
    if (is_published_clock(kilohertz(kilo))) ++published;
  }
  BISS_EXPECT_EQ(published, 5U);
  for (const Hertz clock :
       {kilohertz(250), megahertz(1), megahertz(2), megahertz(5), megahertz(10)}) {
    BISS_EXPECT(is_published_clock(clock));
  }
}

BISS_TEST(Cable, DelayOfTheMaster_ShortensTheCable) {
  const Picoseconds master = nanoseconds(30);
  BISS_EXPECT_EQ(line_delay(metres(50), internal + master).count, 572'500);
  BISS_EXPECT(cable_max_uncompensated(megahertz(1), internal + master) == metres(17));
  BISS_EXPECT(!cable_max_uncompensated(megahertz(5), internal + master).has_value());
}

BISS_TEST(Cable, Margin_ShrinksWithTheDelayAndGoesBelowZero) {
  BISS_EXPECT_EQ(line_delay(metres(50), internal).count, 542'500);
  BISS_EXPECT_EQ(margin_uncompensated(megahertz(1), nanoseconds(200)).count, 300'000);
  BISS_EXPECT_EQ(margin_uncompensated(megahertz(10), nanoseconds(542)).count, -492'000);
  BISS_EXPECT_EQ(margin_compensated(megahertz(10)).count, 25'000);
}

constexpr DeviceTiming endless{
    .ack_max = never, .timeout = {TimeoutRule::fixed, never}, .cycle_min = never};
static_assert(ack_bounds(endless, nanoseconds(100)) == AckBounds{1, 400});
static_assert(cycle_budget({.payload_bits = 640, .slaves = 8}, endless, hertz(1), never).total >
              milliseconds(3 * 86'400'000LL));
static_assert(cycle_budget({.payload_bits = 34}, endless, megahertz(10), {}).request_rate_max ==
              hertz(0));

BISS_TEST(Cycle, TimesWithoutEnd_CountAsADay) {
  for (const TimeoutRule rule : {TimeoutRule::adaptive, TimeoutRule::fixed, TimeoutRule::cycle}) {
    DeviceTiming timing = endless;
    timing.timeout.rule = rule;
    const CycleBudget budget = cycle_budget({.payload_bits = 34}, timing, hertz_max, never);
    BISS_EXPECT(budget.total > milliseconds(86'400'000));
    BISS_EXPECT(budget.request_rate_max == hertz(0));
    BISS_EXPECT(!is_feasible(budget, hertz(1)));
  }
}

BISS_TEST(SamplingPoint, IsHalfAPeriodAfterTheDelay) {
  BISS_EXPECT(sampling_point({}, nanoseconds(100)) == SamplingPoint{0, nanoseconds(50)});
  BISS_EXPECT(sampling_point(nanoseconds(49), nanoseconds(100)) ==
              SamplingPoint{0, nanoseconds(99)});
  BISS_EXPECT(sampling_point(nanoseconds(50), nanoseconds(100)) == SamplingPoint{1, {}});
  BISS_EXPECT(sampling_point(nanoseconds(542), nanoseconds(100)) ==
              SamplingPoint{5, nanoseconds(92)});
}

}  // namespace biss::timing_test
