// Configuration from electronic data sheets, right and wrong ones.
#include "biss/configure/configure_cycle.hpp"
#include "biss/frame/format_text.hpp"
#include "tests/core/configure_bench.hpp"
#include "tests/core/test.hpp"

namespace configure_eds_test {

using namespace biss;
using namespace biss::test::configure;

EncoderSlave with_eds(EncoderState& state, std::uint16_t registers_say,
                      std::uint16_t eds_says = 0x621E) {
  EncoderSlave slave = encoder(format_of_profile(eds_says), usual_timing,
                               {.profile = registers_say, .eds_bank = 1, .serial = 4711}, state);
  put_eds(slave.source().server.owner(), eds_says);
  return slave;
}

BISS_TEST(ConfigureEds, GoodDataSheet_GivesFormatAndTimingAndBselIsPutBack) {
  for (const std::uint8_t bsel : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{3}}) {
    EncoderState state{.position = 0x0ABC'DEF};
    Encoders<1> device{{with_eds(state, 0x621E)}};
    device.registers().write(0, reg::bsel, bsel);
    Line line(device, {}, nanoseconds(150));
    const auto result = line.configured();
    BISS_ASSERT(result.has_value());
    const ChannelFormat& channel = result->format.channel_list[0];
    BISS_EXPECT_EQ(channel.multiturn.bits, 12);
    BISS_EXPECT_EQ(channel.singleturn.bits, 16);
    BISS_EXPECT(channel.crc == crc6);
    BISS_EXPECT(result->format_source == ValueSource::eds);
    BISS_EXPECT(result->clock_source == ValueSource::eds);
    BISS_EXPECT(result->timing.clock_max == megahertz(8));
    BISS_EXPECT(result->timeout_source == ValueSource::hypothesis);
    BISS_EXPECT((result->timing.timeout == Timeout{TimeoutRule::adaptive, nanoseconds(30)}));
    BISS_EXPECT(result->busy_source == ValueSource::hypothesis);
    BISS_EXPECT(result->timing.ack_max == microseconds(10));
    BISS_EXPECT(result->cycle_source == ValueSource::hypothesis);
    BISS_EXPECT(result->timing.cycle_min == microseconds(40));
    BISS_EXPECT_EQ(result->start_delay_clocks, 1);
    BISS_EXPECT_EQ(result->slaves()[0].serial.value_or(0), 4711U);
    BISS_EXPECT(!result->slaves()[0].eds_unused);
    BISS_EXPECT_EQ(device.registers().bsel(), bsel);
    const auto frame = read_with(*result, device, line.now + microseconds(50), nanoseconds(150));
    BISS_ASSERT(frame.ok());
    BISS_EXPECT_EQ(frame->channels()[0].position, 0x0ABC'DEF);
  }
}

BISS_TEST(ConfigureEds, WrongChecksumOfTheCommonPart_LeavesItToTheIdentifier) {
  for (const std::uint16_t profile : {std::uint16_t{0x621E}, std::uint16_t{0}}) {
    EncoderState state{};
    Encoders<1> device{{with_eds(state, profile)}};
    device.registers().bank(1)[0x20] ^= 0x40U;
    Line line(device);
    BISS_ASSERT(line.run());
    const auto result = line.cycle.result();
    BISS_EXPECT_EQ(device.registers().bsel(), 0);
    BISS_EXPECT(state.channels);
    if (profile == 0) {
      BISS_EXPECT((result.error() == ConfigureFault{.cause = ConfigureError::eds_checksum,
                                                    .step = ConfigureStep::read_common}));
      continue;
    }
    BISS_ASSERT(result.ok());
    BISS_EXPECT(result->format == format_of_profile(0x621E));
    BISS_EXPECT(result->format_source == ValueSource::profile);
    BISS_EXPECT(result->timing.clock_max == megahertz(1));
    BISS_EXPECT(result->slaves()[0].eds_unused);
  }
}

BISS_TEST(ConfigureEds, WrongChecksumOfTheChannelsPart_LeavesItToIdentifierAndCommonPart) {
  EncoderState state{};
  Encoders<1> device{{with_eds(state, 0x621E)}};
  device.registers().bank(2)[0x0A] = 10;
  Line line(device);
  const auto result = line.configured();
  BISS_ASSERT(result.has_value());
  BISS_EXPECT(result->format == format_of_profile(0x621E));
  BISS_EXPECT(result->timing.clock_max == megahertz(8));
  BISS_EXPECT(result->slaves()[0].eds_unused);
  BISS_EXPECT_EQ(device.registers().bsel(), 0);
}

BISS_TEST(ConfigureEds, EmptyAndErasedBanks_AreNoDataSheet) {
  for (const std::uint8_t fill : {std::uint8_t{0}, std::uint8_t{0xFF}}) {
    for (const std::uint8_t bank : {std::uint8_t{1}, std::uint8_t{0xFF}}) {
      EncoderState state{};
      Encoders<1> device{{encoder(format_of_profile(0x621E), usual_timing,
                                  {.profile = 0x621E, .eds_bank = bank}, state)}};
      EdsBank empty{};
      empty.fill(fill);
      device.registers().bank(1) = RegisterBank(empty, RegisterProtection::read_only);
      Line line(device);
      const auto result = line.configured();
      BISS_ASSERT(result.has_value());
      BISS_EXPECT(result->format_source == ValueSource::profile);
      // 0xFF is "none" on some devices.
      BISS_EXPECT_EQ(result->slaves()[0].eds_unused, bank == 1);
      BISS_EXPECT_EQ(device.registers().bsel(), 0);
    }
  }
}

BISS_TEST(ConfigureEds, MoreChannelsThanSlaves_IsAContradiction) {
  for (const bool offset : {false, true}) {
    EncoderState state{};
    Encoders<1> device{{with_eds(state, 0x621E)}};
    CommonPart common = parse_common_part(content_of(device.registers(), 1));
    if (offset) {
      common.sl_off = 1;
    } else {
      common.dc_num = 2;
      common.channels[1] = common.channels[0];
      common.channels[1].bank = 3;
    }
    put_part(device.registers(), 1, common);
    Line line(device);
    BISS_ASSERT(line.run());
    BISS_EXPECT(line.cause() == ConfigureError::eds_contradiction);
    BISS_EXPECT(line.cycle.result().error().field == (offset ? "SL_OFF" : "DC_NUM"));
    BISS_EXPECT(state.channels);
  }
}

BISS_TEST(ConfigureEds, MoreSlavesThanOnTheLine_AreAContradiction) {
  for (const std::uint8_t channels : {std::uint8_t{1}, std::uint8_t{2}}) {
    EncoderState state{};
    Encoders<1> device{{with_eds(state, 0x621E)}};
    CommonPart common{.eds_len = 2, .tma = 125, .dc_num = channels, .sl_num = 2};
    common.channels[0] = {.bank = 2, .dlen = 30, .cpoly = 0x21};
    if (channels == 2) common.channels[1] = {.bank = 3, .dlen = 30, .cpoly = 0x21};
    put_part(device.registers(), 1, common);
    Line line(device);
    BISS_ASSERT(line.run());
    BISS_EXPECT(line.cause() == ConfigureError::eds_contradiction);
    BISS_EXPECT(line.cycle.result().error().field == "SL_NUM");
    BISS_EXPECT(state.channels);
  }
}

BISS_TEST(ConfigureEds, DeviceOfTwoSlaves_IsDescribedByEitherOfThem) {
  for (const std::uint8_t holder : {std::uint8_t{0}, std::uint8_t{1}}) {
    std::array<EncoderState, 3> states{};
    constexpr std::array<std::uint16_t, 3> profiles{0x6214, 0x621E, 0x620E};
    const auto one = [&](std::size_t k) {
      states[k].position = 0x80 + k;
      // Only the third slave gives its profile in its registers.
      return encoder(format_of_profile(profiles[k]), chain_timing(k),
                     {.profile = k == 2 ? profiles[2] : std::uint16_t{0},
                      .eds_bank = static_cast<std::uint8_t>(k == holder ? 1 : 0)},
                     states[k]);
    };
    Encoders<3> device{{one(0), one(1), one(2)}};
    CommonPart common{.eds_len = 3, .tma = 200, .dc_num = 2, .sl_num = 2, .sl_off = holder};
    common.channels[0] = {.bank = 2, .dlen = 0x14, .cpoly = 0x21};
    common.channels[1] = {.bank = 3, .dlen = 0x1E, .cpoly = 0x21};
    Registers& registers = device.registers(holder);
    put_part(registers, 1, common);
    put_part(registers, 2, Bp3Part{.bp_id = 0x6214, .fi_len = 18});
    put_part(registers, 3, Bp3Part{.bp_id = 0x621E, .fi_len = 28});
    Line line(device);
    const auto result = line.configured();
    BISS_ASSERT(result.has_value());
    BISS_EXPECT(result->slaves()[0].source == ValueSource::eds);
    BISS_EXPECT(result->slaves()[1].source == ValueSource::eds);
    BISS_EXPECT(result->slaves()[2].source == ValueSource::profile);
    BISS_EXPECT(result->format_source == ValueSource::profile);
    // The third slave does not give its clock rate.
    BISS_EXPECT(result->timing.clock_max == megahertz(1));
    const auto frame = read_with(*result, device, line.now + microseconds(50), {});
    BISS_ASSERT(frame.ok()) << static_cast<int>(frame.error().cause);
    for (std::size_t k = 0; k < 3; ++k) {
      BISS_EXPECT_EQ(frame->channels()[2 - k].position, 0x80 + k);
    }
  }
}

BISS_TEST(ConfigureEds, IdentifierOfASlaveOfTheDevice_CountsBeforeAndAfterTheHolder) {
  for (const std::uint8_t holder : {std::uint8_t{0}, std::uint8_t{1}}) {
    std::array<EncoderState, 2> states{};
    constexpr std::array<std::uint16_t, 2> profiles{0x6214, 0x621E};
    const auto one = [&](std::size_t k) {
      return encoder(
          format_of_profile(profiles[k]), chain_timing(k),
          {.profile = profiles[k], .eds_bank = static_cast<std::uint8_t>(k == holder ? 1 : 0)},
          states[k]);
    };
    Encoders<2> device{{one(0), one(1)}};
    // No channel has a part, and neither length is given.
    const CommonPart common{.eds_len = 1, .tma = 200, .dc_num = 2, .sl_num = 2, .sl_off = holder};
    put_part(device.registers(holder), 1, common);
    Line line(device);
    const auto result = line.configured();
    BISS_ASSERT(result.has_value());
    BISS_EXPECT(result->clock_source == ValueSource::eds);
    for (std::size_t k = 0; k < 2; ++k) {
      BISS_EXPECT(result->format.channel_list[1 - k] ==
                  format_of_profile(profiles[k]).channel_list[0]);
    }
  }
}

// The fault of an encoder without identifier. \param part_bank that of its channel's part, which the
// common part names; 0: there is no common part
// Not inlined: the stack of a microcontroller holds one encoder and its master.
[[gnu::noinline]] ConfigureFault fault_of(std::uint8_t eds_bank, std::uint16_t manufacturer,
                                          EncoderState& state, std::uint8_t part_bank = 0) {
  Encoders<1> device{{encoder(format_of_profile(0x621E), usual_timing,
                              {.eds_bank = eds_bank, .manufacturer = manufacturer}, state)}};
  if (part_bank != 0) {
    CommonPart common{.eds_len = 1, .tma = 200, .dc_num = 1, .sl_num = 1};
    common.channels[0].bank = part_bank;
    put_part(device.registers(), 1, common);
  }
  Line line(device);
  BISS_EXPECT(line.run());
  const auto result = line.cycle.result();
  BISS_EXPECT(!result.ok());
  return result.ok() ? ConfigureFault{} : result.error();
}

BISS_TEST(ConfigureEds, DataSheetThatCannotBeRead_KeepsTheCauseOfTheAccess) {
  EncoderState state{};
  const auto unreadable = [](ConfigureStep step, std::optional<ControlError> error) {
    return ConfigureFault{.cause = ConfigureError::eds_unreadable, .step = step, .control = error};
  };
  // There are four banks.
  BISS_EXPECT(fault_of(9, 0x6943, state) ==
              unreadable(ConfigureStep::read_common, ControlError::refused));
  // Lika uses BSEL for something else.
  BISS_EXPECT(fault_of(1, 0x4C69, state) == unreadable(ConfigureStep::select_bank, std::nullopt));
  BISS_EXPECT(fault_of(0, 0x6943, state).cause == ConfigureError::no_profile);
  BISS_EXPECT(fault_of(1, 0x6943, state, 9) ==
              unreadable(ConfigureStep::read_channels, ControlError::refused));
  state.keeps_bsel = true;
  BISS_EXPECT(fault_of(1, 0x6943, state) ==
              unreadable(ConfigureStep::select_bank, ControlError::refused_or_not_addressed));
}

// The CPW is the slave next to the master. Bank 2 has the part of the SPW, bank 3 the part of the
// CPW.
void put_safety_eds(Registers& registers) {
  CommonPart common{
      .eds_len = 3, .tma = 125, .dc_num = 2, .sl_num = 2, .sl_off = 1, .unnamed_13 = 0};
  common.channels[0] = {.bank = 2, .dlen = 32};
  common.channels[1] = {.bank = 3, .dlen = 30, .cpoly = 0x21};
  const Bp3Part spw{.bp_id = 0x7330, .cpoly = 0xC86C};
  const Bp3Part cpw{.bp_id = 0x6324, .mt_len = 12, .fi_len = 16};
  put_part(registers, 1, common);
  put_part(registers, 2, spw);
  put_part(registers, 3, cpw);
}

// C = 1 in both words. A wrong start value of an encoder's CRC makes every frame of it wrong.
BISS_TEST(ConfigureEds, SafetyEncoderWithC_IsReadWithBothCrcs) {
  for (const bool eds : {false, true}) {
    for (const std::size_t damaged : {std::size_t{0}, std::size_t{1}, std::size_t{2}}) {
      std::array<EncoderState, 2> states{EncoderState{.position = 0x12'3456},
                                         EncoderState{.position = 0x123'4567}};
      constexpr std::array<std::uint16_t, 2> profiles{0x7330, 0x6324};
      const auto one = [&](std::size_t k) {
        FrameFormat format =
            parse_format(k == 0 ? "pos24,nE,nW,lc6,crc16" : "pos28,nE,nW,crc6").value();
        if (k == damaged) format.channel_list[0].crc.start = 1;
        const auto bank = static_cast<std::uint8_t>(eds && k == 1 ? 1 : 0);
        return encoder(format, chain_timing(k), {.profile = profiles[k], .eds_bank = bank},
                       states[k]);
      };
      Encoders<2> device{{one(0), one(1)}};
      if (eds) put_safety_eds(device.registers(1));
      Line line(device);
      const auto result = line.configured();
      BISS_ASSERT(result.has_value());
      BISS_EXPECT(format_text(result->format).view() ==
                  (eds ? "mt12,st16,nE,nW,crc6+pos24,nE,nW,lc6,crc16"
                       : "pos28,nE,nW,crc6+pos24,nE,nW,lc6,crc16"));
      BISS_EXPECT(result->format_source == (eds ? ValueSource::eds : ValueSource::profile));
      const auto frame = read_with(*result, device, line.now + microseconds(50), {});
      BISS_EXPECT_EQ(frame.ok(), damaged == 2);
      if (!frame.ok()) {
        // The CPW (slave 1) is first on the line.
        const auto channel = static_cast<std::uint8_t>(1 - damaged);
        BISS_EXPECT(frame.error() == FrameFault({FrameError::crc, channel}));
        continue;
      }
      BISS_EXPECT_EQ(frame->channels()[0].position, 0x123'4567U);
      BISS_EXPECT_EQ(frame->channels()[1].position, 0x12'3456U);
    }
  }
}

struct Findings {
  std::array<EdsFinding, 2> list{};
  std::size_t count = 0;
  std::uint8_t slave = 0xFF;

  static void take(void* user, std::uint8_t slave, const EdsFinding& finding) {
    auto& self = *static_cast<Findings*>(user);
    if (self.count < self.list.size()) self.list[self.count] = finding;
    ++self.count;
    self.slave = slave;
  }
};

// 12 bits of turns and 19 of a turn are sent. MT_LEN and CO_LEN describe one value of 31 bits, of
// which the counts would leave 12 trailing zeros.
BISS_TEST(ConfigureEds, CountsThatContradictTheirLengths_AreRefusedAndSaid) {
  EncoderState state{.position = 0x1234'5678};
  Encoders<1> device{{encoder(parse_format("pos31,nE,nW,crc6").value(), usual_timing,
                              {.profile = 0x6221, .eds_bank = 1}, state)}};
  put_eds(device.registers(), 0x6221);
  const Bp3Part part{
      .bp_id = 0x6221, .co_len = 31, .co_fmt = 1, .mt_cnt = 4096, .sip_cnt = 1, .sip_res = 524'288};
  put_part(device.registers(), 2, part);
  Findings seen;
  Line line(device, {.findings = {Findings::take, &seen}});
  BISS_ASSERT(line.run());
  BISS_EXPECT(
      (line.cycle.result().error() == ConfigureFault{.cause = ConfigureError::eds_contradiction,
                                                     .step = ConfigureStep::read_channels,
                                                     .problem = EdsProblem::count_above_length,
                                                     .field = "MT_CNT"}));
  BISS_EXPECT_EQ(seen.count, 1U);
  BISS_EXPECT_EQ(seen.slave, 0);
  BISS_EXPECT(seen.list[0].symbol == "MT_CNT" && seen.list[0].value == 4096);
  BISS_EXPECT(state.channels);
  BISS_EXPECT_EQ(device.registers().bsel(), 0);
}

BISS_TEST(ConfigureEds, FindingWithoutContradiction_IsSaidAndCounted) {
  for (const bool taken : {false, true}) {
    EncoderState state{};
    Encoders<1> device{{with_eds(state, 0x621E)}};
    Bp3Part part{.bp_id = 0x621E, .mt_len = 12, .fi_len = 16};
    part.tmp_min = 500;  // above the highest temperature: nothing of the frame
    part.tmp_max = 400;
    put_part(device.registers(), 2, part);
    Findings seen;
    ConfigureOptions options;
    if (taken) options.findings = {Findings::take, &seen};
    Line line(device, options);
    const auto result = line.configured();
    BISS_ASSERT(result.has_value());
    BISS_EXPECT_EQ(result->slaves()[0].eds_findings, 1);
    BISS_EXPECT_EQ(seen.count, taken ? 1U : 0U);
  }
}

// What refuses a data sheet with this change.
// Not inlined: the stack of a microcontroller holds one encoder and its master.
[[gnu::noinline]] std::optional<EdsProblem> refusal_of(void (*change)(CommonPart&, Bp3Part&)) {
  EncoderState state{};
  Encoders<1> device{{with_eds(state, 0x621E)}};
  Registers& registers = device.registers();
  CommonPart common = parse_common_part(content_of(registers, 1));
  Bp3Part part = parse_bp3_part(content_of(registers, 2));
  change(common, part);
  put_part(registers, 1, common);
  put_part(registers, 2, part);
  Line line(device);
  BISS_EXPECT(line.run());
  const auto result = line.cycle.result();
  return result.ok() ? std::optional<EdsProblem>() : result.error().problem;
}

// Each of these was taken without a word, and gave another frame or other times than were meant.
BISS_TEST(ConfigureEds, EachContradiction_IsRefused) {
  using Common = CommonPart&;
  using Part = Bp3Part&;
  using enum EdsProblem;
  BISS_EXPECT(refusal_of([](Common, Part) {}) == std::nullopt);
  BISS_EXPECT(refusal_of([](Common, Part p) { p.mt_len = 13; }) == lengths);
  BISS_EXPECT(refusal_of([](Common, Part p) { p.mt_cnt = 8192; }) == count_above_length);
  BISS_EXPECT(refusal_of([](Common, Part p) {
                p.sip_cnt = 2;
                p.sip_res = 65536;
              }) == count_above_length);
  BISS_EXPECT(refusal_of([](Common, Part p) {
                p.sip_cnt = 1;
                p.sip_res = 0x0000'8000;
                p.mt_cnt = 0x0010'0000;
              }) == little_endian);
  BISS_EXPECT(refusal_of([](Common, Part p) {
                p.bp_id = 0x621F;
                p.mt_len = 13;
              }) == identifier);
  BISS_EXPECT(refusal_of([](Common c, Part) { c.channels[0].dlen = 29; }) == data_length_differs);
  BISS_EXPECT(refusal_of([](Common c, Part) { c.channels[0].cpoly = 0x43; }) == std::nullopt);
  BISS_EXPECT(refusal_of([](Common c, Part) { c.channels[0].cpoly = 0x2C; }) == polynomial_differs);
  BISS_EXPECT(refusal_of([](Common c, Part) {
                c.tclk_min = 20;
                c.tclk_max = 10;
              }) == min_above_max);
  BISS_EXPECT(refusal_of([](Common c, Part) { c.channels[1] = {.bank = 2, .dlen = 30}; }) ==
              channel_count);
}

BISS_TEST(ConfigureEds, LeftAlignedTurns_AreDividedFromTheirZeros) {
  EncoderState state{.position = 0x035'1234};
  const FrameFormat sent = parse_format("mt8,pad4,st16,nE,nW,crc6").value();
  Encoders<1> device{{encoder(sent, usual_timing, {.profile = 0x621E, .eds_bank = 1}, state)}};
  put_eds(device.registers(), 0x621E);
  const Bp3Part part{.bp_id = 0x621E,
                     .mt_len = 12,
                     .mt_fmt = 1,
                     .fi_len = 16,
                     .fi_fmt = 1,
                     .mt_cnt = 256,
                     .sip_cnt = 1,
                     .sip_res = 65536};
  put_part(device.registers(), 2, part);
  Line line(device);
  const auto result = line.configured();
  BISS_ASSERT(result.has_value());
  BISS_EXPECT(result->format == sent);
  const auto frame = read_with(*result, device, line.now + microseconds(50), {});
  BISS_ASSERT(frame.ok());
  BISS_EXPECT_EQ(frame->channels()[0].position, 0x035'1234U);
}

}  // namespace configure_eds_test
