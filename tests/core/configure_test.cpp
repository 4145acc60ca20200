// Encoders are configured from their registers over the line, and then read with that
// configuration.
#include "biss/catalogue/catalogue.hpp"
#include "biss/configure/configure_cycle.hpp"
#include "biss/master/request.hpp"
#include "tests/core/configure_bench.hpp"
#include "tests/core/test.hpp"
#include "tests/core/wire.hpp"

namespace configure_test {

using namespace biss;
using namespace biss::test::configure;

// Read from an iC-MHM with the demo software of iC-Haus' application note AN22; registers 0x13 to
// 0x3F and 0x74 to 0x77 are not implemented.
constexpr std::array<std::uint8_t, 20> mhm_low{0x48, 0x44, 0x00, 0x78, 0x80, 0x00, 0x00,
                                               0x00, 0xCF, 0x80, 0x00, 0x00, 0x23, 0x00,
                                               0x00, 0x00, 0x00, 0x00, 0x00, 0x8C};
constexpr std::array<std::uint8_t, 8> mhm_40{0x00, 0x02, 0x62, 0x1E, 0xFF, 0xFF, 0xFF, 0xFF};
constexpr std::array<std::uint8_t, 8> mhm_48{0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x8C, 0xFF};
constexpr std::array<std::uint8_t, 4> mhm_70{0x00, 0x01, 0x15, 0x15};
constexpr std::array<std::uint8_t, 8> mhm_78{0x4D, 0x48, 0x4D, 0x23, 0x44, 0x00, 0x69, 0x43};

EncoderSlave mhm(EncoderState& state) {
  Hooks hooks;
  hooks.state = &state;
  Registers registers(hooks);
  constexpr auto read_only = RegisterProtection::read_only;
  registers.bank(0).put(0x00, mhm_low, RegisterProtection::read_write);
  registers.put(0x40, mhm_40, read_only);
  registers.put(0x48, mhm_48, read_only);
  registers.put(0x70, mhm_70, read_only);
  registers.put(0x78, mhm_78, read_only);
  // Banks 1 to 3 were not read: not available. The capture shows a busy frame between bytes.
  return EncoderSlave(
      Codec(format_of_profile(0x621E)),
      {.ready = microseconds(4), .timeout = {TimeoutRule::adaptive, nanoseconds(60)}},
      Encoder{Server(registers, {.busy_frames = 1}), &state});
}

BISS_TEST(Configure, RegistersOfAnMhm_GiveBp3With28BitsAndTheMasterReads) {
  for (const std::int64_t delay : {0, 730, 9'000}) {
    EncoderState state{.position = 0x0ABC'DEF};
    Encoders<1> device{{mhm(state)}};
    Line line(device, {}, nanoseconds(delay));
    const auto result = line.configured();
    BISS_ASSERT(result.has_value());
    const FrameFormat& format = result->format;
    BISS_EXPECT(format == format_of_profile(0x621E));
    BISS_EXPECT_EQ(format.channel_list[0].position_bits(), 28);
    BISS_EXPECT(result->format_source == ValueSource::profile);
    BISS_EXPECT(result->clock_source == ValueSource::defaults);
    BISS_EXPECT(result->timing.clock_max == megahertz(1));
    BISS_EXPECT_EQ(result->slave_count, 1);
    const SlaveDescription& slave = result->slaves()[0];
    BISS_EXPECT_EQ(slave.identity->device, 0x4D48'4D23'4400);
    BISS_EXPECT_EQ(slave.identity->manufacturer, 0x6943);
    BISS_EXPECT(!slave.serial);
    BISS_EXPECT_EQ(slave.profile.value_or(0), 0x621E);
    BISS_EXPECT_EQ(slave.eds_bank, 2);
    BISS_EXPECT(slave.eds_unused);
    // CDM = 1 was held between two requests.
    BISS_EXPECT(line.longest_low > microseconds(200));
    // All registers are restored, and the encoder waits for a start bit.
    BISS_EXPECT(device.slaves[0].source().server.idle());
    BISS_EXPECT_EQ(device.registers().bsel(), 0);
    BISS_EXPECT(state.channels);
    BISS_EXPECT_EQ(state.channel_commands, 2U);
    BISS_EXPECT(line.cycle.configurator().unrestored() == Unrestored{});
    const auto frame = read_with(*result, device, line.now + microseconds(50), nanoseconds(delay));
    BISS_ASSERT(frame.ok());
    BISS_EXPECT_EQ(frame->channels()[0].position, 0x0ABC'DEF);
  }
}

BISS_TEST(Configure, DeviceThatKeepsItsChannels_IsConfiguredAllTheSame) {
  for (const bool try_it : {true, false}) {
    for (const std::uint64_t position :
         {std::uint64_t{0}, low_mask(28), std::uint64_t{0x555'5555}}) {
      EncoderState state{.position = position, .obeys_channels = false};
      Encoders<1> device{
          {encoder(format_of_profile(0x621E), usual_timing, {.profile = 0x621E}, state)}};
      Line line(device, {.switch_channels = try_it}, nanoseconds(330));
      const auto result = line.configured();
      BISS_ASSERT(result.has_value());
      BISS_EXPECT(!result->channels_were_switched);
      BISS_EXPECT(line.cycle.configurator().unrestored() == Unrestored{});
      const auto frame = read_with(*result, device, line.now + microseconds(50), nanoseconds(330));
      BISS_ASSERT(frame.ok());
      BISS_EXPECT_EQ(frame->channels()[0].position, position);
    }
  }
}

BISS_TEST(Configure, UnidirectionalEncoder_IsNamed) {
  const CatalogueEntry& resolute = *find_encoder("resolute-26");
  for (const bool try_it : {true, false}) {
    EncoderState state{.position = 0x2AA'AAAA, .unidirectional = true};
    Encoders<1> device{{encoder(resolute.frame_format(),
                                slave_timing(resolute.timing, microseconds(9)), {}, state)}};
    state.obeys_channels = false;
    Line line(device, {.switch_channels = try_it}, nanoseconds(200));
    BISS_ASSERT(line.run());
    BISS_EXPECT(line.cause() == ConfigureError::no_control);
    BISS_EXPECT(line.cycle.result().error().step == ConfigureStep::identity);
    BISS_EXPECT(line.cycle.result().error().control == ControlError::no_answer);
    BISS_EXPECT(line.now < milliseconds(150));
  }
}

BISS_TEST(Configure, NothingOrAStuckLine_IsNoEncoder) {
  struct Stuck {
    bool level;
    StepOutput step(Picoseconds, bool) const { return {.level = level}; }
  };
  for (const bool level : {true, false}) {
    Stuck device{level};
    Line line(device);
    BISS_ASSERT(line.run());
    BISS_EXPECT(line.cause() == ConfigureError::no_encoder);
  }
}

BISS_TEST(Configure, ProfileThatGivesNoFormat_SaysWhy) {
  struct Case {
    std::uint16_t profile;
    ConfigureError cause;
    std::optional<ProfileError> why;
  };
  for (const Case& each : std::array<Case, 4>{{
           {0x0000, ConfigureError::no_profile, std::nullopt},
           {0x8123, ConfigureError::unknown_profile, ProfileError::unknown_profile},
           {0x641E, ConfigureError::unknown_profile, ProfileError::version},
           {0x6201, ConfigureError::unknown_profile, ProfileError::data_length},
       }}) {
    EncoderState state{.position = 77};
    Encoders<1> device{
        {encoder(format_of_profile(0x621E), usual_timing, {.profile = each.profile}, state)}};
    Line line(device);
    BISS_ASSERT(line.run());
    BISS_EXPECT(line.cause() == each.cause) << "profile " << each.profile;
    BISS_EXPECT(line.cycle.result().error().profile == each.why);
    // The channels are active again.
    BISS_EXPECT(state.channels);
    BISS_EXPECT_EQ(state.channel_commands, 2U);
  }
}

BISS_TEST(Configure, OldDeviceWithoutWInversion_IsWaitedFor) {
  EncoderState state{.position = 5};
  Encoders<1> device{
      {encoder(format_of_profile(0x6214), usual_timing,
               {.profile = 0x6214, .eds_bank = 9, .options = {.w_inversion = false}}, state)}};
  // No identity, no serial number: the encoder refuses each by sending no start bit.
  constexpr std::array<std::uint8_t, 8> nothing{};
  device.registers().put(reg::dev_id, nothing, RegisterProtection::not_available);
  device.registers().put(reg::dev_sn, std::span(nothing).first<4>(),
                         RegisterProtection::not_available);
  Line line(device);
  const auto result = line.configured();
  BISS_ASSERT(result.has_value());
  BISS_EXPECT(!result->slaves()[0].identity && !result->slaves()[0].serial);
  BISS_EXPECT(result->slaves()[0].eds_unused);
  BISS_EXPECT_EQ(device.registers().bsel(), 0);
}

BISS_TEST(Configure, DeviceThatKeepsItsBsel_HasNothingToPutBack) {
  // Without W inversion the encoder refuses a write by not echoing its start bit.
  for (const bool w_inversion : {true, false}) {
    EncoderState state{.keeps_bsel = true};
    Encoders<1> device{{encoder(
        format_of_profile(0x6214), usual_timing,
        {.profile = 0x6214, .eds_bank = 2, .options = {.w_inversion = w_inversion}}, state)}};
    Line line(device);
    BISS_ASSERT(line.run());
    BISS_ASSERT(line.cycle.result().ok());
    BISS_EXPECT(line.cycle.result()->slaves()[0].eds_unused);
    BISS_EXPECT(line.cycle.configurator().unrestored() == Unrestored{});
  }
}

BISS_TEST(Configure, Init_ComesWithCdm0AndARestBeforeAndBehindIt) {
  for (const bool switch_channels : {true, false}) {
    Configurator configurator({.switch_channels = switch_channels, .cycle = microseconds(1)});
    Picoseconds now{};
    std::uint32_t broadcast = 0;
    while (configurator.step() == ConfigureStep::channels_off) {
      BISS_ASSERT(configurator.request().kind == RequestKind::reduced);
      now = std::max(now, configurator.request().at);
      configurator.answer(now, CdsBit::missing);
      ++broadcast;
    }
    // 14 zeros, start bit, CTS, ten bits of addressing, four of CRC, S, EX.
    BISS_EXPECT_EQ(broadcast, switch_channels ? 32U : 0U);
    for (std::uint32_t i = 0; i < 2; ++i) {
      BISS_ASSERT(configurator.step() == ConfigureStep::init);
      BISS_ASSERT(configurator.request().kind == RequestKind::reduced);
      BISS_EXPECT(!configurator.request().cdm);
      now = std::max(now, configurator.request().at);
      configurator.answer(now, CdsBit::missing);
      BISS_EXPECT(configurator.request().at >= now + microseconds(40));
    }
    BISS_EXPECT(configurator.step() == ConfigureStep::identity);
    BISS_EXPECT(configurator.request().kind == RequestKind::control_only);
  }
}

BISS_TEST(Configure, SlowestDeviceThereIs_IsHeard) {
  EncoderState state{.position = 5, .obeys_channels = false};
  const SlaveTiming slowest{.ready = biss_busy_max,
                            .busy_s_clocks = biss_busy_s_max_clocks,
                            .timeout = {TimeoutRule::fixed, biss_static_timeout_max}};
  Encoders<1> device{{encoder(format_of_profile(0x6214), slowest, {.profile = 0x6214}, state)}};
  Line line(device, {}, nanoseconds(9'000));
  BISS_ASSERT(line.run());
  BISS_ASSERT(line.cycle.result().ok());
  const auto frame =
      read_with(*line.cycle.result(), device, line.now + microseconds(50), nanoseconds(9'000));
  BISS_ASSERT(frame.ok());
  BISS_EXPECT_EQ(frame->channels()[0].position, 5);
}

BISS_TEST(Configure, OneByteAtATime_IsEnough) {
  EncoderState state{.position = 5};
  Encoders<1> device{{encoder(
      format_of_profile(0x6214), usual_timing,
      {.profile = 0x6214, .serial = 0x1234'5678, .options = {.sequence_bytes = 1}}, state)}};
  Line line(device);
  const auto result = line.configured();
  BISS_ASSERT(result.has_value());
  BISS_EXPECT_EQ(result->slaves()[0].serial.value_or(0), 0x1234'5678);
  BISS_EXPECT_EQ(result->slaves()[0].identity->device, 0x4142'4344'4546);
}

BISS_TEST(Configure, MakerWithAnotherUseOfBsel_IsNotWrittenTo) {
  EncoderState state{.position = 5};
  Encoders<1> device{
      {encoder(format_of_profile(0x6214), usual_timing,
               {.profile = 0x6214, .eds_bank = 2, .serial = 7, .manufacturer = 0x4C69}, state)}};
  struct Spy {
    Encoders<1>& device;
    bool touched = false;
    StepOutput step(Picoseconds now, bool ma) {
      touched = touched || device.registers().bsel() != 0;
      return device.step(now, ma);
    }
  };
  Spy spy{device};
  Line line(spy);
  BISS_ASSERT(line.run());
  BISS_EXPECT(line.cycle.result().ok());
  BISS_EXPECT(line.cycle.result()->slaves()[0].eds_unused);
  BISS_EXPECT(!line.cycle.result()->slaves()[0].serial);
  BISS_EXPECT(!spy.touched);
}

BISS_TEST(Configure, ChainOfThree_IsAskedOneByOneAndReadHighestIdFirst) {
  std::array<EncoderState, 3> states{};
  constexpr std::array<std::uint16_t, 3> profiles{0x620E, 0x6214, 0x621E};
  const auto one = [&](std::size_t k) {
    states[k].position = 0x100 + k;
    return encoder(format_of_profile(profiles[k]), chain_timing(k),
                   {.profile = profiles[k], .serial = static_cast<std::uint32_t>(1000 + k)},
                   states[k]);
  };
  for (const bool middle_obeys : {true, false}) {
    Encoders<3> device{{one(0), one(1), one(2)}};
    states[1].obeys_channels = middle_obeys;
    Line line(device, {}, nanoseconds(400));
    const auto result = line.configured();
    BISS_ASSERT(result.has_value());
    BISS_ASSERT_EQ(result->slave_count, 3);
    // busy_s is unknown; each further device may take one clock.
    BISS_EXPECT_EQ(result->start_delay_clocks, 8 + 2);
    BISS_ASSERT_EQ(result->format.channel_count, 3);
    for (std::size_t k = 0; k < 3; ++k) {
      BISS_EXPECT_EQ(result->slaves()[k].serial.value_or(0), 1000 + k);
      BISS_EXPECT(result->format.channel_list[2 - k] ==
                  format_of_profile(profiles[k]).channel_list[0]);
      BISS_EXPECT(states[k].channels);
    }
    const auto frame = read_with(*result, device, line.now + microseconds(50), nanoseconds(400));
    BISS_ASSERT(frame.ok()) << static_cast<int>(frame.error().cause);
    for (std::size_t k = 0; k < 3; ++k) {
      BISS_EXPECT_EQ(frame->channels()[2 - k].position, 0x100 + k);
    }
  }
}

BISS_TEST(Configure, EachName_IsItsEnumerators) {
  BISS_EXPECT(name_of(ConfigureStep::channels_off) == "channels_off");
  BISS_EXPECT(name_of(ConfigureStep::restore_bank) == "restore_bank");
  BISS_EXPECT(name_of(ConfigureStep::done) == "done");
  BISS_EXPECT(name_of(ConfigureError::no_encoder) == "no_encoder");
  BISS_EXPECT(name_of(ConfigureError::eds_checksum) == "eds_checksum");
  BISS_EXPECT(name_of(ConfigureError::eds_unreadable) == "eds_unreadable");
  BISS_EXPECT(name_of(ConfigureError::too_many_requests) == "too_many_requests");
  BISS_EXPECT(name_of(ValueSource::defaults) == "default");
  BISS_EXPECT(name_of(ValueSource::eds) == "eds");
}

}  // namespace configure_test
