#include "capture/key_file.hpp"
#include "capture/sr.hpp"

#include <gtest/gtest.h>

#include <string>

namespace biss::capture {
namespace sr_metadata_test {

const std::string good =
    "[device 1]\ncapturefile=logic-1\nsamplerate=1 MHz\nprobe1=MA\nunitsize=1\n";

TEST(SampleRate, EveryWriting_IsRead) {
  EXPECT_EQ(parse_sample_rate("100 MHz"), megahertz(100));
  EXPECT_EQ(parse_sample_rate(" 12.5MHz "), kilohertz(12'500));
  EXPECT_EQ(parse_sample_rate("2000000"), megahertz(2));
  EXPECT_EQ(parse_sample_rate("1 GHz"), megahertz(1'000));
  EXPECT_EQ(parse_sample_rate("4.294967295 ghz"), hertz(UINT32_MAX));
  EXPECT_EQ(parse_sample_rate("24m"), megahertz(24));
  EXPECT_EQ(parse_sample_rate("7 kHz"), kilohertz(7));
  EXPECT_EQ(parse_sample_rate("33 Hz"), hertz(33));
  for (const char* text : {"", "0", "fast", "-1 MHz", "5 GHz", "1 THz", "1.2.3", "1 M Hz z", "1e99",
                           "99999999999999999999 GHz", "Hz"}) {
    EXPECT_EQ(parse_sample_rate(text), Hertz{}) << text;
  }
}

TEST(SrMetadata, ProbesWithGaps_KeepTheirBits) {
  const auto parsed = parse_sr_metadata(
      "[global]\r\nsigrok version=0.5.2\r\n\r\n[device 1]\r\ncapturefile = logic-1\r\n"
      "total probes=9\r\nsamplerate = 24 MHz\r\ntotal analog=0\r\n# note\r\nprobe9=SLO\r\n"
      "probe2=M\\sA \\\\\r\nunitsize=2\r\nanalog10=A0\r\n");
  ASSERT_TRUE(parsed);
  const auto& [layout, file] = *parsed;
  EXPECT_EQ(file, "logic-1");
  EXPECT_EQ(layout.rate, megahertz(24));
  EXPECT_EQ(layout.unit_bytes, 2U);
  ASSERT_EQ(layout.lines.size(), 2U);
  EXPECT_EQ(layout.lines[0].name, "M A \\");
  EXPECT_EQ(layout.lines[0].bit, 1U);
  EXPECT_EQ(layout.lines[1].name, "SLO");
  EXPECT_EQ(layout.lines[1].bit, 8U);
}

TEST(SrMetadata, SeveralDevices_GiveTheFirstWithLogic) {
  const auto parsed = parse_sr_metadata("[device 1]\nsamplerate=1 MHz\nanalog1=A\n" + good +
                                        "[device 2]\ncapturefile=logic-2\nprobe70=broken\n");
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->layout.lines.size(), 1U);
}

TEST(SrMetadata, WhatCannotBe_IsNamedWithItsLine) {
  struct Case {
    std::string text;
    std::uint64_t line;
  };
  for (const Case& bad :
       {Case{good + "probe0=x\n", 6}, Case{good + "probe65=x\n", 6}, Case{good + "probe=x\n", 6},
        Case{good + "probe-1=x\n", 6}, Case{good + "unitsize=0\n", 6},
        Case{good + "unitsize=9\n", 6}, Case{good + "unitsize=1x\n", 6},
        Case{good + "samplerate=0 Hz\n", 6}, Case{good + "samplerate=\n", 6},
        Case{good + "nonsense\n", 6}, Case{good + "probe9=beyond\n", 6}, Case{"", 0},
        Case{"[global]\na=b\n", 2},
        Case{"[device 1]\nsamplerate=1 MHz\nprobe1=MA\nunitsize=1\n", 4},
        Case{"[device 1]\ncapturefile=x\nsamplerate=1 MHz\nunitsize=1\n", 4},
        Case{"[device 1]\ncapturefile=x\nprobe1=MA\nunitsize=1\n", 4},
        Case{"[device 1]\ncapturefile=x\nprobe1=MA\nsamplerate=1\n", 4}}) {
    const auto parsed = parse_sr_metadata(bad.text);
    ASSERT_FALSE(parsed) << bad.text;
    const auto& error = parsed.error();
    EXPECT_EQ(error.cause, CaptureCause::malformed);
    EXPECT_EQ(error.line, bad.line) << bad.text;
    EXPECT_NE(error.expected, nullptr);
    EXPECT_STREQ(error.part, "metadata");
  }
}

TEST(SrMetadata, KeysGivenTwice_AreNamed) {
  for (const char* row :
       {"samplerate=2 MHz", "samplerate=1 MHz", "unitsize=2", "capturefile=logic-2", "probe1=SLO",
        "probe01=SLO", "[device 1]", "[device 2]\n[device 1]"}) {
    const auto parsed = parse_sr_metadata(good + row + "\n");
    ASSERT_FALSE(parsed) << row;
    EXPECT_EQ(parsed.error().cause, CaptureCause::malformed) << row;
    EXPECT_GE(parsed.error().line, 6U) << row;
    EXPECT_NE(std::string(parsed.error().expected).find("once"), std::string::npos) << row;
  }
}

TEST(SrMetadata, RowsThatEndInCr_AreRead) {
  std::string cr = good;
  for (char& c : cr) c = c == '\n' ? '\r' : c;
  EXPECT_TRUE(parse_sr_metadata(cr));
}

TEST(SrMetadata, OurText_ComesBack) {
  for (const std::uint32_t rate : {1U, 7U, 1'500U, 12'500'000U, 1'000'000'000U, UINT32_MAX}) {
    const RawLayout layout =
        packed_layout({"MA", " SLO ", "a\\sb", "x\ny", "=[#", "p q", "\t", "8", "9"}, Hertz{rate});
    const auto parsed = parse_sr_metadata(sr_metadata_text(layout));
    ASSERT_TRUE(parsed) << rate;
    const RawLayout& back = parsed->layout;
    EXPECT_EQ(back.rate, layout.rate);
    EXPECT_EQ(back.unit_bytes, 2U);
    ASSERT_EQ(back.lines.size(), layout.lines.size());
    for (std::size_t i = 0; i < back.lines.size(); ++i) {
      EXPECT_EQ(back.lines[i].name, layout.lines[i].name);
      EXPECT_EQ(back.lines[i].bit, i);
    }
  }
}

}  // namespace sr_metadata_test
}  // namespace biss::capture
