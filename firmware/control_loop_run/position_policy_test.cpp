#include "firmware/control_loop/position_policy.hpp"

#include "tests/core/test.hpp"

namespace control_loop {
namespace position_policy_test {

constexpr PolicyLimits limits_for(BadFrameRule rule) {
  return {.rule = rule, .trip_after = 3, .max_step = 100};
}

BISS_TEST(PositionPolicy, BadFramesBeforeTheFirst_GiveNoneAndThenTrip) {
  PositionPolicy policy(limits_for(BadFrameRule::extrapolate));
  BISS_EXPECT_EQ(policy.output().quality, Quality::none);
  BISS_EXPECT_EQ(policy.bad().quality, Quality::none);
  BISS_EXPECT_EQ(policy.bad().quality, Quality::none);
  BISS_EXPECT_EQ(policy.bad().quality, Quality::tripped);
}

BISS_TEST(PositionPolicy, OneSampleAndABadFrame_IsHeldForWantOfASpeed) {
  PositionPolicy policy(limits_for(BadFrameRule::extrapolate));
  policy.good(1000);
  const PolicyOutput out = policy.bad();
  BISS_EXPECT_EQ(out.quality, Quality::held);
  BISS_EXPECT_EQ(out.position, 1000);
}

BISS_TEST(PositionPolicy, BadFramesInMotion_GoOnAtTheLastSpeed) {
  PositionPolicy policy(limits_for(BadFrameRule::extrapolate));
  policy.good(-50);
  policy.good(-80);
  BISS_EXPECT_EQ(policy.bad().position, -110);
  const PolicyOutput out = policy.bad();
  BISS_EXPECT_EQ(out.position, -140);
  BISS_EXPECT_EQ(out.quality, Quality::extrapolated);
  BISS_EXPECT_EQ(out.bad_in_a_row, 2);
}

BISS_TEST(PositionPolicy, GoodFrameAfterAGap_MeasuresTheSpeedOverTheGap) {
  PositionPolicy policy(limits_for(BadFrameRule::extrapolate));
  policy.good(0);
  policy.good(10);
  policy.bad();
  policy.bad();
  BISS_EXPECT_EQ(policy.good(70).quality, Quality::measured);
  BISS_EXPECT_EQ(policy.bad().position, 90);
}

BISS_TEST(PositionPolicy, HoldRule_KeepsTheLastMeasuredPosition) {
  PositionPolicy policy(limits_for(BadFrameRule::hold));
  policy.good(10);
  policy.good(20);
  policy.bad();
  const PolicyOutput out = policy.bad();
  BISS_EXPECT_EQ(out.quality, Quality::held);
  BISS_EXPECT_EQ(out.position, 20);
}

BISS_TEST(PositionPolicy, TripRule_TripsAtOnce) {
  PositionPolicy policy(limits_for(BadFrameRule::trip));
  policy.good(10);
  BISS_EXPECT_EQ(policy.bad().quality, Quality::tripped);
}

BISS_TEST(PositionPolicy, GoodFrameAfterATrip_StaysTrippedUntilReset) {
  PositionPolicy policy(limits_for(BadFrameRule::hold));
  policy.good(10);
  policy.bad();
  policy.bad();
  policy.bad();
  const PolicyOutput out = policy.good(11);
  BISS_EXPECT_EQ(out.quality, Quality::tripped);
  BISS_EXPECT_EQ(out.position, 10);
  BISS_EXPECT_EQ(policy.bad().quality, Quality::tripped);
  policy.reset();
  BISS_EXPECT_EQ(policy.good(500).quality, Quality::measured);
}

BISS_TEST(PositionPolicy, StepBeyondTheLimit_IsABadCycleEitherWay) {
  PositionPolicy policy(limits_for(BadFrameRule::hold));
  policy.good(0);
  BISS_EXPECT_EQ(policy.good(100).quality, Quality::measured);
  BISS_EXPECT_EQ(policy.good(201).quality, Quality::held);
  BISS_EXPECT_EQ(policy.good(-101).quality, Quality::held);
  BISS_EXPECT_EQ(policy.good(400).position, 400);
}

// The largest steps, up to the ends of the range.
constexpr std::int64_t range_end = (std::int64_t{1} << 62U) - 1;
constexpr PolicyOutput far_and_back(std::int64_t max_step) {
  PositionPolicy policy({.rule = BadFrameRule::extrapolate, .trip_after = 9, .max_step = max_step});
  policy.good(-range_end);
  policy.bad();
  policy.bad();
  policy.good(range_end);
  return policy.good(-range_end);
}
static_assert(far_and_back(no_step_limit).quality == Quality::measured);
static_assert(far_and_back(no_step_limit).position == -range_end);
static_assert(far_and_back(no_step_limit / 2).quality != Quality::measured);

BISS_TEST(PositionPolicy, AnyStepWithoutALimit_IsMeasured) {
  BISS_EXPECT_EQ(far_and_back(no_step_limit).quality, Quality::measured);
  PositionPolicy policy({.rule = BadFrameRule::hold, .trip_after = 9, .max_step = no_step_limit});
  policy.good(1);
  policy.bad();
  BISS_EXPECT_EQ(policy.good(-1).quality, Quality::measured);
}

BISS_TEST(PositionPolicy, StepAfterAGap_MayBeTheLimitForEachCycle) {
  for (const std::int64_t step : {200, 201, -200, -201}) {
    PositionPolicy policy(limits_for(BadFrameRule::hold));
    policy.good(0);
    policy.bad();
    const bool allowed = step == 200 || step == -200;
    BISS_EXPECT_EQ(policy.good(step).quality, allowed ? Quality::measured : Quality::held) << step;
  }
}

// The result of this many bad cycles after two good frames.
constexpr PolicyOutput extrapolated_far(std::int64_t from, std::int64_t step, int bad_cycles) {
  PositionPolicy policy(
      {.rule = BadFrameRule::extrapolate, .trip_after = 9, .max_step = no_step_limit});
  policy.good(from);
  policy.good(from + step);
  for (int i = 1; i < bad_cycles; ++i) policy.bad();
  return policy.bad();
}
constexpr std::int64_t far_step = std::int64_t{1} << 60U;
static_assert(extrapolated_far(0, far_step, 2).position == 3 * far_step);
static_assert(extrapolated_far(0, far_step, 3).quality == Quality::held);
static_assert(extrapolated_far(0, far_step, 8).position == far_step);
static_assert(extrapolated_far(0, -far_step, 8).position == -far_step);

BISS_TEST(PositionPolicy, ExtrapolationBeyondTheRange_IsHeld) {
  BISS_EXPECT_EQ(extrapolated_far(-range_end, range_end, 1).quality, Quality::extrapolated);
  BISS_EXPECT_EQ(extrapolated_far(-range_end, range_end, 2).quality, Quality::held);
  BISS_EXPECT_EQ(extrapolated_far(0, -far_step, 3).quality, Quality::held);
}

}  // namespace position_policy_test

}  // namespace control_loop
