#include "decode/distribution.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "decode/statistics.hpp"

namespace biss::decode {
namespace distribution_test {

TEST(Distribution, FewValues_AreExact) {
  Distribution values;
  EXPECT_EQ(values.count(), 0U);
  for (const std::int64_t value : {7, 3, 9, 1}) values.add(value);
  EXPECT_EQ(values.count(), 4U);
  EXPECT_EQ(values.min(), 1);
  EXPECT_EQ(values.median(), 3);
  EXPECT_EQ(values.max(), 9);
}

TEST(Distribution, NegativeValue_CountsAsZero) {
  Distribution values;
  values.add(-5);
  EXPECT_EQ(values.min(), 0);
  EXPECT_EQ(values.max(), 0);
}

TEST(Distribution, LargestValue_IsHeld) {
  Distribution values;
  for (int i = 0; i < 70'000; ++i) values.add(INT64_MAX);
  EXPECT_EQ(values.median(), INT64_MAX);
  EXPECT_EQ(values.max(), INT64_MAX);
}

TEST(Distribution, ManyValues_MedianIsWithinOnePerMille) {
  constexpr std::uint64_t seed = 42;
  SCOPED_TRACE(seed);
  for (const unsigned shift : {60U, 50U, 40U, 20U, 3U}) {
    std::mt19937_64 random(seed);
    Distribution values;
    std::vector<std::int64_t> all;
    for (int i = 0; i < 200'001; ++i) {
      all.push_back(static_cast<std::int64_t>(random() >> shift));
      values.add(all.back());
    }
    std::sort(all.begin(), all.end());
    const auto exact = static_cast<double>(all[100'000]);
    EXPECT_EQ(values.min(), all.front());
    EXPECT_EQ(values.max(), all.back());
    EXPECT_NEAR(static_cast<double>(values.median()), exact, exact / 1000);
  }
}

Cycle cycle_at(std::int64_t us, CycleStatus status) {
  Cycle cycle;
  cycle.time = microseconds(us);
  cycle.status = status;
  cycle.period = nanoseconds(1'000);
  if (status == CycleStatus::ok) {
    cycle.frame.emplace();
    cycle.frame->channel_count = 2;
  }
  return cycle;
}

TEST(Statistics, CausesAndFlags_AreCountedApart) {
  Statistics statistics;
  Cycle error = cycle_at(0, CycleStatus::ok);
  error.frame->channel_list[1].nE = false;
  statistics.add(error);
  Cycle warning = cycle_at(100, CycleStatus::ok);
  warning.frame->channel_list[0].nW = false;
  statistics.add(warning);
  statistics.add(cycle_at(200, CycleStatus::crc));
  EXPECT_EQ(statistics.cycles(), 3U);
  EXPECT_EQ(statistics.count(CycleStatus::ok), 2U);
  EXPECT_EQ(statistics.count(CycleStatus::crc), 1U);
  EXPECT_EQ(statistics.errors(), 1U);
  EXPECT_EQ(statistics.warnings(), 1U);
  EXPECT_EQ(statistics.interval().count(), 2U);
  EXPECT_EQ(statistics.interval().median(), microseconds(100).count);
}

TEST(Statistics, MarginalCycles_AreCountedAmongThoseJudged) {
  Statistics statistics;
  for (const std::optional<bool> marginal :
       {std::optional<bool>(true), std::optional<bool>(false), std::optional<bool>()}) {
    Cycle cycle = cycle_at(0, CycleStatus::ok);
    cycle.marginal = marginal;
    statistics.add(cycle);
  }
  EXPECT_EQ(statistics.marginal(), 1U);
  EXPECT_EQ(statistics.margin_judged(), 2U);
}

TEST(Statistics, GlitchesAndCutCycles_SayNothingOfTheRate) {
  Statistics statistics;
  statistics.add(cycle_at(0, CycleStatus::cut_start));
  statistics.add(cycle_at(100, CycleStatus::ok));
  statistics.add(cycle_at(130, CycleStatus::ma_glitch));
  statistics.add(cycle_at(200, CycleStatus::ok));
  statistics.add(cycle_at(300, CycleStatus::cut_end));
  EXPECT_EQ(statistics.cycles(), 5U);
  EXPECT_EQ(statistics.failed(), 1U);
  EXPECT_EQ(statistics.interval().count(), 1U);
  EXPECT_EQ(statistics.interval().max(), microseconds(100).count);
}

}  // namespace distribution_test
}  // namespace biss::decode
