// A few of the captures without a fault; tests/sim has the thousands.
#include <gtest/gtest.h>

#include "tests/sim/clean_capture.hpp"

namespace biss::verbs::clean_check_test {

TEST(CleanCheck, CapturesWithoutFaults_FailNoRule) {
  for (std::uint64_t number = 100'000; number < 100'040; ++number) {
    const campaign::CleanCapture capture = campaign::clean_capture(number);
    SCOPED_TRACE(testing::Message() << number << ": " << capture.name());
    EXPECT_EQ(campaign::failing_rules(capture, campaign::own_limits(capture)), "");
  }
}

}  // namespace biss::verbs::clean_check_test
