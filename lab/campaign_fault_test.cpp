#include "lab/campaign_fault.hpp"

#include <gtest/gtest.h>

#include "lab/campaign_damage.hpp"

namespace biss::lab {
namespace {

TEST(CampaignFault, Texts_ComeBackAsTheyWere) {
  for (const char* text :
       {"flips:0.5", "flips:0.25:0.125", "flips:0.01:0.1", "flips:0.5:fitting", "burst:16",
        "burst:2:7", "lost_clock", "double_clock:3", "slo_low:0", "slo_high:103", "inserted_low",
        "inserted_high:7", "gap_low:1", "gap_high:8:3", "late_start", "early_start:2", "cds_high",
        "stop_high"}) {
    const auto fault = parse_fault(text);
    ASSERT_TRUE(fault) << text;
    EXPECT_EQ(text_of(*fault), text);
  }
}

TEST(CampaignFault, RatesThatAreNoPartOf2To32_ParseToTheSameAgain) {
  for (const char* text : {"flips:0.01", "flips:0.1:0.3", "flips:1e-9", "flips:2.3283064e-10"}) {
    const auto fault = parse_fault(text);
    ASSERT_TRUE(fault) << text;
    EXPECT_EQ(parse_fault(text_of(*fault)), fault) << text_of(*fault);
  }
}

TEST(CampaignFault, TextThatIsNoFault_IsRefused) {
  for (const char* text : {"",
                           "flip:0.1",
                           "flips",
                           "flips:0",
                           "flips:0.6",
                           "flips:nan",
                           "flips:-0.1",
                           "flips:0.1:",
                           "flips:0.1:0.2:0.3",
                           "flips:0.1:fit",
                           "flips:0.1:fitting:0.1",
                           "burst",
                           "burst:1",
                           "burst:33",
                           "burst:4:x",
                           "lost_clock:1:2",
                           "slo_low:",
                           "slo_high:-1",
                           "burst:16 ",
                           "gap_low",
                           "gap_high:0",
                           "gap_low:33",
                           "late_start:1",
                           "cds_high:0",
                           "stop_high:"}) {
    EXPECT_FALSE(parse_fault(text)) << text;
  }
}

// 10110 and STOP = 0, so that each fault shows.
constexpr LineWord line = 0b101100;

LineWord after(const char* text, unsigned place, std::uint64_t pattern = 0) {
  return damaged(line, 6, *parse_fault(text), place, pattern);
}

TEST(CampaignDamage, EachFault_ChangesWhatItSays) {
  EXPECT_EQ(after("lost_clock", 1) == 0b111000, true);
  EXPECT_EQ(after("double_clock", 1) == 0b100110, true);
  EXPECT_EQ(after("slo_low", 2) == 0b100000, true);
  EXPECT_EQ(after("slo_high", 2) == 0b101111, true);
  EXPECT_EQ(after("burst:4", 0, 0b10) == (line ^ 0b110100), true);
  EXPECT_EQ(after("burst:4", 1, 0b01) == (line ^ 0b010110), true);
  EXPECT_EQ(after("inserted_low", 0) == 0b010110, true);
  EXPECT_EQ(after("inserted_high", 1) == 0b110110, true);
  EXPECT_EQ(after("gap_low:2", 2) == 0b100000, true);
  EXPECT_EQ(after("gap_high:3", 1) == 0b111100, true);
  EXPECT_EQ(after("gap_high:9", 4) == 0b101111, true);
  EXPECT_EQ(after("stop_high", 0) == 0b101101, true);
  EXPECT_EQ(after("burst:2", 3) == (line ^ 0b000110), true);
}

}  // namespace
}  // namespace biss::lab
