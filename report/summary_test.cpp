#include "report/summary.hpp"

#include <gtest/gtest.h>

namespace biss::report {
namespace summary_test {

TEST(Summary, KeysValuesAndNotes_AreAligned) {
  Summary summary;
  summary.title("encoder.vcd");
  summary.entry("clock", "10.000 MHz", "(9.998 .. 10.000 .. 10.002)");
  summary.entry("line delay", "112 ns", "compensated");
  summary.entry("lines", "MA = channel 0, SLO = channel 1, found by their behaviour");
  summary.title("frames");
  summary.entry("ok", "12");
  EXPECT_EQ(summary.text(),
            "encoder.vcd\n"
            "clock       10.000 MHz  (9.998 .. 10.000 .. 10.002)\n"
            "line delay  112 ns      compensated\n"
            "lines       MA = channel 0, SLO = channel 1, found by their behaviour\n"
            "\n"
            "frames\n"
            "ok          12\n");
}

TEST(Summary, NonAsciiAndControl_KeepTheColumns) {
  Summary summary;
  summary.entry("µ", "編", "x");
  summary.entry("ab", "c\nd", "y");
  EXPECT_EQ(summary.text(), "µ   編   x\nab  c\uFFFDd  y\n");
}

TEST(Summary, Nothing_IsEmpty) {
  EXPECT_TRUE(Summary().empty());
  EXPECT_EQ(Summary().text(), "");
}

}  // namespace summary_test
}  // namespace biss::report
