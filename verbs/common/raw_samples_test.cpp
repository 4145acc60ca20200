#include "verbs/common/raw_samples.hpp"

#include <gtest/gtest.h>

#include <string>

namespace biss::verbs {
namespace raw_samples_test {

TEST(RawSamples, BothLinesNamed_NoOtherBitIsLookedAt) {
  const capture::RawLayout layout = layout_of({.rate = megahertz(100), .bytes = 2}, "D11", "D3");
  EXPECT_EQ(layout.rate, megahertz(100));
  EXPECT_EQ(layout.unit_bytes, 2U);
  ASSERT_EQ(layout.lines.size(), 2U);
  EXPECT_EQ(layout.lines[0].name, "D3");
  EXPECT_EQ(layout.lines[0].bit, 3U);
  EXPECT_EQ(layout.lines[1].name, "D11");
  EXPECT_EQ(layout.lines[1].bit, 11U);
}

TEST(RawSamples, AnyLineNotKnown_EveryBitIsALine) {
  const RawSamples raw{.rate = hertz(1), .bytes = 3};
  const auto lines = [&](const char* ma, const char* slo) {
    const capture::RawLayout layout = layout_of(raw, ma, slo);
    EXPECT_EQ(capture::fault_of(layout), nullptr);
    for (unsigned bit = 0; bit < layout.lines.size(); ++bit) {
      EXPECT_EQ(layout.lines[bit].bit, bit);
      EXPECT_EQ(layout.lines[bit].name, "D" + std::to_string(bit));
    }
    return layout.lines.size();
  };
  EXPECT_EQ(lines("", ""), 24U);
  EXPECT_EQ(lines("D1", ""), 24U);
  EXPECT_EQ(lines("D1", "D24"), 24U);
  EXPECT_EQ(lines("D1", "D1"), 24U);
  EXPECT_EQ(lines("MA", "SLO"), 24U);
}

}  // namespace raw_samples_test
}  // namespace biss::verbs
