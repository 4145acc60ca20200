#include "verbs/eds/value.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "biss/eds/bp3_part.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/image.hpp"

namespace biss::verbs {
namespace value_test {

using testing::HasSubstr;

const EdsField& common(std::string_view symbol) { return *find_field(common_fields, symbol); }
const EdsField& bp3(std::string_view symbol) { return *find_field(bp3_fields, symbol); }

std::uint32_t good(const EdsField& field, std::string_view text, bool linear = false) {
  const auto value = parse_eds_value(field, text, linear);
  EXPECT_TRUE(value.has_value()) << text << ": " << value.error();
  return value.value_or(0);
}

std::string wrong(const EdsField& field, std::string_view text, bool linear = false) {
  const auto value = parse_eds_value(field, text, linear);
  return value ? "" : value.error();
}

TEST(EdsValue, NumbersNamesAndUnits_AreRead) {
  EXPECT_EQ(good(bp3("MT_LEN"), "12"), 12U);
  EXPECT_EQ(good(bp3("MT_LEN"), "0x0C"), 12U);
  EXPECT_EQ(good(bp3("MT_LEN"), " 12 bit "), 12U);
  EXPECT_EQ(good(bp3("TMP_MIN"), "233K"), 233U);
  EXPECT_EQ(good(bp3("EN_TYP"), "linear"), 1U);
  EXPECT_EQ(good(bp3("EN_TYP"), "7"), 7U);
  EXPECT_EQ(good(bp3("POS_NUM"), "position 2"), 2U);
  EXPECT_EQ(good(bp3("MT_FMT"), "left"), 1U);
  EXPECT_EQ(good(bp3("FB1"), "nE"), 1U);
  EXPECT_EQ(good(bp3("SIP_CNT"), "20000 nm", true), 20000U);
  EXPECT_EQ(good(bp3("SPD_MAX"), "100 m/min", true), 100U);
  EXPECT_EQ(good(bp3("MT_CNT"), "0xFFFFFFFE"), 0xFFFFFFFEU);
  EXPECT_EQ(good(common("EDS_LEN"), "1 bank"), 1U);
}

TEST(EdsValue, TimeOfACertainUnit_IsAWholeNumberOfSteps) {
  EXPECT_EQ(good(common("TMA"), "100ns"), 100U);
  EXPECT_EQ(good(common("TMA"), "0.2us"), 200U);
  EXPECT_THAT(wrong(common("TMA"), "100.5ns"), HasSubstr("not a whole number of steps of 1 ns"));
  EXPECT_THAT(wrong(common("TMA"), "1us"), HasSubstr("at most 255"));
}

TEST(EdsValue, TimeOfAHypothesis_NeedsTheQuestionMark) {
  EXPECT_EQ(good(common("TO_MAX"), "20us?"), 80U);
  EXPECT_EQ(good(common("TO_MAX"), "80"), 80U);
  EXPECT_EQ(good(common("PON_DLY"), "100 ms ?"), 100U);
  EXPECT_THAT(wrong(common("TO_MAX"), "20us"), HasSubstr("counts steps of 250 ns"));
}

TEST(EdsValue, Mistakes_AreSaid) {
  EXPECT_THAT(wrong(bp3("MT_LEN"), "256"), HasSubstr("too large; 1 byte holds at most 255"));
  EXPECT_THAT(wrong(bp3("MT_LEN"), "12 bytes"), HasSubstr("the unit is bit, not 'bytes'"));
  EXPECT_THAT(wrong(bp3("MT_CNT"), "12 bit"), HasSubstr("a number without unit, not 'bit'"));
  EXPECT_THAT(wrong(bp3("SIP_CNT"), "5 nm"), HasSubstr("the unit is PPR"));
  EXPECT_THAT(wrong(bp3("EN_TYP"), "round"), HasSubstr("rotary, linear"));
  EXPECT_THAT(wrong(bp3("MT_LEN"), "-1"), HasSubstr("a number"));
  EXPECT_THAT(wrong(bp3("MT_LEN"), ""), HasSubstr("a number"));
  EXPECT_THAT(wrong(common("TMA"), "fast"), HasSubstr("'fast'"));
}

// Every stored value can be printed and parsed again.
TEST(EdsValue, EveryValueOfEveryField_ReadsBack) {
  for (const EdsPart part : {EdsPart::common, EdsPart::bp3}) {
    for (const EdsField& field : fields_of(part)) {
      for (std::uint32_t value = 0; value < 256; ++value) {
        const std::array values{value, value << 8U, value << 24U, ~value};
        for (const std::uint32_t each : values) {
          const std::uint32_t stored = each & field.all_ones();
          for (const bool linear : {false, true}) {
            const std::string text = eds_value_text(field, stored, linear);
            ASSERT_EQ(good(field, text, linear), stored) << field.symbol << " = " << text;
          }
        }
      }
    }
  }
}

TEST(EdsValue, Meanings_MarkHypotheses) {
  EXPECT_EQ(eds_meaning(common("TMA"), 100, false), "100 ns");
  EXPECT_EQ(eds_meaning(common("TO_MAX"), 80, false), "20 us ?");
  EXPECT_EQ(eds_meaning(bp3("CPOLY"), 0x21, false), "0x43");
  EXPECT_EQ(eds_meaning(bp3("BP_ID"), 0x621E, false), "0x621E: BP3 version 1, C = 0, DL = 30");
  EXPECT_EQ(eds_meaning(bp3("TMP_MIN"), 233, false), "233 K, -40 degrees Celsius");
  EXPECT_EQ(eds_meaning(bp3("HYST"), 0xFFFF, false), "not given ?");
  EXPECT_EQ(eds_meaning(common("FORMAT_0"), 0x0B, false),
            "actuator, left-aligned, leading stop bit");
  EXPECT_EQ(eds_meaning(common("BC_OFF"), 0x13, false), "slave 3");
}

}  // namespace value_test
}  // namespace biss::verbs
