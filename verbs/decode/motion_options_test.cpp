#include "verbs/decode/motion_options.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "biss/catalogue/catalogue.hpp"

namespace biss::verbs {
namespace scale_test {

TEST(ScaleOfTheCatalogue, LinearEncoders_AreThoseWithOneSizeOfACount) {
  std::map<std::string_view, double> nanometres;
  for (const CatalogueEntry& entry : catalogue) {
    const auto scale = scale_of(entry);
    if (scale && scale->unit == "mm") nanometres[entry.name] = std::round(scale->per_count * 1e6);
  }
  const std::map<std::string_view, double> expected{
      {"resolute-linear-26", 50}, {"resolute-linear-36", 1}, {"fortis-26", 50},
      {"fortis-32", 10},          {"fs-28-24", 50},          {"fs-36-28", 1}};
  EXPECT_EQ(nanometres, expected);
}

TEST(ScaleOfTheCatalogue, CountsOfATurn_AreTheSingleturnBits) {
  std::size_t rotary = 0;
  for (const CatalogueEntry& entry : catalogue) {
    const auto scale = scale_of(entry);
    if (!scale || scale->unit != "deg") continue;
    const FrameFormat format = entry.frame_format();
    const ChannelFormat& channel = format.channel_list[0];
    const unsigned bits =
        channel.singleturn.present() ? channel.singleturn.bits : channel.position_bits();
    EXPECT_EQ(360.0 / scale->per_count, std::exp2(bits)) << entry.name << ": " << entry.resolution;
    ++rotary;
  }
  EXPECT_GT(rotary, 20U);
}

// The unit of the column that `--scale` adds; empty if it adds none.
std::string unit_of(const char* text) {
  MotionArguments arguments;
  arguments.scale = text;
  return arguments.columns().unit;
}

TEST(ScaleOfAnOption, TextThatIsNone_HasNoUnit) {
  EXPECT_EQ(unit_of("deg"), "deg");
  EXPECT_EQ(unit_of("36000/turn"), "deg");
  EXPECT_EQ(unit_of("2^63/turn"), "deg");
  EXPECT_EQ(unit_of("0.5um"), "mm");
  EXPECT_EQ(unit_of("1e3 nm"), "mm");
  for (const char* text :
       {"", "rad", "2^26", "2^/turn", "2^64/turn", "2^-1/turn", "0/turn", "1.5/turn", "inf/turn",
        "nan nm", "50", "50 m", "-1nm", "1nm ", "/turn"}) {
    EXPECT_EQ(unit_of(text), "") << text;
  }
}

}  // namespace scale_test
}  // namespace biss::verbs
