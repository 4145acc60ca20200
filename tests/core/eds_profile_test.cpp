#include "biss/eds/profile.hpp"

#include "biss/frame/format_text.hpp"
#include "tests/core/test.hpp"

namespace biss::eds_profile_test {

static_assert(format_text(profile_format(0x621E).value()).view() == "pos28,nE,nW,crc6");

constexpr ProfileOptions not_counted{.length_counts_crc = false};

bool gives(std::uint16_t identifier, std::string_view text, const ProfileOptions& options = {}) {
  const auto format = profile_format(identifier, options);
  return format.ok() && format_text(*format).view() == text;
}

BISS_TEST(Profile, EveryIdentifier_IsAFormatOrACause) {
  std::uint32_t formats = 0;
  for (std::uint32_t id = 0; id <= 0xFFFF; ++id) {
    const auto format = profile_format(static_cast<std::uint16_t>(id));
    const unsigned high = id >> 8U;
    const unsigned low = id & 0xFFU;
    const bool bp0 = high >= 1 && high <= 31 && low < 0x80;
    const bool bp1 = id == 0x2814 || id == 0x2C0C;
    const bool bp3 =
        (high == 0x62 && low >= 2 && low <= 57) || (high == 0x63 && low >= 8 && low <= 63);
    const bool bp3s =
        (high == 0x72 && low >= 8 && low <= 48) || (high == 0x73 && low >= 24 && low <= 64);
    BISS_ASSERT_EQ(format.ok(), bp0 || bp1 || bp3 || bp3s) << id;
    if (!format.ok()) continue;
    ++formats;
    if (bp0 && low != 0) continue;  // 128 numbers of the application, one format
    const auto again = parse_format(format_text(*format).view());
    BISS_ASSERT(again.ok()) << id;
    BISS_EXPECT(*again == *format) << id;
    const std::string_view doubt = doubt_of(ProfileIdentifier{static_cast<std::uint16_t>(id)});
    BISS_EXPECT_EQ(doubt.empty(), high == 0x62) << id;
  }
  BISS_EXPECT_EQ(formats, 31U * 128U + 2U + 56U + 56U + 41U + 41U);
}

BISS_TEST(Profile, Bp3_IsPositionFlagsAndCrc) {
  for (unsigned length = 2; length <= 57; ++length) {
    const auto id = static_cast<std::uint16_t>(0x6200U | length);
    const auto channel = profile_channel(id);
    BISS_ASSERT(channel.ok());
    BISS_EXPECT_EQ(channel->total_bits(), length + 6) << id;
    BISS_EXPECT_EQ(channel->position_bits(), length - 2) << id;
    BISS_EXPECT_EQ(profile_identifier(*channel, Profile::bp3, false).value(), id);
  }
  BISS_EXPECT(gives(0x6202, "nE,nW,crc6"));
  BISS_EXPECT(gives(0x6239, "pos55,nE,nW,crc6"));
}

BISS_TEST(Profile, CSet_LengthCountsTheCrcAndTheCrcIsChecked) {
  BISS_EXPECT(gives(0x631E, "pos22,nE,nW,crc6"));
  BISS_EXPECT(gives(0x6324, "pos28,nE,nW,crc6"));
  BISS_EXPECT(gives(0x633F, "pos55,nE,nW,crc6"));
  BISS_EXPECT(gives(0x6308, "nE,nW,crc6"));
  BISS_EXPECT(gives(0x631E, "pos28,nE,nW,crc6", not_counted));
  for (unsigned length = 8; length <= 63; ++length) {
    const auto id = static_cast<std::uint16_t>(0x6300U | length);
    const auto channel = profile_channel(id);
    BISS_ASSERT(channel.ok());
    BISS_EXPECT_EQ(channel->total_bits(), length);
    BISS_EXPECT_EQ(channel->position_bits(), length - 8);
    BISS_EXPECT(channel->crc == crc6);
    BISS_EXPECT_EQ(profile_identifier(*channel, Profile::bp3, true).value(), id);
  }
}

BISS_TEST(Profile, StatedCrc_IsTheOneThatTheLengthCounts) {
  constexpr CrcSpec wide{.polynomial = 0x11021, .start = 0x1D0F, .width_bits = 16};
  BISS_EXPECT(gives(0x6324, "pos18,nE,nW,crc16:0x11021:0x1D0F", {.crc = wide}));
  BISS_EXPECT(gives(0x621E, "pos28,nE,nW,crc16:0x11021:0x1D0F", {.crc = wide}));
  BISS_EXPECT(gives(0x7330, "pos24,nE,nW,lc6,crc16:0x11021:0x1D0F", {.crc = wide}));
  BISS_EXPECT_EQ(profile_channel(0x6308, {.crc = wide}).error(), ProfileError::crc_does_not_fit);
}

BISS_TEST(Profile, Bp3s_HasTheSignOfLifeAndCrc16) {
  BISS_EXPECT(gives(0x7220, "pos24,nE,nW,lc6,crc16"));
  BISS_EXPECT(gives(0x7330, "pos24,nE,nW,lc6,crc16"));
  BISS_EXPECT(gives(0x7330, "pos40,nE,nW,lc6,crc16", not_counted));
  BISS_EXPECT(bp3s_crc.polynomial == 0x190D9 && bp3s_crc.start == 0);
  for (unsigned length = 8; length <= 48; ++length) {
    const auto id = static_cast<std::uint16_t>(0x7200U | length);
    BISS_EXPECT_EQ(profile_identifier(profile_channel(id).value(), Profile::bp3s, false).value(),
                   id);
    const auto data = static_cast<std::uint16_t>(0x7300U | (length + 16U));
    BISS_EXPECT_EQ(profile_identifier(profile_channel(data).value(), Profile::bp3s, true).value(),
                   data);
  }
}

BISS_TEST(Profile, Bp0AndBp1_SayWhatIsKnown) {
  BISS_EXPECT(gives(0x0C00, "pad12,crc5"));
  BISS_EXPECT(gives(0x1F7F, "pad31,crc5"));
  BISS_EXPECT_EQ(profile_format(0x0C80).error(), ProfileError::actuator);
  BISS_EXPECT_EQ(profile_format(0x0012).error(), ProfileError::no_channel);
  BISS_EXPECT(gives(0x2814, "pos24,nE,nW,crc6"));
  BISS_EXPECT(gives(0x2C0C, "pos12,nE,nW,crc6"));
  BISS_EXPECT_EQ(profile_format(0x2815).error(), ProfileError::bp1_layout);
  const ProfileIdentifier universal{0x0CA5};
  BISS_EXPECT_EQ(universal.profile(), Profile::bp0);
  BISS_EXPECT_EQ(universal.data_length(), 12);
  BISS_EXPECT(universal.actuator());
}

BISS_TEST(Profile, WrongIdentifiers_SayWhatIsWrong) {
  BISS_EXPECT_EQ(profile_format(0x0000).error(), ProfileError::none_given);
  BISS_EXPECT_EQ(profile_format(0x4214).error(), ProfileError::unknown_profile);
  BISS_EXPECT_EQ(profile_format(0x821E).error(), ProfileError::unknown_profile);
  BISS_EXPECT_EQ(profile_format(0xFFFF).error(), ProfileError::unknown_profile);
  BISS_EXPECT_EQ(profile_format(0x601E).error(), ProfileError::version);
  BISS_EXPECT_EQ(profile_format(0x641E).error(), ProfileError::version);
  BISS_EXPECT_EQ(profile_format(0x741E).error(), ProfileError::version);
  BISS_EXPECT_EQ(profile_format(0x629E).error(), ProfileError::reserved_bit);
  BISS_EXPECT_EQ(profile_format(0x6201).error(), ProfileError::data_length);
  BISS_EXPECT_EQ(profile_format(0x623A).error(), ProfileError::data_length);
  BISS_EXPECT_EQ(profile_format(0x6301).error(), ProfileError::data_length);
  BISS_EXPECT_EQ(profile_format(0x6340).error(), ProfileError::data_length);
  BISS_EXPECT_EQ(profile_format(0x6307).error(), ProfileError::crc_does_not_fit);
  BISS_EXPECT_EQ(profile_format(0x7207).error(), ProfileError::crc_does_not_fit);
  BISS_EXPECT_EQ(profile_format(0x7231).error(), ProfileError::data_length);
  BISS_EXPECT_EQ(profile_format(0x633A, not_counted).error(), ProfileError::data_length);
  for (std::size_t i = 0; i < profile_error_count; ++i) {
    BISS_EXPECT(!text_of(static_cast<ProfileError>(i)).empty());
  }
}

BISS_TEST(Profile, Formats_HaveTheirIdentifierOrNone) {
  const auto of = [](std::string_view text, Profile profile, bool data = false) {
    return profile_identifier(parse_format(text)->channel_list[0], profile, data);
  };
  BISS_EXPECT_EQ(of("mt12,st20,nE,nW,crc6", Profile::bp3).value(), 0x6222);
  BISS_EXPECT_EQ(of("mt12,nE,nW,crc6", Profile::bp3).value(), 0x620E);
  BISS_EXPECT_EQ(of("pos26,nE,nW,crc6", Profile::bp3).value(), 0x621C);
  BISS_EXPECT_EQ(of("pos26,nE,nW,crc6", Profile::bp3, true).value(), 0x6322);
  BISS_EXPECT_EQ(of("mt12,st12,nE,nW,lc6,crc16", Profile::bp3s, true).value(), 0x7330);
  for (const std::string_view other :
       {"pos26,nW,nE,crc6", "pos26,E,nW,crc6", "pos26,nE,nW,crc6:0x67", "pos26,nE,nW,crc6:plain",
        "pos26,nE,nW,crc6:0x43:0x1", "pos26,nE,nW,crc5", "mt12,pad2,st12,nE,nW,crc6", "pos26,nE,nW",
        "mt12,st12:gray,nE,nW,crc6", "nE,nW,pos26,crc6"}) {
    BISS_EXPECT_EQ(of(other, Profile::bp3).error(), ProfileError::other_bits);
  }
  BISS_EXPECT_EQ(of("pos56,nE,nW,crc6", Profile::bp3).error(), ProfileError::data_length);
  BISS_EXPECT_EQ(of("pos26,nE,nW,crc6", Profile::bp3s).error(), ProfileError::other_bits);
  BISS_EXPECT_EQ(of("pos26,nE,nW,pad6,crc16", Profile::bp3s).error(), ProfileError::other_bits);
  BISS_EXPECT_EQ(of("pos26,nE,nW,crc6", Profile::bp1).error(), ProfileError::unknown_profile);
}

}  // namespace biss::eds_profile_test
