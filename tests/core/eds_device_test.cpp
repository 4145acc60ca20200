#include "biss/eds/device.hpp"

#include "biss/eds/advise.hpp"
#include "biss/eds/check.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/format_text.hpp"
#include "tests/core/eds_banks.hpp"
#include "tests/core/test.hpp"

namespace biss::eds_device_test {

using enum EdsRemarkKind;

struct Remarks {
  std::array<EdsRemark, 24> list{};
  std::size_t count = 0;
  void operator()(const EdsRemark& remark) {
    if (count < list.size()) list[count] = remark;
    ++count;
  }
  const EdsRemark* find(std::string_view symbol, EdsRemarkKind kind) const {
    for (std::size_t i = 0; i < count && i < list.size(); ++i) {
      if (list[i].symbol == symbol && list[i].kind == kind) return &list[i];
    }
    return nullptr;
  }
  bool has(std::string_view symbol, EdsRemarkKind kind, std::uint32_t stored,
           std::uint32_t used) const {
    const EdsRemark* found = find(symbol, kind);
    return found != nullptr && found->stored == stored && found->used == used;
  }
};

EdsImage image_of(const EdsBank* common, const EdsBank* profile,
                  std::optional<std::uint16_t> identifier = {}) {
  EdsImage image{.common = common};
  image.profiles[0] = profile;
  image.identifiers[0] = identifier;
  return image;
}

EdsBank with(EdsBank bank, EdsPart part, std::string_view symbol, std::uint32_t value) {
  BISS_EXPECT(set_field(bank, *find_field(fields_of(part), symbol), value));
  return sealed(bank);
}

struct Described {
  Result<EdsDevice, EdsDeviceError> device;
  Remarks remarks;
  bool is(std::string_view format) const {
    return device.ok() && format_text(device->format).view() == format;
  }
};

Described describe(const EdsImage& image, std::span<const EdsOverride> overrides = {}) {
  Remarks remarks;
  const auto device = describe_device(image, overrides, remarks);
  return {device, remarks};
}

static_assert(describe_device(EdsImage{.common = &test::one_channel,
                                       .profiles = {&test::multiturn_12_20}},
                              {}, [](const EdsRemark&) {})
                  ->format == parse_format("mt12,st20,nE,nW,crc6").value());

BISS_TEST(EdsDevice, WholeSheet_GivesFormatAndTiming) {
  const Described all = describe(image_of(&test::one_channel, &test::multiturn_12_20, 0x6222));
  BISS_ASSERT(all.is("mt12,st20,nE,nW,crc6"));
  const EdsDevice& device = *all.device;
  BISS_EXPECT(device.timing.clock_max == megahertz(10));
  BISS_EXPECT(device.timing.clock_min == biss_clock_min);
  BISS_EXPECT(device.timing.ack_max == microseconds(16));
  BISS_EXPECT(device.timing.timeout.rule == TimeoutRule::adaptive);
  BISS_EXPECT(device.timing.timeout.time == nanoseconds(60));
  BISS_EXPECT(device.timing.cycle_min == nanoseconds(31'250));
  BISS_EXPECT_EQ(device.busy_s_clocks, 3);
  BISS_EXPECT_EQ(device.slaves, 1);
  BISS_EXPECT(device.control_ready == milliseconds(250));
  BISS_EXPECT(device.position_ready == milliseconds(100));
  BISS_EXPECT_EQ(all.remarks.count, 4U);  // four times in units that are hypotheses
  for (const std::string_view symbol : {"TBUSY_MAX", "TCLK_MAX", "TCYC", "PON_DLY"}) {
    BISS_EXPECT(all.remarks.find(symbol, hypothesis) != nullptr);
  }
  BISS_EXPECT(timing_at(device, megahertz(1)).ack_max == microseconds(19));
  BISS_EXPECT(timing_at(device, kilohertz(100)).ack_max == biss_busy_max);
}

BISS_TEST(EdsDevice, EveryGoodBp3Bank_GivesItsFormat) {
  constexpr std::array banks{&test::rotary_18, &test::multiturn_odd, &test::linear_36,
                             &test::linear_26, &test::longest_55,    &test::safety_cpw,
                             &test::shortest_0};
  constexpr std::array<std::string_view, banks.size()> formats{
      "pos18,nE,nW,crc6",          "mt10,st16,nE,nW,crc6", "pos36,nE,nW,crc6", "pos26,nE,nW,crc6",
      "mt24,st30,pad1,nE,nW,crc6", "mt12,st16,nE,nW,crc6", "nE,nW,crc6"};
  for (std::size_t i = 0; i < banks.size(); ++i) {
    const Described said = describe(image_of(nullptr, banks[i]));
    BISS_EXPECT(said.is(formats[i])) << i;
    BISS_EXPECT_EQ(said.remarks.count, 0U) << i;
  }
}

// A bank with MT_LEN, CO_LEN and FI_LEN of 12, 10 and 14 bits, or as given.
EdsBank spare(Bp3Part part) {
  if (part.position_bits() == 0) {
    part.mt_len = 12;
    part.co_len = 10;
    part.fi_len = 14;
  }
  part.bp_id = static_cast<std::uint16_t>(0x6200U + part.position_bits() + 2U);
  return sealed(build_bank(part));
}

BISS_TEST(EdsDevice, FieldsLongerThanTheirCounts_HavePaddingWhereTheAlignmentSays) {
  struct Case {
    Bp3Part part;
    std::string_view format;
  };
  const std::array cases{
      // Turns: 256 in 12 bits.
      Case{{.mt_fmt = 0, .mt_cnt = 256}, "pad4,mt8,st24,nE,nW,crc6"},
      Case{{.mt_fmt = 1, .mt_cnt = 256}, "mt8,pad4,st24,nE,nW,crc6"},
      Case{{.mt_fmt = 1, .mt_cnt = 4096}, "mt12,st24,nE,nW,crc6"},
      Case{{.mt_fmt = 1, .mt_cnt = 0}, "mt12,st24,nE,nW,crc6"},
      Case{{.mt_fmt = 1, .mt_cnt = 1}, "mt12,st24,nE,nW,crc6"},
      Case{{.mt_fmt = 1, .mt_cnt = 5000}, "mt12,st24,nE,nW,crc6"},
      // Coarse and fine: 2 bits to spare, then 2 and 3.
      Case{{.co_fmt = 1, .fi_fmt = 1, .sip_cnt = 1024, .sip_res = 4096},
           "mt12,st22,pad2,nE,nW,crc6"},
      Case{{.co_fmt = 0, .fi_fmt = 0, .sip_cnt = 1024, .sip_res = 4096},
           "mt12,pad2,st22,nE,nW,crc6"},
      Case{{.co_fmt = 0, .fi_fmt = 1, .sip_cnt = 256, .sip_res = 2048},
           "mt12,pad2,st19,pad3,nE,nW,crc6"},
      Case{{.co_fmt = 1, .fi_fmt = 1, .sip_cnt = 256, .sip_res = 2048},
           "mt12,st19,pad5,nE,nW,crc6"},
      // Only the product fits: 64 periods of 2^16 counts.
      Case{{.co_fmt = 0, .fi_fmt = 1, .sip_cnt = 64, .sip_res = 65536},
           "mt12,st22,pad2,nE,nW,crc6"},
      Case{{.fi_fmt = 1, .sip_cnt = 64, .sip_res = 0xFFFF'FFFF}, "mt12,st24,nE,nW,crc6"},
      // Singleturn in one field, with and without turns.
      Case{{.fi_len = 20, .fi_fmt = 1, .sip_cnt = 8, .sip_res = 8192}, "pos16,pad4,nE,nW,crc6"},
      Case{
          {.mt_len = 16, .co_len = 20, .co_fmt = 1, .mt_cnt = 1000, .sip_cnt = 4096, .sip_res = 10},
          "pad6,mt10,st16,pad4,nE,nW,crc6"},
      Case{{.mt_len = 16, .mt_fmt = 1, .mt_cnt = 1000}, "mt10,pad6,nE,nW,crc6"},
      // A scale: 4096 periods of 256 counts.
      Case{{.en_typ = 1,
            .fi_len = 24,
            .fi_fmt = 1,
            .mt_cnt = 4096,
            .sip_cnt = 20000,
            .sip_res = 256},
           "pos20,pad4,nE,nW,crc6"},
      Case{{.en_typ = 1,
            .fi_len = 24,
            .fi_fmt = 0,
            .mt_cnt = 4096,
            .sip_cnt = 20000,
            .sip_res = 256},
           "pad4,pos20,nE,nW,crc6"},
      Case{{.en_typ = 1, .mt_len = 16, .fi_len = 8, .mt_cnt = 4096, .sip_res = 256},
           "pad4,pos20,nE,nW,crc6"},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const EdsBank bank = spare(cases[i].part);
    const Described said = describe(image_of(nullptr, &bank));
    BISS_EXPECT(said.is(cases[i].format)) << i;
    BISS_EXPECT_EQ(said.remarks.count, 0U) << i;
  }
}

BISS_TEST(EdsDevice, ZerosBetweenCoarseAndFine_AreKeptAndSaid) {
  const EdsBank bank = spare({.co_fmt = 1, .fi_fmt = 0, .sip_cnt = 256, .sip_res = 16384});
  const Described said = describe(image_of(nullptr, &bank));
  BISS_EXPECT(said.is("mt12,st24,nE,nW,crc6"));
  BISS_EXPECT(said.remarks.has("FI_FMT", not_usable, 0, 0));
}

// A left-aligned number of turns was 16 times too large.
BISS_TEST(EdsDevice, PaddedPosition_DecodesToItsTurnsAndCounts) {
  for (const std::uint8_t left : {std::uint8_t{0}, std::uint8_t{1}}) {
    const EdsBank bank = spare({.mt_fmt = left,
                                .co_fmt = left,
                                .fi_fmt = left,
                                .mt_cnt = 256,
                                .sip_cnt = 1024,
                                .sip_res = 4096});
    const Described said = describe(image_of(nullptr, &bank));
    BISS_ASSERT(said.device.ok());
    const std::uint64_t turns = left != 0 ? 0x350 : 0x035;
    const std::uint64_t singleturn = left != 0 ? 0x12345 << 2U : 0x12345;
    const std::uint64_t data = (turns << 24U | singleturn) << 2U | 0b11U;
    const Channel channel = unpack(said.device->format.channel_list[0], data);
    BISS_EXPECT_EQ(channel.position >> 22U, 0x35U) << +left;
    BISS_EXPECT_EQ(channel.position & low_mask(22), 0x12345U) << +left;
  }
}

BISS_TEST(EdsDevice, CrcAsData_IsReadWithThePolynomialAndStartOfThePart) {
  EdsBank bank = with(test::safety_cpw, EdsPart::bp3, "CSTART", 0x15);
  BISS_EXPECT(describe(image_of(nullptr, &bank)).is("mt12,st16,nE,nW,crc6:0x43:0x15"));
  bank = with(bank, EdsPart::bp3, "CPOLY", 0x8810);
  bank = with(bank, EdsPart::bp3, "BP_ID", 0x632E);  // 12 + 16 + 2 + 16
  BISS_EXPECT(describe(image_of(nullptr, &bank)).is("mt12,st16,nE,nW,crc16:0x11021:0x15"));
  bank = with(test::safety_cpw, EdsPart::bp3, "CPOLY", 0);
  const Described said = describe(image_of(nullptr, &bank));
  BISS_EXPECT(said.is("mt12,st16,nE,nW,crc6"));
  BISS_EXPECT(said.remarks.has("CPOLY", not_given, 0, 0));
}

BISS_TEST(EdsDevice, CrcAsData_LengthsDecideTheReadingOfTheDataLength) {
  const EdsBank bank = with(test::safety_cpw, EdsPart::bp3, "BP_ID", 0x631E);
  Described said = describe(image_of(nullptr, &bank));
  BISS_EXPECT(said.is("mt12,st16,nE,nW,crc6"));
  BISS_EXPECT(said.remarks.has("BP_ID", other_reading, 0x631E, 0x631E));
  BISS_EXPECT(said.remarks.find("BP_ID", doubtful) == nullptr);
  // The lengths fit neither reading.
  const EdsBank neither = with(test::safety_cpw, EdsPart::bp3, "BP_ID", 0x6325);
  said = describe(image_of(nullptr, &neither));
  BISS_EXPECT(said.is("pos29,nE,nW,crc6"));
  BISS_EXPECT(said.remarks.find("BP_ID", doubtful) != nullptr);
}

BISS_TEST(EdsDevice, Timeouts_AreTakenInTheirOrder) {
  const auto timing = [](const EdsBank& common) {
    return describe(image_of(&common, &test::rotary_18)).device->timing;
  };
  EdsBank bank = with(test::one_channel, EdsPart::common, "TCLK_MAX", 0);
  BISS_EXPECT(timing(bank).timeout.rule == TimeoutRule::fixed);
  BISS_EXPECT(timing(bank).timeout.time == microseconds(1));  // TOS_MAX
  bank = with(bank, EdsPart::common, "TOS_MAX", 0xFF);
  BISS_EXPECT(timing(bank).timeout.time == microseconds(30));  // TO_MAX
  bank = with(bank, EdsPart::common, "TO_MAX", 161);
  BISS_EXPECT(timing(bank).timeout.time == biss_static_timeout_max);
  const Described said = describe(image_of(&bank, &test::rotary_18));
  BISS_EXPECT(said.remarks.has("TO_MAX", not_usable, 161, 0));
  bank = with(bank, EdsPart::common, "TO_MAX", 0);
  BISS_EXPECT(describe(image_of(&bank, &test::rotary_18)).remarks.has("TO_MAX", not_given, 0, 0));
}

BISS_TEST(EdsDevice, ClockAndBusyS_StayWithinTheLimitsOfBissC) {
  const EdsBank slow = with(test::one_channel, EdsPart::common, "TMA", 250);
  BISS_EXPECT(describe(image_of(&slow, &test::rotary_18)).device->timing.clock_max == megahertz(4));
  const EdsBank fast = with(test::one_channel, EdsPart::common, "TMA", 50);
  const Described limited = describe(image_of(&fast, &test::rotary_18));
  BISS_EXPECT(limited.device->timing.clock_max == biss_clock_max);
  BISS_EXPECT(limited.remarks.has("TMA", not_usable, 50, 0));
  const EdsBank late = with(test::one_channel, EdsPart::common, "BUSY_S", 200);
  BISS_EXPECT_EQ(describe(image_of(&late, &test::rotary_18)).device->busy_s_clocks, 8);
}

BISS_TEST(EdsDevice, Disagreement_IsSettledAndSaid) {
  const Described said = describe(image_of(&test::one_channel, &test::multiturn_12_20, 0x621C));
  BISS_EXPECT(said.is("pos26,nE,nW,crc6"));
  BISS_EXPECT(said.remarks.has("BP_ID", disagrees, 0x6222, 0x621C));
  BISS_EXPECT(said.remarks.has("MT_LEN", undivided, 32, 26));
  BISS_EXPECT(said.remarks.has("DLEN_0", disagrees, 34, 28));
  // Registers without a profile give no remark.
  const Described silent = describe(image_of(&test::one_channel, &test::multiturn_12_20, 0));
  BISS_EXPECT(silent.is("mt12,st20,nE,nW,crc6"));
  const EdsBank other = with(test::one_channel, EdsPart::common, "CPOLY_0", 0x12);
  BISS_EXPECT(
      describe(image_of(&other, &test::rotary_18)).remarks.has("CPOLY_0", disagrees, 0x12, 0x21));
}

BISS_TEST(EdsDevice, UsualMistakes_AreReadAsMeant) {
  EdsBank bank = with(test::multiturn_12_20, EdsPart::bp3, "CPOLY", 0x43);
  Described said = describe(image_of(nullptr, &bank));
  BISS_EXPECT(said.is("mt12,st20,nE,nW,crc6"));
  BISS_EXPECT(said.remarks.has("CPOLY", repaired, 0x43, 0x21));
  bank = with(bank, EdsPart::bp3, "CPOLY", 0x21000000);
  BISS_EXPECT(describe(image_of(nullptr, &bank)).is("mt12,st20,nE,nW,crc6"));
  bank = with(bank, EdsPart::bp3, "BP_ID", 0x2262);
  said = describe(image_of(nullptr, &bank));
  BISS_EXPECT(said.is("mt12,st20,nE,nW,crc6"));
  BISS_EXPECT(said.remarks.has("BP_ID", repaired, 0x2262, 0x6222));
  bank = with(bank, EdsPart::bp3, "BP_ID", 0xAAAA);
  said = describe(image_of(nullptr, &bank));
  BISS_EXPECT(said.is("mt12,st20,nE,nW,crc6"));
  BISS_EXPECT(said.remarks.has("BP_ID", not_usable, 0xAAAA, 0));
}

BISS_TEST(EdsDevice, UnusualFields_AreFollowed) {
  EdsBank bank = with(test::multiturn_12_20, EdsPart::bp3, "CPOLY", 0x8810);
  BISS_EXPECT(describe(image_of(nullptr, &bank)).is("mt12,st20,nE,nW,crc16:0x11021"));
  bank = with(bank, EdsPart::bp3, "CSTART", 0x1234);
  BISS_EXPECT(describe(image_of(nullptr, &bank)).is("mt12,st20,nE,nW,crc16:0x11021:0x1234"));
  bank = with(test::multiturn_12_20, EdsPart::bp3, "CSTART", 0x40);
  Described said = describe(image_of(nullptr, &bank));
  BISS_EXPECT(said.is("mt12,st20,nE,nW,crc6"));
  BISS_EXPECT(said.remarks.has("CSTART", not_usable, 0x40, 0));
  bank = with(test::multiturn_12_20, EdsPart::bp3, "CPOLY", 0x12345678);
  BISS_EXPECT(describe(image_of(nullptr, &bank)).remarks.has("CPOLY", not_usable, 0x12345678, 0));
  bank = with(test::rotary_18, EdsPart::bp3, "FB1", 2);
  bank = with(bank, EdsPart::bp3, "FB2", 1);
  BISS_EXPECT(describe(image_of(nullptr, &bank)).is("pos18,nW,nE,crc6"));
  bank = with(bank, EdsPart::bp3, "FB1", 0);
  BISS_EXPECT(describe(image_of(nullptr, &bank)).is("pos18,pad1,nE,crc6"));
  bank = with(bank, EdsPart::bp3, "FB1", 1);
  said = describe(image_of(nullptr, &bank));
  BISS_EXPECT(said.is("pos18,nE,nW,crc6"));
  BISS_EXPECT(said.remarks.has("FB2", not_usable, 1, 0));
}

BISS_TEST(EdsDevice, Overrides_WinOverEverythingAndAreSaid) {
  const EdsImage image = image_of(&test::one_channel, &test::multiturn_12_20, 0x6222);
  const std::array length{EdsOverride{EdsPart::common, 0, "DLEN_0", 28}};
  Described said = describe(image, length);
  BISS_EXPECT(said.is("pos26,nE,nW,crc6"));
  BISS_EXPECT(said.remarks.has("DLEN_0", overridden, 34, 28));
  const std::array identifier{EdsOverride{EdsPart::bp3, 0, "BP_ID", 0x6214}};
  BISS_EXPECT(describe(image, identifier).is("pos18,nE,nW,crc6"));
  const std::array turns{EdsOverride{EdsPart::bp3, 0, "MT_LEN", 16},
                         EdsOverride{EdsPart::bp3, 0, "CO_LEN", 2}};
  BISS_EXPECT(describe(image, turns).is("pad4,mt12,st16,nE,nW,crc6"));
  const std::array polynomial{EdsOverride{EdsPart::common, 0, "CPOLY_0", 0x12}};
  BISS_EXPECT(describe(image, polynomial).is("mt12,st20,nE,nW,crc5"));
  const std::array clock{EdsOverride{EdsPart::common, 0, "TMA", 200},
                         EdsOverride{EdsPart::common, 0, "TBUSY_MAX", 8}};
  BISS_EXPECT(describe(image, clock).device->timing.clock_max == megahertz(5));
  BISS_EXPECT(describe(image, clock).device->timing.ack_max == microseconds(2));
}

BISS_TEST(EdsDevice, ImpossibleOverrides_AreRefused) {
  const EdsImage image = image_of(&test::one_channel, &test::multiturn_12_20);
  const auto refused = [&](const EdsOverride& second, EdsDeviceCause cause) {
    const std::array overrides{EdsOverride{EdsPart::common, 0, "TMA", 200}, second};
    return describe(image, overrides).device.error() == EdsDeviceError{cause, 1};
  };
  BISS_EXPECT(refused({EdsPart::bp3, 0, "TMA", 1}, EdsDeviceCause::unknown_override));
  BISS_EXPECT(refused({EdsPart::raw, 0, "CPOLY", 1}, EdsDeviceCause::unknown_override));
  BISS_EXPECT(refused({EdsPart::common, 0, "TMA", 256}, EdsDeviceCause::unknown_override));
  BISS_EXPECT(refused({EdsPart::bp3, 1, "MT_LEN", 1}, EdsDeviceCause::override_unread));
  BISS_EXPECT(refused({EdsPart::bp3, 8, "MT_LEN", 1}, EdsDeviceCause::override_unread));
}

BISS_TEST(EdsDevice, SafetyDevice_HasTheHighestChannelFirst) {
  EdsBank spw{1, 1, 0x73, 0x3A};
  spw = with(spw, EdsPart::bp3, "CPOLY", 0xC86C);
  EdsImage image{.common = &test::two_channels, .profiles = {&spw, &test::safety_cpw}};
  const Described said = describe(image);
  BISS_EXPECT(said.is("mt12,st16,nE,nW,crc6+pos34,nE,nW,lc6,crc16"));
  BISS_EXPECT(said.remarks.find("CPOLY", hypothesis) == nullptr);
  BISS_EXPECT(said.remarks.find("DC_NUM", order) != nullptr);
  BISS_EXPECT(said.remarks.find("BP_ID", doubtful) != nullptr);
  BISS_EXPECT_EQ(said.device->slaves, 2);
  spw = with(spw, EdsPart::bp3, "CSTART", 1);
  BISS_EXPECT(describe(image).is("mt12,st16,nE,nW,crc6+pos34,nE,nW,lc6,crc16:0x190D9:0x1"));
  spw = with(spw, EdsPart::bp3, "CPOLY", 0x21);  // no safety word has a CRC of 6 bits
  BISS_EXPECT(describe(image).is("mt12,st16,nE,nW,crc6+pos34,nE,nW,lc6,crc16"));
  spw = with(spw, EdsPart::bp3, "BP_ID", 0x722A);
  spw = with(spw, EdsPart::bp3, "CSTART", 1);
  spw = with(spw, EdsPart::bp3, "CPOLY", 0x8810);
  const Described start = describe(image);
  BISS_EXPECT(start.is("mt12,st16,nE,nW,crc6+pos34,nE,nW,lc6,crc16:0x11021:0x1"));
  BISS_EXPECT(start.remarks.has("CPOLY", hypothesis, 0x8810, 0x8810));
  spw = with(spw, EdsPart::bp3, "CSTART", 0x10000);
  BISS_EXPECT(describe(image).is("mt12,st16,nE,nW,crc6+pos34,nE,nW,lc6,crc16"));
}

BISS_TEST(EdsDevice, CrcAsData_MayBeCountedEitherWayByTheCommonPart) {
  for (const std::uint32_t length : {30U, 36U, 31U}) {
    const EdsBank common = with(test::one_channel, EdsPart::common, "DLEN_0", length);
    const Described said = describe(image_of(&common, &test::safety_cpw));
    BISS_EXPECT_EQ(said.remarks.find("DLEN_0", disagrees) != nullptr, length == 31) << length;
  }
}

BISS_TEST(EdsDevice, Override_IsMadeInItsChannelOnly) {
  EdsImage image{.common = &test::two_channels,
                 .profiles = {&test::multiturn_12_20, &test::multiturn_12_20}};
  const std::array second{EdsOverride{EdsPart::bp3, 1, "MT_LEN", 16},
                          EdsOverride{EdsPart::bp3, 1, "CO_LEN", 2}};
  BISS_EXPECT(describe(image, second).is("pad4,mt12,st16,nE,nW,crc6+mt12,st20,nE,nW,crc6"));
}

BISS_TEST(EdsDevice, CommonPartAlone_GivesLengthsAndCrcs) {
  const Described said = describe(image_of(&test::slow_coupler, nullptr));
  BISS_EXPECT(said.is("pos14,nE,nW,crc5+pos10,nE,nW,crc5+pos24,nE,nW,crc6"));
  const Described bare = describe(image_of(&test::two_channels, nullptr));
  BISS_EXPECT(bare.is("pos28,nE,nW,crc6+pos40,nE,nW"));
  BISS_EXPECT(bare.remarks.has("CPOLY_0", not_given, 0, 0));
  const EdsBank actuator = with(test::one_channel, EdsPart::common, "FORMAT_0", 1);
  BISS_EXPECT(describe(image_of(&actuator, nullptr)).device.error() ==
              EdsDeviceError({EdsDeviceCause::actuator, 0}));
  const EdsBank empty = with(test::one_channel, EdsPart::common, "DLEN_0", 0);
  BISS_EXPECT(describe(image_of(&empty, nullptr)).device.error() ==
              EdsDeviceError({EdsDeviceCause::unknown_channel, 0}));
  const EdsBank none = with(test::one_channel, EdsPart::common, "DC_NUM", 0);
  BISS_EXPECT(describe(image_of(&none, nullptr)).device.error() ==
              EdsDeviceError({EdsDeviceCause::no_channel, 0}));
  BISS_EXPECT(describe(image_of(nullptr, nullptr, 0x2814)).is("pos24,nE,nW,crc6"));
  BISS_EXPECT(!describe(image_of(nullptr, nullptr, 0x2815)).device.ok());
}

BISS_TEST(EdsDevice, AnyBytes_GiveAPrintableFormatOrACause) {
  BISS_RANDOM(random, 0xDE71CE);
  unsigned formats = 0;
  for (std::uint64_t round = test::rounds(50'000, 200); round-- > 0;) {
    std::array<EdsBank, 3> banks{};
    for (EdsBank& bank : banks) {
      for (std::uint8_t& byte : bank) byte = static_cast<std::uint8_t>(random.bits(8));
    }
    banks[0][0x10] = static_cast<std::uint8_t>(random.below(4));
    for (std::size_t i = 0; i < 3; ++i) banks[0][0x16 + 4 * i] &= 0xFEU;
    banks[1][2] = static_cast<std::uint8_t>(0x62U + 0x10U * random.below(2) + random.below(2));
    banks[1][3] &= 0x3FU;
    EdsImage image{.common = &banks[0], .profiles = {&banks[1], &banks[2]}};
    if (random.flip()) image.identifiers[0] = static_cast<std::uint16_t>(random.bits(16));
    if (random.flip()) image.common = nullptr;
    const Described said = describe(image);
    if (!said.device.ok()) continue;
    ++formats;
    const auto again = parse_format(format_text(said.device->format).view());
    BISS_ASSERT(again.ok());
    BISS_ASSERT(*again == said.device->format);
    const DeviceTiming& timing = said.device->timing;
    BISS_EXPECT(timing.clock_max > timing.clock_min && timing.clock_max <= biss_clock_max);
    BISS_EXPECT(timing.ack_max <= biss_busy_max && timing.ack_max > Picoseconds{});
    BISS_EXPECT(timing.timeout.time <= biss_static_timeout_max);
  }
  BISS_EXPECT(formats > test::rounds(4'000, 8)) << formats;
}

BISS_TEST(EdsDevice, AdvisedBank_IsGoodAndDescribesTheAdvisedFrame) {
  for (unsigned turns = 0; turns <= 32; turns += static_cast<unsigned>(test::rounds(1, 4))) {
    for (unsigned resolution = 0; turns + resolution <= 55; ++resolution) {
      if (turns + resolution == 0) continue;
      const auto advice = advise({.resolution_bits = resolution, .turns_bits = turns});
      BISS_ASSERT(advice.ok() && advice->identifier != 0);
      const EdsBank bank = bp3_bank_of(*advice);
      unsigned findings = 0;
      check_bp3_part(bank, [&](const EdsFinding&) { ++findings; });
      BISS_EXPECT_EQ(findings, 0U) << turns << "," << resolution;
      const Described said = describe(image_of(nullptr, &bank));
      BISS_ASSERT(said.device.ok());
      BISS_EXPECT_EQ(said.remarks.count, 0U);
      BISS_EXPECT(said.device->format.channel_list[0] == advice->channel)
          << turns << "," << resolution;
    }
  }
}

}  // namespace biss::eds_device_test
