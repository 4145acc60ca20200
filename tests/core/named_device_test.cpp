// What a text stands for: names, profile identifiers, formats, and what is none of them.
#include "biss/configure/named_device.hpp"

#include "tests/core/test.hpp"

namespace named_device_test {

using namespace biss;

TEST(NamedDevice, NameOfTheCatalogue_HasItsTiming) {
  const auto device = read_device("resolute-26");
  ASSERT_TRUE(device.ok());
  EXPECT_TRUE(device->entry == find_encoder("resolute-26"));
  EXPECT_TRUE(device->configuration == nullptr);
  EXPECT_TRUE(device->timing_known());
  EXPECT_TRUE(device->format == device->entry->frame_format());
}

TEST(NamedDevice, NameOfASafetyConfiguration_HasItsFormat) {
  const auto device = read_device("rsm");
  ASSERT_TRUE(device.ok());
  EXPECT_TRUE(device->entry == nullptr);
  ASSERT_TRUE(device->configuration != nullptr);
  EXPECT_TRUE(device->format == device->configuration->frame_format());
}

TEST(NamedDevice, ProfileIdentifier_IsAFormatWithoutTiming) {
  for (const std::string_view text : {"bp3:0x621E", "bp3:0X621e", "bp3:25118"}) {
    const auto device = read_device(text);
    ASSERT_TRUE(device.ok());
    EXPECT_TRUE(device->format == *profile_format(0x621E));
    EXPECT_FALSE(device->timing_known());
  }
}

TEST(NamedDevice, NoDevice_SaysWhy) {
  struct Case {
    std::string_view text;
    DeviceMistake mistake;
  };
  constexpr Case cases[] = {
      {"resolut", DeviceMistake::name},          {"", DeviceMistake::item},
      {"pos26,nX", DeviceMistake::item},         {"bp3:", DeviceMistake::identifier},
      {"bp3:0x", DeviceMistake::identifier},     {"bp3:0x1621E", DeviceMistake::identifier},
      {"bp3:62G", DeviceMistake::identifier},    {"bp3:-1", DeviceMistake::identifier},
      {"bp3:0", DeviceMistake::profile},         {"bp3:0x0A00", DeviceMistake::other_profile},
      {"bp3:0x6202", DeviceMistake::no_position}};
  for (const Case& each : cases) {
    const auto device = read_device(each.text);
    ASSERT_FALSE(device.ok());
    EXPECT_TRUE(device.error().mistake == each.mistake);
    EXPECT_FALSE(text_of(device.error()).empty());
  }
}

}  // namespace named_device_test
