// Every encoder of the catalogue with every clock rate and cable that its data sheet permits.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>

#include "biss/catalogue/catalogue.hpp"
#include "biss/timing/cable.hpp"
#include "biss/timing/cycle.hpp"
#include "tests/exhaustive/scale.hpp"
#include "tests/sim/campaign.hpp"

namespace biss::campaign::catalogue_line_test {

template <class Check>
std::size_t for_each_line(Check check) {
  std::size_t lines = 0;
  for (const CatalogueEntry& entry : catalogue) {
    for (const std::uint32_t kilohertz_count : {250U, 1'000U, 2'000U, 5'000U, 10'000U}) {
      for (const std::int64_t length : {0, 10, 50, 100}) {
        const Hertz clock = kilohertz(kilohertz_count);
        const auto longest = cable_max_compensated(clock);
        if (!accepts_clock(entry.timing, clock) || metres(length) > longest) continue;
        sim::LineSetup setup;
        setup.format = entry.frame_format();
        setup.timing = entry.timing;
        setup.clock = clock;
        setup.internal_delay = entry.timing.internal_delay_max;
        setup.ma_delay = setup.slo_delay = cable_delay(metres(length)) / 2;
        setup.interval = period_of(kilohertz(32));
        setup.motion = sim::MotionKind::random;
        check(setup, fmt::format("{} {} kHz {} m", entry.name, kilohertz_count, length));
        ++lines;
      }
    }
  }
  return lines;
}

constexpr std::uint64_t cycles = exhaustive::slow_build ? 20 : 200;

TEST(CatalogueLine, EveryCycle_DecodesAndAgreesWithTheTruth) {
  const std::size_t lines = for_each_line([](const sim::LineSetup& setup, const std::string& name) {
    const Outcome outcome = run(setup, cycles);
    EXPECT_EQ(outcome.undamaged.right(), cycles) << name << "\n" << outcome.complaints;
    EXPECT_EQ(outcome.master_failed + outcome.master_wrong, 0U) << name;
    EXPECT_EQ(outcome.extra_rows, 0U) << name;
  });
  EXPECT_GT(lines, 300U);
}

TEST(CatalogueLine, JitterUnevenClockAndProcessing_ChangeNothing) {
  for_each_line([](sim::LineSetup setup, const std::string& name) {
    setup.duty_per_mille = 440;
    setup.clock_error_ppm = -200;
    setup.ma_jitter = std::min(setup.ma_delay, nanoseconds(4));
    setup.slo_jitter = std::min(setup.slo_delay, nanoseconds(4));
    setup.processing = setup.timing.ack_max * 9 / 10;
    const Outcome outcome = run(setup, cycles / 4);
    EXPECT_EQ(outcome.undamaged.right(), cycles / 4) << name << "\n" << outcome.complaints;
    EXPECT_EQ(outcome.master_failed + outcome.master_wrong, 0U) << name;
  });
}

// The budget of these lines: ACK at its longest.
CycleBudget budget_of(const sim::LineSetup& setup) {
  return cycle_budget({setup.format.payload_bits()}, setup.timing, setup.clock,
                      setup.ma_delay + setup.slo_delay + setup.internal_delay);
}

TEST(CatalogueLine, RequestsAtExactlyTheBudget_AreAllReadAndTrue) {
  for_each_line([](sim::LineSetup setup, const std::string& name) {
    setup.processing = setup.timing.ack_max;
    setup.interval = budget_of(setup).total;
    EXPECT_EQ(sim::least_interval(setup), setup.interval) << name;
    const Outcome outcome = run(setup, cycles / 4);
    EXPECT_EQ(outcome.undamaged.right(), cycles / 4) << name << "\n" << outcome.complaints;
    EXPECT_EQ(outcome.master_failed + outcome.master_wrong, 0U) << name;
  });
}

// Where the frame is the limit, at most 3.5 periods are reserved: one for ACK, less than one each
// for the timeout and the line delay in whole clocks, half of one for CDM 1.
TEST(CatalogueLine, Budget_IsNotMuchLongerThanTheLineNeeds) {
  std::size_t by_frame = 0;
  std::size_t by_time = 0;
  for_each_line([&](sim::LineSetup setup, const std::string& name) {
    const CycleBudget budget = budget_of(setup);
    if (budget.idle.count != 0) return;
    setup.processing = setup.timing.ack_max;
    setup.interval = picoseconds(1);
    const Picoseconds least = sim::least_interval(setup);
    const Timeout& timeout = setup.timing.timeout;
    const bool fixed_time = timeout.rule == TimeoutRule::cycle && budget.total == timeout.time;
    EXPECT_LE(least, budget.total) << name;
    EXPECT_GT(least, budget.total - (fixed_time ? picoseconds(1) : budget.period * 7 / 2)) << name;
    ++(fixed_time ? by_time : by_frame);
  });
  EXPECT_GT(by_frame, 200U);
  EXPECT_GT(by_time, 50U);
}

TEST(CatalogueLine, WithoutCompensation_PositionIsTrueOrThereIsACause) {
  for_each_line([](sim::LineSetup setup, const std::string& name) {
    setup.compensate = false;
    sim::Line line(setup);
    for (std::uint64_t i = 0; i < cycles / 4; ++i) {
      const sim::SimulatedCycle& cycle = line.next();
      if (!cycle.reading.frame.ok()) continue;
      EXPECT_EQ(cycle.reading.frame->channel_list, cycle.sent.channel_list) << name;
    }
  });
}

}  // namespace biss::campaign::catalogue_line_test
