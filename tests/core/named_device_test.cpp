// What a text stands for: names, profile identifiers, formats, and what is none of them.
#include "biss/configure/named_device.hpp"

#include "tests/core/test.hpp"

namespace named_device_test {

using namespace biss;

BISS_TEST(NamedDevice, NameOfTheCatalogue_HasItsTiming) {
  const auto device = read_device("resolute-26");
  BISS_ASSERT(device.ok());
  BISS_EXPECT(device->entry == find_encoder("resolute-26"));
  BISS_EXPECT(device->configuration == nullptr);
  BISS_EXPECT(device->timing_known());
  BISS_EXPECT(device->format == device->entry->frame_format());
}

BISS_TEST(NamedDevice, NameOfASafetyConfiguration_HasItsFormat) {
  const auto device = read_device("rsm");
  BISS_ASSERT(device.ok());
  BISS_EXPECT(device->entry == nullptr);
  BISS_ASSERT(device->configuration != nullptr);
  BISS_EXPECT(device->format == device->configuration->frame_format());
}

BISS_TEST(NamedDevice, ProfileIdentifier_IsAFormatWithoutTiming) {
  for (const std::string_view text : {"bp3:0x621E", "bp3:0X621e", "bp3:25118"}) {
    const auto device = read_device(text);
    BISS_ASSERT(device.ok());
    BISS_EXPECT(device->format == *profile_format(0x621E));
    BISS_EXPECT(!device->timing_known());
  }
}

BISS_TEST(NamedDevice, NoDevice_SaysWhy) {
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
    BISS_ASSERT(!device.ok());
    BISS_EXPECT(device.error().mistake == each.mistake);
    BISS_EXPECT(!text_of(device.error()).empty());
  }
}

}  // namespace named_device_test
