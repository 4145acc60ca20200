#include "device/device_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/safety/configurations.hpp"

namespace biss {
namespace format_option_test {

using testing::HasSubstr;

std::string canonical(std::string_view text) {
  const auto choice = parse_device(text);
  if (!choice) return "error: " + choice.error();
  return std::string(format_text(choice->format).view());
}

TEST(FormatOption, Grammar_GivesTheFormatAndTheWidestTiming) {
  const auto choice = parse_device("mt12,st20,nE,nW,lc6,crc16");
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->format, parse_format("mt12,st20,nE,nW,lc6,crc16").value());
  EXPECT_EQ(choice->timing, DeviceTiming{});
  EXPECT_EQ(choice->entry, nullptr);
}

TEST(FormatOption, EveryCatalogueName_BringsFormatAndTiming) {
  for (const CatalogueEntry& entry : catalogue) {
    const auto choice = parse_device(entry.name);
    ASSERT_TRUE(choice) << entry.name;
    EXPECT_EQ(choice->entry, &entry);
    EXPECT_EQ(choice->format, parse_format(entry.format).value()) << entry.name;
    EXPECT_EQ(choice->timing, entry.timing) << entry.name;
  }
}

TEST(FormatOption, EverySafetyConfiguration_BringsFormatAndTiming) {
  for (const SafetyConfiguration& each : safety_configurations) {
    const auto choice = parse_device(each.name);
    ASSERT_TRUE(choice) << choice.error();
    EXPECT_EQ(choice->format, each.frame_format()) << each.name;
    EXPECT_EQ(choice->timing, each.timing) << each.name;
    EXPECT_EQ(choice->timing_known(), each.timing != DeviceTiming{}) << each.name;
    if (find_encoder(each.name) != nullptr) continue;
    EXPECT_EQ(choice->entry, nullptr) << each.name;
    EXPECT_EQ(choice->configuration, &each);
  }
}

TEST(FormatOption, TextOfAFormat_HasNoKnownTiming) {
  FormatArguments arguments;
  arguments.format = find_safety_configuration("fs-36-28")->format;
  arguments.ack_max = "16us";
  EXPECT_FALSE(choose_device(arguments)->timing_known());
  arguments.format = "bp3:0x621E";
  EXPECT_FALSE(choose_device(arguments)->timing_known());
}

TEST(FormatOption, ProfileIdentifier_GivesBp3sFormat) {
  EXPECT_EQ(canonical("bp3:0x621E"), "pos28,nE,nW,crc6");
  EXPECT_EQ(canonical("bp3:0x6239"), "pos55,nE,nW,crc6");
  EXPECT_EQ(canonical("bp3:0x631E"), "pos22,nE,nW,crc6");
  EXPECT_EQ(canonical("bp3:0x7330"), "pos24,nE,nW,lc6,crc16");
  EXPECT_EQ(canonical("bp3:0x7230"), "pos40,nE,nW,lc6,crc16");
  EXPECT_EQ(canonical("bp3:0x2814"),
            "error: format \"bp3:0x2814\": this identifier is of profile BP1, not of BP3");
  EXPECT_THAT(canonical("bp3:"), HasSubstr("a number like bp3:0x621E"));
  EXPECT_THAT(canonical("bp3:0x10000"), HasSubstr("at most 0xFFFF"));
  EXPECT_THAT(canonical("bp3:621E"), HasSubstr("a number like bp3:0x621E"));
}

TEST(FormatOption, Mistake_IsShownWithItsCharacterInOneLine) {
  EXPECT_EQ(
      canonical("pos26,nX,crc6"),
      "error: format \"pos26,nX,crc6\": no such item at character 7 (\"nX\"); items are posN, "
      "mtN, stN, padN, nE, nW, E, W, lcN, crcN");
  EXPECT_EQ(canonical("pos26,crc9"),
            "error: format \"pos26,crc9\": this CRC width has no usual polynomial at character 10 "
            "(\"9\"); write crcN:0x…");
  EXPECT_EQ(canonical("pos99"),
            "error: format \"pos99\": too many bits for this item at character 4 (\"99\")");
  EXPECT_EQ(
      canonical("pos26,"),
      "error: format \"pos26,\": no such item at the end; items are posN, mtN, stN, padN, nE, "
      "nW, E, W, lcN, crcN");
  EXPECT_THAT(canonical(""), HasSubstr("the format is empty; write items like"));
  EXPECT_THAT(canonical("pos26,,nE"), HasSubstr("at character 7 (\",\")"));
}

TEST(FormatOption, PolynomialWithoutItsTopOrLastBit_IsNamedInFullForm) {
  EXPECT_THAT(canonical("pos26,crc8:0x97"),
              HasSubstr("(\"0x97\"); write 0x197 with the top bit added or 0x12F with the last bit "
                        "added (the default of BiSS)"));
  EXPECT_THAT(canonical("pos26,crc6:0x21:0x3:plain"),
              HasSubstr("; write 0x61 with the top bit added or 0x43 with the last bit added (the "
                        "default of BiSS)"));
  EXPECT_THAT(canonical("pos26,crc16:0x1021"),
              testing::EndsWith("; write 0x11021 with the top bit added"));
  EXPECT_THAT(canonical("nE,crc4:0x3+pos5,crc5:0x5"),
              HasSubstr("write 0x13 with the top bit added (the default of BiSS)"));
  // Neither makes a full form.
  EXPECT_THAT(canonical("pos26,crc8:0x196"), testing::EndsWith("(\"0x196\")"));
  EXPECT_THAT(canonical("pos26,crc8:0x1E"), testing::EndsWith("(\"0x1E\")"));
}

TEST(FormatOption, ProfileIdentifierWithoutAPosition_IsRefused) {
  EXPECT_EQ(canonical("bp3:0x6202"),
            "error: format \"bp3:0x6202\": the data length 2 leaves no position");
  EXPECT_THAT(canonical("bp3:0x6308"), HasSubstr("leaves no position"));
  EXPECT_THAT(canonical("bp3:0x7208"), HasSubstr("leaves no position"));
  EXPECT_THAT(canonical("bp3:0x7318"), HasSubstr("leaves no position"));
  EXPECT_EQ(canonical("bp3:0x6203"), "pos1,nE,nW,crc6");
}

TEST(FormatOption, LongText_IsCutInTheError) {
  const std::string error = canonical("pos26," + std::string(100'000, 'x'));
  EXPECT_LT(error.size(), 250U);
  EXPECT_THAT(error, HasSubstr("..."));
  EXPECT_LT(canonical(std::string(100'000, 'x')).size(), 250U);
}

TEST(FormatOption, NearlyACatalogueName_GetsASuggestion) {
  EXPECT_THAT(canonical("resolut-26"), HasSubstr("did you mean resolute-26?"));
  EXPECT_THAT(canonical("RESOLUTE-26"), HasSubstr("did you mean resolute-26?"));
  EXPECT_THAT(canonical("resolute"),
              HasSubstr("did you mean resolute-18, resolute-26, resolute-32?"));
  EXPECT_THAT(canonical("RSM"), HasSubstr("did you mean rsm?"));
  EXPECT_THAT(canonical("banana"), testing::Not(HasSubstr("did you mean")));
  EXPECT_THAT(canonical("banana"), HasSubstr("'biss encoders' lists the names"));
}

TEST(FormatOption, SingleTimingOptions_OverrideTheCatalogue) {
  const auto choice = choose_device({.format = "resolute-26",
                                     .ack_max = "20us",
                                     .ack_clocks = "",
                                     .timeout = "static:20us",
                                     .release = "4",
                                     .clock_max = "4MHz",
                                     .cycle_min = "50us"});
  ASSERT_TRUE(choice) << choice.error();
  const DeviceTiming& timing = choice->timing;
  EXPECT_EQ(timing.ack_max, microseconds(20));
  EXPECT_EQ(timing.timeout, (Timeout{TimeoutRule::fixed, microseconds(20), 4}));
  EXPECT_EQ(timing.clock_max, megahertz(4));
  EXPECT_EQ(timing.cycle_min, microseconds(50));
  EXPECT_EQ(timing.internal_delay_max, picoseconds(42'500));
}

std::string timing_error(const FormatArguments& arguments) {
  const auto device = choose_device(arguments);
  return device ? "" : device.error();
}

FormatArguments with_timeout(std::string timeout) {
  FormatArguments arguments;
  arguments.format = "lenz-b3";
  arguments.timeout = std::move(timeout);
  return arguments;
}

TEST(TimingOptions, EachTimeoutRule_IsReadAndPrintedBack) {
  for (const char* const text :
       {"adaptive", "adaptive:680ns", "static:20us", "cycle:31.25us", "static:12.5us"}) {
    const auto choice = choose_device(with_timeout(text));
    ASSERT_TRUE(choice) << choice.error();
    EXPECT_EQ(text_of(choice->timing.timeout), text);
  }
}

TEST(TimingOptions, WrongTimeout_SaysWhatToWrite) {
  EXPECT_EQ(timing_error(with_timeout("static")),
            "--timeout \"static\": no such rule; write adaptive, static:20us or cycle:31.25us");
  EXPECT_THAT(timing_error(with_timeout("fixed:20us")), HasSubstr("no such rule"));
  EXPECT_THAT(timing_error(with_timeout("cycle:31.25")), HasSubstr("no unit"));
  EXPECT_THAT(timing_error(with_timeout("static:-1us")), HasSubstr("negative"));
}

FormatArguments with_ack(std::string max, std::string clocks) {
  FormatArguments arguments;
  arguments.format = "lenz-b3";
  arguments.ack_max = std::move(max);
  arguments.ack_clocks = std::move(clocks);
  return arguments;
}

TEST(TimingOptions, Ack_IsBoundedOrFixed) {
  const auto bounded = choose_device(with_ack("5us", ""));
  ASSERT_TRUE(bounded);
  EXPECT_EQ(bounded->timing.ack_clocks, 0);
  EXPECT_EQ(bounded->timing.ack_max, microseconds(5));
  const auto fixed = choose_device(with_ack("", "7"));
  ASSERT_TRUE(fixed);
  EXPECT_EQ(fixed->timing.ack_clocks, 7);
  EXPECT_THAT(timing_error(with_ack("5us", "7")), HasSubstr("exclude each other"));
  EXPECT_THAT(timing_error(with_ack("", "0")), HasSubstr("from 1 to 400"));
  EXPECT_THAT(timing_error(with_ack("", "401")), HasSubstr("from 1 to 400"));
  EXPECT_THAT(timing_error(with_ack("", "x")), HasSubstr("from 1 to 400"));
  EXPECT_THAT(timing_error(with_ack("41us", "")), HasSubstr("BiSS C allows 40 us"));
  EXPECT_THAT(timing_error(with_ack("5", "")), HasSubstr("no unit"));
}

TEST(TimingOptions, WrongClockOrCycle_NamesTheOption) {
  FormatArguments arguments;
  arguments.format = "resolute-26";
  arguments.clock_max = "100kHz";
  EXPECT_EQ(timing_error(arguments),
            "--clock-max '100kHz': below the device's lowest clock of 250 kHz");
  arguments.clock_max = "4Mhz";
  EXPECT_THAT(timing_error(arguments), HasSubstr("--clock-max '4Mhz'"));
  arguments.clock_max = "";
  arguments.cycle_min = "1,5us";
  EXPECT_THAT(timing_error(arguments), HasSubstr("--cycle-min '1,5us'"));
}

}  // namespace format_option_test
}  // namespace biss
