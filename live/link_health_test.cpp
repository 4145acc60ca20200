// The health of a link: no alarm of a healthy one, an alarm for each way in which a link becomes worse,
// constant memory.
#include "live/link_health.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/common/long_run.hpp"
#include "tests/common/random.hpp"

namespace biss::live_test {

using live::Alarm;
using live::AlarmChange;
using live::HealthPoint;
using live::HealthSample;
using live::LinkHealth;
using testing::HasSubstr;

constexpr std::uint64_t cycles_each = 1000;
constexpr std::uint64_t baseline = 10;

/// Cycles of a link at 5 MHz.
struct Line {
  double delay = 240'000;
  double ack = 3'200'000;
  double margin = 470;
  double jitter = 2'000;
  double damaged = 0;
  double warning = 0;
  double noisy = 0;
  double error = 0;

  HealthSample sample(std::mt19937_64& random) const {
    const auto chance = [&](double share) {
      return share > 0 && std::uniform_real_distribution(0.0, 1.0)(random) < share;
    };
    const auto around = [&](double value, double scatter) {
      return std::llround(value + std::normal_distribution(0.0, scatter)(random));
    };
    return {.status = chance(damaged) ? CycleStatus::crc : CycleStatus::ok,
            .error = chance(error),
            .warning = chance(warning),
            .noisy = chance(noisy),
            .delay = around(delay, jitter),
            .ack = around(ack, 50'000),
            .margin = around(margin, jitter / 200),
            .period = nanoseconds(200)};
  }
};

class Health : public testing::Test {
 protected:
  void interval(const Line& line, std::uint64_t cycles = cycles_each) {
    for (std::uint64_t k = 0; k < cycles; ++k) health_.add(line.sample(random_));
    end();
  }
  void end() {
    ASSERT_TRUE(health_.end_interval(++time_));
    for (const AlarmChange& change : health_.changes()) changes_.push_back(change);
  }
  void learn(const Line& line) {
    for (std::uint64_t k = 0; k < baseline; ++k) interval(line);
    EXPECT_TRUE(changes_.empty());
  }
  void gap() {
    for (int k = 0; k < 3; ++k) health_.add({.status = CycleStatus::no_response});
    health_.add(Line().sample(random_));
  }
  // The only alarm that began, and its reason.
  void expect_alarm(Alarm alarm, const std::string& reason) const {
    ASSERT_EQ(changes_.size(), 1U);
    EXPECT_TRUE(changes_[0].begins);
    EXPECT_EQ(name_of(changes_[0].alarm), name_of(alarm));
    EXPECT_THAT(changes_[0].reason, HasSubstr(reason));
  }

