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

}  // namespace position_policy_test

}  // namespace control_loop
