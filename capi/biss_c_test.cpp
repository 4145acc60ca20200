// The C interface at work; its refusals are in errors_test.cpp.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "biss/catalogue/catalogue.hpp"
#include "capi/c11_test.h"
#include "capi/test_handles.hpp"

namespace biss::capi {
namespace biss_c_test {

constexpr std::int64_t period_1mhz = 1'000'000;

TEST(CInterface, PlainCProgram_ReadsItsOwnPosition) {
  for (const std::uint64_t position : {0ULL, 1ULL, 12'345'678ULL, (1ULL << 26U) - 1U}) {
    biss_reading reading;
    ASSERT_EQ(c11_read("pos26,nE,nW,crc6;cds0", period_1mhz, position, &reading), BISS_OK);
    EXPECT_EQ(reading.cause, BISS_CAUSE_OK);
    ASSERT_EQ(reading.channel_count, 1U);
    EXPECT_EQ(reading.channels[0].position, position);
    EXPECT_TRUE(reading.channels[0].nE);
  }
}

TEST(CInterface, EveryEncoderOfTheCatalogue_IsReadByItsName) {
  for (const CatalogueEntry& entry : catalogue) {
    const std::string name(entry.name);
    biss_reading reading;
    ASSERT_EQ(c11_read(name.c_str(), period_1mhz, 5, &reading), BISS_OK) << name;
    EXPECT_STREQ(biss_cause_name(reading.cause), "ok") << name;
    EXPECT_EQ(reading.channels[0].position, 5U) << name;
    EXPECT_EQ(reading.channel_count, entry.frame_format().channel_count) << name;
  }
}

TEST(CInterface, ValuesOfAllChannels_ComeThrough) {
  Encoder encoder{.says = {{0x9'8765'4321, 0, true, false}, {0x123'4567, 42, false, true}}};
  const char* format = "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16";
  const SlaveHandle slave = open_slave(encoder.setup(format));
  const MasterHandle master = open_master(biss_master_defaults(named(format), period_1mhz));
  Line line(slave.get(), master.get());
  EXPECT_EQ(line.request(false), BISS_OK);
  const biss_reading reading = line.reading();
  ASSERT_EQ(reading.channel_count, 2U);
  EXPECT_EQ(reading.channels[0].position, 0x9'8765'4321U);
  EXPECT_TRUE(reading.channels[0].nE);
  EXPECT_FALSE(reading.channels[0].nW);
  EXPECT_EQ(reading.channels[1].position, 0x123'4567U);
  EXPECT_EQ(reading.channels[1].life_counter, 42U);
  EXPECT_FALSE(reading.channels[1].nE);
  EXPECT_TRUE(reading.channels[1].nW);
}

TEST(CInterface, CdmAndCds_ArriveAtTheOtherEnd) {
  Encoder encoder;
  encoder.says.resize(1, {7, 0, true, true});
  const SlaveHandle slave = open_slave(encoder.setup("pos12,nE,nW,crc6"));
  const MasterHandle master =
      open_master(biss_master_defaults(named("pos12,nE,nW,crc6"), period_1mhz));
  Line line(slave.get(), master.get());
  for (const bool bit : {true, false, false, true}) {
    encoder.cds = !bit;
    line.request(bit);
    EXPECT_EQ(line.reading().cds, !bit);
  }
  EXPECT_THAT(encoder.cdm_bits, testing::ElementsAre(true, false, false, true));
}

TEST(CInterface, Sampling_IsAskedForTheMomentOfTheDevice) {
  const biss_timing& timing = named("resolute-26")->timing;
  Encoder encoder;
  encoder.says.resize(1, {7, 0, true, true});
  const SlaveHandle slave = open_slave(encoder.setup("resolute-26"));
  const MasterHandle master = open_master(biss_master_defaults(named("resolute-26"), period_1mhz));
  Line line(slave.get(), master.get());
  line.request(false);
  // LAT is the first rising edge, half a period after the request.
  EXPECT_THAT(encoder.moments, testing::ElementsAre(500'000 + timing.sampling_typical_ps));
  EXPECT_GT(timing.sampling_typical_ps, 0);
}

TEST(CInterface, TimingOfTheSetup_ReplacesTheDevices) {
  biss_format format = *named("resolute-26");
  biss_timing& timing = format.timing;
  EXPECT_EQ(timing.timeout.rule, static_cast<unsigned>(BISS_TIMEOUT_CYCLE));
  timing.start_min_ps = timing.sampling_min_ps = timing.sampling_typical_ps = 0;
  timing.ack_clocks = 9;
  Encoder encoder;
  encoder.says.resize(1, {7, 0, true, true});
  biss_slave_setup setup = encoder.setup("resolute-26");
  setup.format = &format;
  const SlaveHandle slave = open_slave(setup);
  const MasterHandle master = open_master(biss_master_defaults(&format, period_1mhz));
  Line line(slave.get(), master.get());
  line.request(false);
  EXPECT_EQ(line.reading().cause, BISS_CAUSE_OK);
  EXPECT_EQ(line.reading().ack_clocks, 9U);
  EXPECT_THAT(encoder.moments, testing::ElementsAre(500'000));
}

// ACK of 26 bits at 250 kHz lasts four clocks at most: 42 clocks, and 1.5 periods.
TEST(CInterface, MasterAfterATooLongAck_RestsForTheFullRequestCycle) {
  const MasterHandle master = open_master(biss_master_defaults(named("resolute-26"), 4'000'000));
  biss_output ma{};
  ASSERT_EQ(biss_master_begin(master.get(), 0, true, false, &ma), BISS_OK);
  std::int64_t now = 0;
  int rises = 0;
  while (!biss_master_done(master.get())) {
    const bool before = ma.level;
    now = ma.deadline_ps;
    ASSERT_EQ(biss_master_step(master.get(), now, rises < 2, &ma), BISS_OK);
    if (ma.level && !before && ++rises == 2) {
      ASSERT_EQ(biss_master_step(master.get(), now, false, &ma), BISS_OK);
    }
  }
  biss_reading reading{};
  ASSERT_EQ(biss_master_reading(master.get(), &reading), BISS_OK);
  EXPECT_EQ(reading.cause, BISS_CAUSE_NO_START);
  EXPECT_GE(now, 174'000'000);
  EXPECT_EQ(biss_master_begin(master.get(), now, true, false, &ma), BISS_OK);
}

TEST(CInterface, StateOfTheSlave_IsNamed) {
  Encoder encoder;
  const SlaveHandle slave = open_slave(encoder.setup("pos12,crc6"));
  biss_output out;
  EXPECT_STREQ(biss_slave_state(slave.get()), "idle");
  biss_slave_step(slave.get(), 0, false, false, &out);
  EXPECT_STREQ(biss_slave_state(slave.get()), "requested");
  biss_slave_step(slave.get(), 10, true, false, &out);
  EXPECT_STREQ(biss_slave_state(slave.get()), "latched");
  EXPECT_TRUE(out.level);
  EXPECT_NE(out.deadline_ps, BISS_NEVER);
}

TEST(CInterface, FormatProblem_SaysWhatAndWhere) {
  std::size_t at = 99;
  EXPECT_EQ(biss_format_problem("pos26,nE,nW,crc6", &at), nullptr);
  EXPECT_EQ(at, 0U);
  EXPECT_EQ(biss_format_problem("resolute-26", nullptr), nullptr);
  EXPECT_STREQ(biss_format_problem("pos26,crc6,nE", &at),
               "crc must be the last item of its channel");
  EXPECT_EQ(at, 11U);
  EXPECT_STREQ(biss_format_problem(nullptr, &at), "the format is empty");
  EXPECT_EQ(named("pos36,crc6+pos28,crc16")->channel_count, 2U);
}

// An encoder with registers from 0x40 on, and two write-only registers at 2.
struct Registers {
  std::array<std::uint8_t, 128> values{};
  int busy = 0;

  static bool permits(void*, bool write, std::uint8_t address) {
    return address >= 0x40 || (write && address / 2 == 1);
  }
  static int read(void* user, std::uint8_t address) {
    auto& self = *static_cast<Registers*>(user);
    return self.busy-- > 0 ? -1 : self.values[address];
  }
  static void write(void* user, std::uint8_t address, std::uint8_t value) {
    static_cast<Registers*>(user)->values[address] = value;
  }
  static void sample(void*, std::int64_t, biss_channel*, std::size_t) {}

  biss_slave_setup setup() {
    biss_slave_setup setup = biss_slave_defaults(named("pos12,nE,nW,crc6"));
    setup.user = this;
    setup.sample = &sample;
    setup.register_permits = &permits;
    setup.register_read = &read;
    setup.register_write = &write;
    return setup;
  }
};

// The CDS bits, each from the frame after that of the same CDM bit; 14 zeros precede the first.
std::string cds_of(Line& line, std::string_view cdm) {
  for (int i = 0; i < 14; ++i) line.request(false);
  std::string cds;
  for (std::size_t k = 0; k <= cdm.size(); ++k) {
    line.request(k < cdm.size() && cdm[k] == '1');
    EXPECT_EQ(line.reading().cause, BISS_CAUSE_OK);
    if (k != 0) cds += line.reading().cds ? '1' : '0';
  }
  return cds;
}

// Control frames as computed for the protocol's tables.
TEST(Registers, FramesOfTheProtocol_AreAnsweredBitByBit) {
  Registers registers;
  registers.values[0x42] = 0x62;
  const SlaveHandle slave = open_slave(registers.setup());
  const MasterHandle master =
      open_master(biss_master_defaults(named("pos12,nE,nW,crc6"), 1'000'000));
  Line line(slave.get(), master.get());
  EXPECT_EQ(cds_of(line, "11000100001001111010000000000000"), "10000000000000001010110001001000");
  EXPECT_EQ(cds_of(line, "11000000001000000110101010100100"), "10000000000000000110101010100100");
  EXPECT_EQ(registers.values[2], 0x55);
  // 0x20 is refused: R = W = 1, and no start bit.
  EXPECT_EQ(cds_of(line, "1100001000001100101"), "1000000000000000110");
  registers.busy = 1;
  EXPECT_EQ(cds_of(line, "110001000010011110110000000000000"), "100000000000000010010110001001000");
}

TEST(Registers, HalfOfTheCallbacks_AreRefused) {
  Registers registers;
  biss_slave slave;
  biss_slave_setup setup = registers.setup();
  setup.register_write = nullptr;
  EXPECT_EQ(biss_slave_init(&slave, &setup), BISS_NULL_ARGUMENT);
  setup = registers.setup();
  setup.register_permits = nullptr;
  EXPECT_EQ(biss_slave_init(&slave, &setup), BISS_NULL_ARGUMENT);
  setup = registers.setup();
  setup.cds = [](void*) { return true; };
  EXPECT_EQ(biss_slave_init(&slave, &setup), BISS_BAD_SETUP);
  EXPECT_EQ(biss_slave_state(&slave), nullptr);
}

}  // namespace biss_c_test
}  // namespace biss::capi
