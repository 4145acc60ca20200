// `check` fails no capture without a fault.
#include <gtest/gtest.h>

#include "tests/exhaustive/scale.hpp"
#include "tests/sim/clean_capture.hpp"

namespace biss::campaign::clean_check_test {

TEST(CleanCheck, CapturesWithoutFaults_FailNoRule) {
  const std::uint64_t captures = exhaustive::slow_build ? 200 : 2'000;
  for (std::uint64_t number = 0; number < captures; ++number) {
    const CleanCapture capture = clean_capture(number);
    SCOPED_TRACE(testing::Message() << number << ": " << capture.name());
    EXPECT_EQ(failing_rules(capture, own_limits(capture)), "");
    decode::CheckSetup biss_c = own_limits(capture);
    biss_c.timing = {};
    biss_c.renishaw_cables = false;
    // A few encoders may be slower than BiSS C allows.
    if (capture.setup.clock < biss_clock_min) continue;
    EXPECT_EQ(failing_rules(capture, biss_c), "");
    biss_c.format.reset();
    biss_c.unidirectional = false;
    EXPECT_EQ(failing_rules(capture, biss_c), "");
  }
}

}  // namespace biss::campaign::clean_check_test
