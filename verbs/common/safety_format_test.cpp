#include "verbs/common/safety_format.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/format_text.hpp"

namespace biss::verbs {
namespace format_test {

using testing::HasSubstr;

TEST(SafetyFormat, Configuration_BringsItsOwnSetup) {
  for (const SafetyConfiguration& each : safety_configurations) {
    const auto found = parse_safety_format(each.name);
    ASSERT_TRUE(found) << each.name;
    EXPECT_EQ(found->format, each.frame_format()) << each.name;
    EXPECT_EQ(found->setup, each.setup) << each.name;
  }
}

TEST(SafetyFormat, EveryCatalogueNameOfTwoWords_IsTaken) {
  std::size_t taken = 0;
  for (const CatalogueEntry& entry : catalogue) {
    const auto found = parse_safety_format(entry.name);
    ASSERT_EQ(found.has_value(), is_safety_format(entry.frame_format())) << entry.name;
    if (!found) continue;
    ++taken;
    EXPECT_EQ(found->format, entry.frame_format()) << entry.name;
  }
  EXPECT_GE(taken, 4U);
  const auto fortis = parse_safety_format("fortis-fs-36-28");
  ASSERT_TRUE(fortis);
  EXPECT_EQ(fortis->setup, find_safety_configuration("fs-36-28")->setup);
}

TEST(SafetyFormat, FirstConfigurationWithTheWords_IsImpliedWhateverItsCds) {
  const SafetyConfiguration& rsm = *find_safety_configuration("rsm");
  FrameFormat format = rsm.frame_format();
  EXPECT_EQ(implied_configuration("", format), &rsm);
  format.cds0 = !format.cds0;
  EXPECT_EQ(implied_configuration("", format), &rsm);
  EXPECT_EQ(implied_configuration("rlm", format), find_safety_configuration("rlm"));
  format.channel_list[0].position.bits = 1;
  EXPECT_EQ(implied_configuration("", format), nullptr);
}

TEST(SafetyFormat, Grammar_HasTheDefaultsOfTheSetup) {
  const std::string_view text = find_safety_configuration("rsm")->format;
  const auto found = parse_safety_format(text);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->format, parse_format(text).value());
  EXPECT_EQ(found->setup, SafetySetup{});
}

TEST(SafetyFormat, WhatCannotBeMonitored_IsTold) {
  for (const char* text : {"resolute-26", "pos26,nE,nW,crc6", "pos9,nE,crc6+pos9,nE,crc16"}) {
    EXPECT_FALSE(parse_safety_format(text)) << text;
    EXPECT_THAT(safety_format_error(text), HasSubstr("is neither a safety configuration")) << text;
  }
  EXPECT_FALSE(parse_safety_format("fs-36-29"));
  EXPECT_THAT(safety_format_error("fs-36-29"), HasSubstr("did you mean fs-36-28"));
}

}  // namespace format_test
}  // namespace biss::verbs
