// Configuration with faults: a cable that is cut, bits that are not answers, a device that exceeds
// the limits.
#include "biss/configure/configurator.hpp"
#include "biss/configure/configure_cycle.hpp"
#include "tests/core/configure_bench.hpp"
#include "tests/core/test.hpp"

namespace configure_hostile_test {

using namespace biss;
using namespace biss::test::configure;

/// Bank 1: a common part with one channel, whose BP3 part is bank 2.
EncoderSlave with_eds(EncoderState& state) {
  EncoderSlave slave =
      encoder(format_of_profile(0x621E), usual_timing, {.profile = 0x621E, .eds_bank = 1}, state);
  Registers& registers = slave.source().server.owner();
  put_eds(registers, 0x621E);
  return slave;
}

BISS_TEST(ConfigureHostile, CableCutAtAnyRequest_EndsAndNamesTheLine) {
  std::uint32_t all = 0;
  {
    EncoderState state{.position = 3};
    Encoders<1> device{{with_eds(state)}};
    Line line(device);
    BISS_ASSERT(line.run());
    BISS_ASSERT(line.cycle.result().ok());
    all = line.cycle.configurator().requests();
  }
  const std::uint32_t stride = static_cast<std::uint32_t>(test::rounds(7, 400));
  std::array<std::uint32_t, configure_step_count> steps{};
  for (std::uint32_t at = 0; at < all; at += stride) {
    EncoderState state{.position = 3};
    Encoders<1> device{{with_eds(state)}};
    Line line(device);
    line.cut_at = at;
    BISS_ASSERT(line.run()) << "cut at " << at;
    BISS_ASSERT(line.cycle.configurator().requests() < all + 500);
    const auto result = line.cycle.result();
    if (result.ok()) {
      // Only zeros were still to be sent.
      BISS_ASSERT(at + 20 >= all) << "cut at " << at;
      continue;
    }
    const ConfigureFault& fault = result.error();
    ++steps[static_cast<std::size_t>(fault.step)];
    const bool expected = fault.cause == ConfigureError::line_lost ||
                          fault.cause == ConfigureError::channels_stay_off ||
                          (fault.cause == ConfigureError::no_encoder && at < 40) ||
                          // The answer to the last try of the very first access was received in
                          // part.
                          (fault.cause == ConfigureError::control_failed && at < 100);
    BISS_ASSERT(expected) << "cut at " << at << ", cause " << static_cast<int>(fault.cause);
    // Every state that was not restored is reported.
    const Unrestored left = line.cycle.configurator().unrestored();
    BISS_ASSERT_EQ(device.registers().bsel() != 0 && left.banks == 0, false) << "cut at " << at;
    BISS_ASSERT(state.channels || left.channels_off) << "cut at " << at;
  }
  if (stride < 100) {
    for (const ConfigureStep step : {ConfigureStep::identity, ConfigureStep::read_common,
                                     ConfigureStep::read_channels, ConfigureStep::channels_on}) {
      BISS_EXPECT(steps[static_cast<std::size_t>(step)] > 0) << static_cast<int>(step);
    }
  }
}

BISS_TEST(ConfigureHostile, CableBrokenForAWhile_IsForgiven) {
  for (std::uint32_t at = 0; at < 2'400; at += static_cast<std::uint32_t>(test::rounds(41, 800))) {
    for (const std::uint32_t frames : {1U, 5U, 20U}) {
      EncoderState state{.position = 0x0FED'CBA};
      Encoders<1> device{{with_eds(state)}};
      Line line(device);
      line.cut_at = at;
      line.cut_for = frames;
      BISS_ASSERT(line.run()) << "cut at " << at;
      const auto result = line.cycle.result();
      BISS_ASSERT(result.ok()) << "cut at " << at << " for " << frames << ", cause "
                               << static_cast<int>(result.error().cause);
      BISS_ASSERT_EQ(device.registers().bsel(), 0);
      BISS_ASSERT(state.channels);
    }
  }
}

BISS_TEST(ConfigureHostile, RandomCds_AlwaysEnds) {
  BISS_RANDOM(random, 0x3201);
  std::array<std::uint32_t, configure_error_count> causes{};
  for (std::uint32_t i = 0; i < test::rounds(2'000, 20); ++i) {
    Configurator configurator({.switch_channels = random.flip(), .max_requests = 30'000});
    // Mostly zeros, mostly ones, or anything; with frames missing or without.
    const std::uint32_t ones = random.below(257);
    const std::uint32_t lost = random.flip() ? 0 : random.below(30);
    Picoseconds now{};
    while (!configurator.done()) {
      now = std::max(now, configurator.request().at);
      CdsBit cds = random.below(256) < ones ? CdsBit::one : CdsBit::zero;
      if (random.below(256) < lost) cds = CdsBit::missing;
      if (configurator.request().kind == RequestKind::reduced) cds = CdsBit::missing;
      configurator.answer(now, cds);
      BISS_ASSERT(configurator.requests() <= 30'000U);
    }
    const auto result = configurator.result();
    if (!result.ok()) ++causes[static_cast<std::size_t>(result.error().cause)];
    BISS_ASSERT(result.ok() || static_cast<std::size_t>(result.error().cause) < causes.size());
  }
  BISS_EXPECT(causes[static_cast<std::size_t>(ConfigureError::control_failed)] > 0);
}

BISS_TEST(ConfigureHostile, DeviceThatIsBusyWithEachByte_MeetsTheBound) {
  EncoderState state{};
  EncoderSlave slave = with_eds(state);
  slave.source().server = Server(slave.source().server.owner(), {.busy_frames = 60});
  Encoders<1> device{{slave}};
  Line line(device, {.max_requests = 3'000});
  BISS_ASSERT(line.run());
  BISS_EXPECT(line.cause() == ConfigureError::too_many_requests);
  BISS_EXPECT_EQ(line.cycle.configurator().requests(), 3'000U);
  BISS_EXPECT(line.cycle.configurator().unrestored().channels_off);
  BISS_EXPECT_EQ(line.cycle.configurator().unrestored().banks, 1);
}

BISS_TEST(ConfigureHostile, NinthSlave_IsTooManyAndKeepsItsChannelsOff) {
  for (const bool switch_channels : {true, false}) {
    // IDL0 … IDL8 and IDA0 … IDA7 are set in every control frame, as nine slaves answer; all other
    // bits are 0.
    Configurator configurator({.switch_channels = switch_channels});
    Picoseconds now{};
    unsigned zeros = 0;
    unsigned k = 24;
    while (!configurator.done()) {
      now = std::max(now, configurator.request().at);
      const bool reduced = configurator.request().kind == RequestKind::reduced;
      const CdsBit cds = k < 9 || (k >= 16 && k < 24) ? CdsBit::one : CdsBit::zero;
      ++k;
      const bool cdm = configurator.answer(now, reduced ? CdsBit::missing : cds);
      if (cdm && zeros >= control_reset_zeros) k = 0;
      zeros = cdm ? 0 : zeros + 1;
      BISS_ASSERT(configurator.requests() < 1'000U);
    }
    BISS_EXPECT(configurator.result().error().cause == ConfigureError::too_many_slaves);
    // The broadcast reached the ninth, which no command addresses.
    BISS_EXPECT_EQ(configurator.unrestored().channels_off, switch_channels);
  }
}

}  // namespace configure_hostile_test
