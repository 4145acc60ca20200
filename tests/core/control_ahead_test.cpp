// A master that chooses CDM before it has the CDS of the same frame: what it reads is right, and a
// slave that answers otherwise than expected never takes a wrong byte.
#include <array>

#include "biss/configure/configurator.hpp"
#include "tests/core/configure_bench.hpp"
#include "tests/core/control_link.hpp"
#include "tests/core/random.hpp"
#include "tests/core/test.hpp"

namespace biss::test::control_ahead_test {

using Byte = std::array<std::uint8_t, 1>;

constexpr std::uint32_t lead = control_reset_zeros;

struct AheadLink : ControlLink<1> {
  explicit AheadLink(const RegisterServerOptions& server = {}, const ControlOptions& options = {})
      : ControlLink<1>(server, options) {
    ahead = true;
    fill(*this);
  }
  /// The registers that differ from fill().
  std::uint32_t changed() const {
    std::uint32_t count = 0;
    for (unsigned address = 0; address < register_count; ++address) {
      count += registers[0].value[address] != value_of(0, address) ? 1U : 0U;
    }
    return count;
  }
};

BISS_TEST(ControlAhead, AccessThatSucceeds_TakesTheSameFramesAsOneThatWaitsForCds) {
  for (const unsigned busy : {0U, 1U, 5U}) {
    std::array<std::uint32_t, 2> frames{};
    for (const bool ahead : {false, true}) {
      AheadLink link({.busy_frames = static_cast<std::uint16_t>(busy)});
      link.ahead = ahead;
      std::array<std::uint8_t, sequential_max_bytes> bytes{};
      BISS_ASSERT(link.read(0, 0x10, bytes));
      for (unsigned i = 0; i < bytes.size(); ++i) BISS_EXPECT_EQ(bytes[i], value_of(0, 0x10 + i));
      BISS_EXPECT_EQ(link.session.outcome().tries, 1U);
      frames[ahead ? 1 : 0] = link.session.outcome().frames;
    }
    BISS_EXPECT_EQ(frames[0], frames[1]);
  }
}

BISS_TEST(ControlAhead, BusySlave_IsReadAndWrittenWithoutAWrongByte) {
  for (unsigned value = 0; value < 256; ++value) {
    AheadLink link({.busy_frames = static_cast<std::uint16_t>(value % 7)}, {.retries = 3});
    link.registers[0].busy_frames = value % 5;
    std::array<std::uint8_t, 3> sent{static_cast<std::uint8_t>(value),
                                     static_cast<std::uint8_t>(value * 31),
                                     static_cast<std::uint8_t>(~value)};
    BISS_EXPECT(link.write(0, 0x20, sent)) << value;
    std::array<std::uint8_t, 3> got{};
    BISS_EXPECT(link.read(0, 0x20, got)) << value;
    BISS_EXPECT(got == sent) << value;
    for (unsigned i = 0; i < sent.size(); ++i) {
      link.registers[0].value[0x20 + i] = value_of(0, 0x20 + i);
    }
    BISS_EXPECT_EQ(link.changed(), 0U) << value;
  }
}

// Each expectation that can be wrong, for each value and with each kind of slave: the access ends
// with an error, and no register has a value that was not written there.
BISS_TEST(ControlAhead, EachWrongExpectation_EndsTheAccessWithoutAWrongWrite) {
  constexpr unsigned address = 0x20;
  unsigned refused = 0;
  for (const bool inverts : {true, false}) {
    for (const auto protection : {RegisterProtection::read_write, RegisterProtection::read_only,
                                  RegisterProtection::not_available}) {
      // A slave that refuses takes no byte.
      const unsigned step = protection == RegisterProtection::read_write ? 1 : 17;
      for (unsigned value = 0; value < 256; value += step) {
        // No CDS flipped, one flipped in each frame, one missing in each frame; of two bytes.
        for (std::uint32_t fault = 0; fault < 2 * 64; ++fault) {
          AheadLink link({.w_inversion = inverts,
                          .sequence_bytes = static_cast<std::uint8_t>(value % 2 == 0 ? 1 : 64)});
          link.registers[0].protection[address] = protection;
          const std::uint32_t frame = lead + fault / 2;
          if (fault % 2 != 0) {
            // CDM does not depend on CDS within a byte: a frame lost there is not an expectation.
            const std::uint32_t index = fault / 2;
            if (index > 19 && (index - 19) % control_byte_bits < 13) continue;
            link.damage({.cut = frame, .cut_frames = 1, .deaf = true});
          } else if (fault != 0) {
            link.damage({.flip_cds = frame});
          }
          const std::array<std::uint8_t, 2> sent{static_cast<std::uint8_t>(value),
                                                 static_cast<std::uint8_t>(~value)};
          const bool good = link.write(0, address, sent);
          refused += good ? 0U : 1U;
          const std::uint32_t writes = link.registers[0].writes;
          // The zeros after an error complete no byte.
          for (int i = 0; i < 40; ++i) link.step();
          BISS_ASSERT(link.registers[0].writes - writes <= (good ? 0U : 1U));
          for (unsigned i = 0; i < sent.size(); ++i) {
            std::uint8_t& now_there = link.registers[0].value[address + i];
            BISS_ASSERT(now_there == value_of(0, address + i) || now_there == sent[i])
                << value << ", " << fault;
            BISS_ASSERT(!good || now_there == sent[i]) << value << ", " << fault;
            now_there = value_of(0, address + i);
          }
          BISS_ASSERT_EQ(link.changed(), 0U) << value << ", " << fault;
          // The next access works.
          link.damage({});
          Byte byte{};
          BISS_ASSERT(link.read(0, 0x44, byte)) << value << ", " << fault;
          BISS_ASSERT_EQ(byte[0], value_of(0, 0x44));
        }
      }
    }
  }
  BISS_EXPECT(refused > 0);
}

BISS_TEST(ControlAhead, ReadNeverWrites) {
  for (unsigned address = 0; address < register_count; ++address) {
    for (std::uint32_t frame = 0; frame < 64; ++frame) {
      for (const bool missing : {false, true}) {
        AheadLink link({}, {.retries = 3});
        link.damage(missing ? Damage{.cut = frame, .cut_frames = 1} : Damage{.flip_cds = frame});
        Byte byte{};
        const bool good = link.read(0, address, byte);
        BISS_ASSERT(!good || byte[0] == value_of(0, address)) << address << ", " << frame;
        BISS_ASSERT_EQ(link.registers[0].writes, 0U) << address << ", " << frame;
      }
    }
  }
}

BISS_TEST(ControlAhead, RandomAccessesWithDamage_NeverGiveAWrongValue) {
  BISS_RANDOM(random, 0xA4EAD);
  unsigned good = 0;
  for (int round = 0; round < 2000; ++round) {
    AheadLink link({.busy_frames = static_cast<std::uint16_t>(random.below(4)),
                    .sequence_bytes = static_cast<std::uint8_t>(1 + random.below(64))},
                   {.retries = 3});
    link.registers[0].busy_frames = random.below(3);
    const unsigned size = 1 + random.below(16);
    const unsigned address = random.below(register_count - size);
    std::array<std::uint8_t, 16> bytes{};
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.bits(8));
    const auto these = std::span(bytes).first(size);
    const bool writes = random.below(4) == 0;
    // Several damages in one access, but not two in one byte, which four bits of CRC cannot detect.
    writes ? link.session.write(0, address, these) : link.session.read(0, address, these);
    while (!link.session.done()) {
      const std::uint32_t at = 14 + random.below(200);
      link.damage(random.flip() ? Damage{.flip_cds = at}
                                : Damage{.cut = at, .cut_frames = 1 + random.below(3)});
      for (unsigned i = 0; i <= at && !link.session.done(); ++i) link.step();
    }
    const ControlOutcome& outcome = link.session.outcome();
    good += outcome.error ? 0U : 1U;
    for (unsigned i = 0; i < outcome.bytes_done; ++i) {
      const std::uint8_t there = link.registers[0].value[address + i];
      BISS_ASSERT_EQ(there, these[i]) << round << ", " << i;
    }
  }
  BISS_EXPECT(good > 300) << good;
}

