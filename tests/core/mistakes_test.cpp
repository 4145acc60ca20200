// Each mistake of docs/guide-firmware.md, made on purpose.
#include "tests/core/mistakes.hpp"

#include "tests/core/test.hpp"

namespace biss::mistakes_test {

BISS_TEST(Mistakes, None_GivesThePositionAndTheLineDelay) {
  mistakes::Bench<> bench;
  bench.cycle();
  BISS_EXPECT_EQ(bench.axis.position().cause, AxisCause::first);
  for (int k = 0; k < 5; ++k) {
    bench.cycle();
    BISS_EXPECT_EQ(bench.axis.position().cause, AxisCause::ok);
    BISS_EXPECT_EQ(bench.axis.position().position, bench.line.position);
  }
  BISS_ASSERT(bench.axis.line_delay_seen());
  BISS_EXPECT_EQ(bench.axis.line_delay_seen()->first, 3);
  BISS_EXPECT_EQ(bench.axis.line_delay_seen()->second, 3);
}

BISS_TEST(Mistakes, EachOne_HasItsResult) {
  for (const mistakes::Mistake& mistake : mistakes::list) {
    if (mistake.make == nullptr) continue;
    const std::string_view seen = mistake.make();
    BISS_EXPECT(seen == mistake.result) << mistake.name.data() << ": " << seen.data();
  }
}

}  // namespace biss::mistakes_test