  std::mt19937_64 random_ = test::random_of();
  LinkHealth health_{live::HealthSetup{.baseline = baseline}};
  std::vector<AlarmChange> changes_;
  std::int64_t time_ = 0;
};

TEST_F(Health, HealthyLink_HasNoAlarm) {
  // Some cables and encoders are warm in the afternoon, and some frames are damaged at any time.
  const std::uint64_t intervals = test::rounds(10'000, 100);
  Line line{.damaged = 1e-5, .warning = 0.01};
  for (std::uint64_t k = 0; k < intervals; ++k) {
    line.delay = 240'000 + 1'500 * std::sin(static_cast<double>(k) / 20);
    interval(line, 10'000);
  }
  EXPECT_EQ(health_.state().counts.cycles, intervals * 10'000);
  for (const AlarmChange& change : changes_)
    ADD_FAILURE() << name_of(change.alarm) << ' ' << change.reason;
}

TEST_F(Health, DriftOfTheLineDelay) {
  Line line;
  learn(line);
  for (int k = 0; k < 20; ++k) {
    line.delay += 2'000;
    interval(line);
  }
  expect_alarm(Alarm::delay, "line delay 26");
  EXPECT_EQ(changes_[0].faults, 0U);
}

TEST_F(Health, RisingNoise_WithLessMargin) {
  Line line;
  learn(line);
  for (int k = 0; k < 10; ++k) {
    line.margin -= 15;
    interval(line);
  }
  expect_alarm(Alarm::noise, "margin 3");
}

TEST_F(Health, RisingNoise_WithPulses) {
  learn({.noisy = 1e-3});
  for (int k = 0; k < 5; ++k) interval({.noisy = 0.05});
  expect_alarm(Alarm::noise, "pulses");
}

TEST_F(Health, RisingNoise_WithDamagedFrames) {
  learn({.damaged = 1e-3});
  for (int k = 0; k < 5; ++k) interval({.damaged = 0.05});
  expect_alarm(Alarm::noise, "frames are damaged");
}

TEST_F(Health, DamageThatStays_IsAnAlarmThatStays) {
  learn({});
  for (int k = 0; k < 500; ++k) interval({.damaged = 0.02});
  expect_alarm(Alarm::noise, "frames are damaged");
}

TEST_F(Health, RareDamage_IsAnAlarmInTheEnd) {
  for (std::uint64_t k = 0; k < baseline; ++k) interval({}, 450);
  for (int k = 0; k < 64; ++k) {
    health_.add({.status = CycleStatus::crc});
    interval({}, 149);
  }
  expect_alarm(Alarm::noise, "frames are damaged");
}

TEST_F(Health, NoCycle_IsSilent_IfItMayBe) {
  learn({});
  EXPECT_FALSE(health_.end_interval(++time_));
  ASSERT_TRUE(health_.end_interval(++time_, true));
  ASSERT_EQ(health_.changes().size(), 1U);
  EXPECT_EQ(health_.changes()[0].reason, "no cycle was read");
}

TEST_F(Health, CableThatAges) {
  Line line;
  learn(line);
  for (int k = 0; k < 10; ++k) {
    line.margin -= 15;
    line.delay += 2'000;
    interval(line);
  }
  expect_alarm(Alarm::cable, "and line delay");
}

TEST_F(Health, IntermittentContact) {
  learn({});
  for (int k = 0; k < 5; ++k) {
    for (int i = 0; i < 500; ++i) health_.add(Line().sample(random_));
    gap();
    end();
  }
  expect_alarm(Alarm::contact, "3 times in 15");
}

TEST_F(Health, FailingEncoder) {
  learn({.warning = 0.001});
  for (int k = 0; k < 3; ++k) interval({.warning = 0.05});
  expect_alarm(Alarm::encoder, "nW is active");
}

TEST_F(Health, EncoderWithErrors) {
  learn({});
  interval({.error = 0.05});
  expect_alarm(Alarm::encoder, "nE is active");
}

TEST_F(Health, EncoderThatBecomesSlow) {
  Line line;
  learn(line);
  for (int k = 0; k < 10; ++k) {
    line.ack += 200'000;
    interval(line);
  }
  expect_alarm(Alarm::encoder, "ACK 4");
}

TEST_F(Health, NoAnswer_IsSilentAndNotABaseline) {
  for (std::uint64_t k = 0; k < cycles_each; ++k) health_.add({.status = CycleStatus::no_response});
  end();
  expect_alarm(Alarm::silent, "no good frame in 1000 cycles");
  EXPECT_EQ(health_.state().baseline.intervals, 0U);
}

TEST_F(Health, PortWithAnAnswerInAnotherClock) {
  health_ = LinkHealth({.unit = live::LinkUnit::clock, .baseline = baseline});
  const auto clocks = [&](double share) {
    for (std::uint64_t k = 0; k < cycles_each; ++k) {
      const bool later = std::uniform_real_distribution(0.0, 1.0)(random_) < share;
      health_.add({.delay = later ? 3 : 2, .ack = 14});
    }
    end();
  };
  for (std::uint64_t k = 0; k < baseline; ++k) clocks(0);
  clocks(0.1);
  expect_alarm(Alarm::delay, "a clock earlier or later");
}

TEST_F(Health, AlarmEnds_WhenItsReasonIsGone) {
  learn({});
  interval({.warning = 0.2});
  for (int k = 0; k < 63; ++k) interval({});
  // The last 64 intervals still show it.
  EXPECT_EQ(changes_.size(), 1U);
  for (int k = 0; k < 30; ++k) interval({});
  ASSERT_EQ(changes_.size(), 2U);
  EXPECT_FALSE(changes_[1].begins);
  EXPECT_TRUE(health_.state().reasons[static_cast<std::size_t>(Alarm::encoder)].empty());
}

TEST_F(Health, IntervalWithFewCycles_GoesOn) {
  for (int k = 0; k < 99; ++k) health_.add({});
  EXPECT_FALSE(health_.end_interval(1));
  health_.add({});
  const auto point = health_.end_interval(2);
  ASSERT_TRUE(point);
  EXPECT_EQ(point->cycles, 100U);
}

TEST_F(Health, History_HasAllCyclesInConstantMemory) {
  constexpr std::uint64_t intervals = 5'000;
  for (std::uint64_t k = 0; k < intervals; ++k) interval({}, 100);
  const live::HealthState& state = health_.state();
  EXPECT_LE(state.history.size(), 200U);
  EXPECT_GE(state.history.size(), 100U);
  EXPECT_LE(state.recent.size(), 64U);
  std::uint64_t cycles = 0;
  for (const HealthPoint& point : state.history) cycles += point.cycles;
  EXPECT_EQ(cycles, intervals * 100);
}

TEST_F(Health, Trend_OnlyIfItIsCertain) {
  Line line;
  for (int k = 0; k < 50; ++k, time_ += 3'600) interval(line, 200);
  EXPECT_EQ(health_.trend_text(live::Level::delay), "");
  for (int k = 0; k < 50; ++k, time_ += 3'600) {
    line.delay += 1'000;
    interval(line, 200);
  }
  EXPECT_THAT(health_.trend_text(live::Level::delay), HasSubstr("a day"));
}

}  // namespace biss::live_test