// A configuration of a slave that is busy in most bytes, on lines with damaged and missing CDS.
BISS_TEST(ControlAhead, ConfigurationWithDamage_IsTheDataSheetOrAnError) {
  BISS_RANDOM(random, 0xC0F16);
  unsigned complete = 0;
  for (int round = 0; round < 1000; ++round) {
    const auto profile = static_cast<std::uint16_t>(0x6200U + 16U + random.below(40));
    configure::EncoderState state;
    configure::EncoderSlave slave = configure::encoder(
        configure::format_of_profile(profile), configure::usual_timing,
        {.profile = profile,
         .eds_bank = 1,
         .options = {.busy_frames = static_cast<std::uint16_t>(random.below(3)),
                     .sequence_bytes = static_cast<std::uint8_t>(1 + random.below(64))}},
        state);
    configure::Server& server = slave.source().server;
    configure::put_eds(server.owner(), profile);
    const auto first_bank = static_cast<std::uint8_t>(random.below(3));
    server.owner().write(0, reg::bsel, first_bank);
    Configurator configurator({.switch_channels = false, .control = {.retries = 20}});
    Picoseconds now{};
    std::uint32_t good_for = 100;
    while (!configurator.done()) {
      const bool cdm = configurator.cdm_ahead();
      CdsBit cds = server.cds(false) ? CdsBit::one : CdsBit::zero;
      // Not two damages in one byte, which four bits of CRC cannot detect.
      if (good_for-- == 0) {
        good_for = 60 + random.below(400);
        cds = random.flip() ? CdsBit::missing : cds == CdsBit::one ? CdsBit::zero : CdsBit::one;
      }
      configurator.take_cds(now, cds);
      server.cdm(cdm);
      now += common_cycle;
    }
    const bool ok = configurator.result().ok();
    if (!ok) continue;
    const Configuration found = *configurator.result();
    BISS_ASSERT(found.format == configure::format_of_profile(profile) ||
                found.format.channel_list[0].position_bits() ==
                    configure::format_of_profile(profile).channel_list[0].position_bits())
        << round;
    BISS_ASSERT(server.idle()) << round;
    const EdsImage image = configurator.image();
    if (image.common == nullptr || image.profiles[0] == nullptr) continue;
    ++complete;
    BISS_ASSERT(*image.common == configure::content_of(server.owner(), 1)) << round;
    BISS_ASSERT(*image.profiles[0] == configure::content_of(server.owner(), 2)) << round;
    BISS_ASSERT_EQ(server.owner().bsel(), first_bank) << round;
  }
  BISS_EXPECT(complete > 900) << complete;
}

}  // namespace biss::test::control_ahead_test
