#include "sim/fault_schedule.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "biss/timing/step.hpp"

namespace biss::sim {
namespace fault_schedule_test {

TEST(FaultList, Names_AreUniqueAndFound) {
  std::set<std::string_view> names;
  for (const FaultEntry& entry : fault_list) {
    EXPECT_TRUE(names.insert(entry.name).second) << entry.name;
    EXPECT_EQ(find_fault(entry.name), entry.kind);
    EXPECT_FALSE(entry.effect.empty()) << entry.name;
  }
  EXPECT_EQ(find_fault("flop"), std::nullopt);
  EXPECT_EQ(text_of(set_of(FaultKind::cut) | set_of(FaultKind::flip)), "flip;cut");
}

TEST(PartOf, AnyTime_HasNoOverflow) {
  static_assert(part_of(never, 0) == Picoseconds{});
  static_assert(part_of(never, time_parts) == never);
  static_assert(part_of(picoseconds(3), time_parts / 2) == picoseconds(1));
  static_assert(part_of(milliseconds(100'000), time_parts / 4) == milliseconds(25'000));
}

// A product of the interval and 2^20 needs more than 64 bits here.
TEST(FaultSchedule, IntervalOfTenSeconds_KeepsFaultsWithinTheCycle) {
  NominalCycle nominal;
  nominal.period = microseconds(1);
  nominal.low_time = nominal.period / 2;
  nominal.interval = milliseconds(10'000);
  nominal.clocks = 50;
  nominal.data_clock = 5;
  nominal.payload_bits = 32;
  FaultSchedule schedule({{.kind = FaultKind::glitch_slo_idle, .share = std::uint64_t{1} << 32U}},
                         1);
  schedule.set_nominal(nominal);
  Picoseconds latest{};
  for (std::uint64_t cycle = 0; cycle < 100; ++cycle) {
    const Picoseconds begin = static_cast<std::int64_t>(cycle) * nominal.interval;
    schedule.begin_cycle(cycle, begin);
    const Picoseconds since = schedule.take().time - begin;
    EXPECT_GE(since, nominal.clocks * nominal.period);
    EXPECT_LT(since, nominal.interval);
    latest = std::max(latest, since);
    schedule.take();
  }
  EXPECT_GT(latest, milliseconds(9'000));
}

}  // namespace fault_schedule_test
}  // namespace biss::sim
