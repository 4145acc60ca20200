#include "verbs/common/capture_output.hpp"

#include <gtest/gtest.h>

namespace biss::verbs {
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
    const Hertz rate = usual_sample_rate(Hertz{static_cast<std::uint32_t>(clock)});
    EXPECT_EQ(picoseconds_per_second % rate.count, 0) << clock;
  }
}

TEST(CaptureFormat, LongestExtension_SelectsIt) {
  EXPECT_EQ(capture_format_of("a.vcd"), CaptureFormat::vcd);
  EXPECT_EQ(capture_format_of("a.b/c.csv"), CaptureFormat::event_csv);
  EXPECT_EQ(capture_format_of("a.saleae.csv"), CaptureFormat::saleae_csv);
  EXPECT_EQ(capture_format_of("a.saleae.bin"), CaptureFormat::saleae_binary);
  EXPECT_EQ(capture_format_of("a.sr"), CaptureFormat::sr);
  EXPECT_EQ(capture_format_of("a.bin"), CaptureFormat::raw);
  EXPECT_EQ(capture_format_of("b/a.raw"), CaptureFormat::raw);
  EXPECT_EQ(capture_format_of("a.dsl"), CaptureFormat::dsl);
  for (const char* path : {"-", "", "sr", "a.vcd.gz"}) {
    EXPECT_EQ(capture_format_of(path), std::nullopt) << path;
  }
}

TEST(CaptureFormat, FormatsThatAreOnlyRead_AreKnownByTheirExtension) {
  for (const char* path : {"a.fst", "b/a.sal", "a.vcd.gz", "a.csv.zst"}) {
    EXPECT_TRUE(is_only_read(path)) << path;
  }
  for (const char* path : {"-", "", "gz", "a.vcd", "a.gz/line", "line", "a.fst.vcd", "a.txt"}) {
    EXPECT_FALSE(is_only_read(path)) << path;
  }
}

TEST(CaptureFormat, SampledFormats_HoldNoNegativeTimes) {
  for (const CaptureFormat format : {CaptureFormat::sr, CaptureFormat::raw, CaptureFormat::dsl}) {
    EXPECT_TRUE(is_sampled(format));
    EXPECT_FALSE(holds_negative_times(format));
  }
  EXPECT_FALSE(is_sampled(CaptureFormat::vcd));
  EXPECT_FALSE(holds_negative_times(CaptureFormat::vcd));
  EXPECT_TRUE(holds_negative_times(CaptureFormat::saleae_binary));
}

}  // namespace capture_output_test
}  // namespace biss::verbs
