// The slaves of the core and of the oracle compared, edge by edge, on clocks of a master and on
// other clocks.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <string>

#include "tests/core/random.hpp"
#include "tests/exhaustive/scale.hpp"
#include "tests/timing/scenario.hpp"

namespace timing_test::random_test {

using biss::test::Random;
using oracle::Time;

constexpr Time nanosecond = 1000;

oracle::SlaveDescription random_timing(Random& random, Time period) {
  oracle::SlaveDescription slave;
  const auto some = [&](std::uint32_t clocks) -> Time {
    if (random.flip()) return 0;
    const Time time = period * random.below(clocks);
    return random.flip() ? time : time + Time(random.below(static_cast<std::uint32_t>(period)));
  };
  slave.sampling = some(5);
  slave.start_min = some(4);
  slave.ready = some(20);
  if (random.below(6) == 0) slave.ack_clocks = 1 + random.below(9);
  if (random.below(6) == 0) slave.busy_clocks = random.below(9);
  slave.kind = static_cast<oracle::TimeoutKind>(random.below(3));
  slave.timeout = slave.kind == oracle::TimeoutKind::adaptive
                      ? Time(random.below(700)) * nanosecond
                      : Time(12'500 + random.below(27'500)) * nanosecond;
  slave.release_halves = 2 + random.below(9);
  slave.static_timeout = Time(12'500 + random.below(27'500)) * nanosecond;
  return slave;
}

Scenario random_scenario(Random& random, std::size_t slaves, Time period) {
  Scenario scenario;
  for (std::size_t k = 0; k < slaves; ++k) {
    Device device;
    device.position_bits = 1 + random.below(40);
    device.crc_bits = random.flip() ? 3 : 6;
    device.position = random.bits(device.position_bits);
    device.changing = device.position_bits < 3 ? 1 : 7;
    device.cds = random.flip();
    device.timing = random_timing(random, period);
    device.timing.chained = k != 0;
    scenario.chain.push_back(device);
  }
  return scenario;
}

void clock(oracle::Line& ma, Time& now, Time period, std::uint32_t count) {
  for (std::uint32_t i = 0; i < count; ++i) {
    ma.push_back({now, false});
    ma.push_back({now + period / 2, true});
    now += period;
  }
}

// Requests that are cut, early, too long, or end with a CDM of 1.
oracle::Line random_requests(Random& random, Time period) {
  oracle::Line ma;
  Time now = 5'000 * nanosecond;
  for (int request = 0; request < 4; ++request) {
    clock(ma, now, period, random.below(4) == 0 ? 1 + random.below(12) : 30 + random.below(150));
    const Time pause = Time(random.below(80'000)) * nanosecond;
    if (random.flip()) {
      ma.push_back({now, false});
      now += pause + nanosecond;
      ma.push_back({now, true});
      now += 100 * nanosecond;
    } else {
      now += pause;
    }
  }
  return ma;
}

oracle::Line random_edges(Random& random, Time period) {
  oracle::Line ma;
  Time now = 0;
  bool level = true;
  for (int edge = 0; edge < 300; ++edge) {
    const auto half = static_cast<std::uint32_t>(period / 2);
    now += 1 + Time(random.below(half));
    if (random.below(3) == 0) now += period;
    if (random.below(40) == 0) now += Time(random.below(60'000)) * nanosecond;
    level = !level;
    ma.push_back({now, level});
  }
  return ma;
}

constexpr int rounds = exhaustive::slow_build ? 500 : 4000;

std::string judged(const Scenario& scenario) {
  return difference(answers_of_core(scenario), answers_of_oracle(scenario));
}

template <class Edges>
void compare(std::uint64_t seed, int count, const Edges& edges) {
  std::printf("[   seed   ] 0x%llX\n", static_cast<unsigned long long>(seed));
  Random random(seed);
  std::size_t frames = 0;
  for (int round = 0; round < count; ++round) {
    const Time period = Time(100 + random.below(random.flip() ? 1000 : 12'400)) * nanosecond;
    Scenario scenario = random_scenario(random, 1 + random.below(4), period);
    scenario.ma = edges(random, period);
    ASSERT_EQ(judged(scenario), "") << "round " << round << "\nMA " << text_of(scenario.ma);
    frames += answers_of_oracle(scenario).back().samples.size();
  }
  EXPECT_GT(frames, static_cast<std::size_t>(count));
}

TEST(SlaveAgainstOracle, Requests_AreAnsweredAlike) {
  compare(0x51A7E'0001, rounds, random_requests);
}

TEST(SlaveAgainstOracle, AnyEdges_AreAnsweredAlike) { compare(0x51A7E'0002, rounds, random_edges); }

}  // namespace timing_test::random_test
