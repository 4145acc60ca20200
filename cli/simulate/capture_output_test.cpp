#include "cli/simulate/capture_output.hpp"

#include <gtest/gtest.h>

namespace biss::cli {
namespace capture_output_test {

TEST(SampleRate, NextUsualOneFromEightTimesTheClock) {
  EXPECT_EQ(usual_sample_rate(megahertz(10)), megahertz(100));
  EXPECT_EQ(usual_sample_rate(kilohertz(2'500)), megahertz(20));
  EXPECT_EQ(usual_sample_rate(kilohertz(2'501)), megahertz(50));
  EXPECT_EQ(usual_sample_rate(hertz(1)), hertz(10));
  EXPECT_EQ(usual_sample_rate(hertz(0)), hertz(1));
  EXPECT_EQ(usual_sample_rate(hertz(UINT32_MAX)), hertz(4'000'000'000));
}

TEST(SampleRate, EveryUsualOne_HasAPeriodOfWholePicoseconds) {
  for (std::uint64_t clock = 1; clock < UINT32_MAX; clock = clock * 5 / 4 + 1) {
    const Hertz rate = usual_sample_rate({static_cast<std::uint32_t>(clock)});
    EXPECT_EQ(picoseconds_per_second % rate.count, 0) << clock;
  }
}

TEST(CaptureOutput, Extension_SaysWhetherItIsSampled) {
  for (const char* path : {"a.sr", "a.bin", "b/a.raw"})
    EXPECT_TRUE(CaptureOutput::is_sampled(path));
  for (const char* path : {"a.vcd", "a.csv", "a.saleae.csv", "-", "", "sr"}) {
    EXPECT_FALSE(CaptureOutput::is_sampled(path)) << path;
  }
}

}  // namespace capture_output_test
}  // namespace biss::cli
