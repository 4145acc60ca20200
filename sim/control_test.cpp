// Registers and commands on the simulated line, together with its positions.
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "biss/frame/format_text.hpp"
#include "sim/line.hpp"
#include "sim/ma_replay.hpp"

namespace biss::sim {
namespace control_test {

constexpr auto read_write = RegisterProtection::read_write;

// The value of a register depends on the encoder and the address.
std::uint8_t value_of(unsigned encoder, unsigned address) {
  return static_cast<std::uint8_t>(address * 37U + encoder * 101U + 5U);
}

EncoderRegisters registers_of(unsigned encoder, const RegisterBusy& busy = {}) {
  EncoderRegisters registers;
  registers.set_busy(busy);
  for (unsigned address = 0; address < reg::bsel; ++address) {
    const std::uint8_t value = value_of(encoder, address);
    registers.bank(0).put(address, {&value, 1}, read_write);
  }
  for (unsigned address = reg::eds_bank; address < register_count; ++address) {
    registers.put(address, value_of(encoder, address), read_write);
  }
  return registers;
}

LineSetup setup_of(std::string_view format, std::uint8_t slaves = 1) {
  LineSetup setup;
  setup.format = *parse_format(format);
  setup.clock = megahertz(10);
  setup.ma_delay = nanoseconds(90);
  setup.slo_delay = nanoseconds(110);
  setup.internal_delay = nanoseconds(20);
  setup.timing.timeout = {TimeoutRule::adaptive, nanoseconds(200)};
  setup.motion = MotionKind::random;
  setup.slaves = slaves;
  return setup;
}

// Reads all registers of encoder 0 … n-1.
std::vector<ControlAccess> read_all(unsigned encoders) {
  std::vector<ControlAccess> accesses;
  for (unsigned slave = 0; slave < encoders; ++slave) {
    for (const unsigned address : {0U, 0x41U}) {
      accesses.push_back({.slave = static_cast<std::uint8_t>(slave),
                          .address = static_cast<std::uint8_t>(address),
                          .size = static_cast<std::uint8_t>(address == 0 ? 64 : 63)});
    }
  }
  return accesses;
}

void expect_all_read(const Line& line, unsigned encoders) {
  const auto records = line.control()->records();
  ASSERT_EQ(records.size(), 2U * encoders);
  for (const ControlRecord& record : records) {
    const ControlAccess& access = line.control()->accesses()[record.access];
    ASSERT_TRUE(record.finished);
    ASSERT_FALSE(record.outcome.error) << name_of(*record.outcome.error);
    ASSERT_EQ(record.data.size(), access.size);
    for (unsigned i = 0; i < access.size; ++i) {
      EXPECT_EQ(record.data[i], value_of(access.slave, access.address + i));
    }
  }
}

// Runs until all accesses are over; every position is right and every request on time.
void run_to_end(Line& line, Picoseconds interval) {
  Picoseconds last{};
  for (int i = 0; i < 20'000 && !line.control()->done(); ++i) {
    const SimulatedCycle& cycle = line.next();
    ASSERT_TRUE(cycle.reading.frame.ok()) << name_of(cycle.reading.frame.error().cause);
    ASSERT_EQ(cycle.reading.frame->channel_list, cycle.sent.channel_list);
    if (i != 0) {
      ASSERT_EQ(cycle.time - last, interval) << i;
    }
    last = cycle.time;
  }
  ASSERT_TRUE(line.control()->done());
}

TEST(ControlLine, OneEncoder_AllRegistersAreReadBesideThePositions) {
  LineSetup setup = setup_of("pos26,nE,nW,crc6");
  setup.registers = {registers_of(0)};
  setup.accesses = read_all(1);
  Line line(setup);
  run_to_end(line, line.interval());
  expect_all_read(line, 1);
}

TEST(ControlLine, Chain_EachEncoderAnswersForItself) {
  LineSetup setup = setup_of("pos18,nE,nW,crc6+pos12,crc5+mt4,st9,nE,nW,lc6,crc16", 3);
  for (unsigned k = 0; k < 3; ++k) setup.registers.push_back(registers_of(k));
  setup.accesses = read_all(3);
  Line line(setup);
  run_to_end(line, line.interval());
  expect_all_read(line, 3);
  EXPECT_EQ(line.control()->records().back().outcome.slaves_present, 0b111);
}

// Also at the highest feasible rate, by every timeout rule; the times are those without traffic.
TEST(ControlLine, RequestTimes_AreThoseWithoutTraffic) {
  for (const Timeout& timeout : {Timeout{TimeoutRule::adaptive, nanoseconds(200)},
                                 Timeout{TimeoutRule::fixed, microseconds(20)},
                                 Timeout{TimeoutRule::cycle, nanoseconds(31'250)}}) {
    for (const Picoseconds cable : {nanoseconds(0), nanoseconds(110), microseconds(19)}) {
      LineSetup setup = setup_of("pos26,nE,nW,crc6");
      setup.timing.timeout = timeout;
      setup.ma_delay = setup.slo_delay = cable;
      setup.interval = picoseconds(1);  // as fast as the encoder is
      setup.registers = {registers_of(0)};
      setup.interval = least_interval(setup);
      LineSetup quiet = setup;
      quiet.registers.clear();
      Line without(quiet);
      setup.accesses = read_all(1);
      setup.accesses.push_back({.kind = AccessKind::write, .address = 0, .data = {0xFF, 0xFF}});
      Line with(setup);
      while (!with.control()->done()) {
        const SimulatedCycle& cycle = with.next();
        ASSERT_TRUE(cycle.reading.frame.ok());
        ASSERT_EQ(cycle.reading.frame->channel_list, cycle.sent.channel_list);
        ASSERT_EQ(cycle.time, without.next().time);
      }
      EXPECT_FALSE(with.control()->records().back().outcome.error);
    }
  }
}

TEST(ControlLine, Writes_ChangeWhatIsReadBehindThem) {
  LineSetup setup = setup_of("pos26,nE,nW,crc6");
  setup.registers = {registers_of(0)};
  setup.registers[0].put_bsel(0);
  std::vector<std::uint8_t> bytes(64);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0x80});
  setup.registers[0].bank(7).put(0, bytes, read_write);
  setup.accesses = {
      {.kind = AccessKind::write, .address = reg::bsel, .data = {7}},
      {.kind = AccessKind::write, .address = 3, .data = {1, 2, 3}},
      {.address = 0, .size = 64},
      {.address = reg::bsel, .size = 1},
  };
  Line line(setup);
  run_to_end(line, line.interval());
  const auto records = line.control()->records();
  bytes[3] = 1;
  bytes[4] = 2;
  bytes[5] = 3;
  EXPECT_EQ(records[2].data, bytes);
  EXPECT_EQ(records[3].data, std::vector<std::uint8_t>{7});
  EXPECT_EQ(line.registers(0).bank(7)[4], 2);
}

TEST(ControlLine, RegistersNotThere_AreRefused) {
  LineSetup setup = setup_of("pos12,crc5+pos18,nE,nW,crc6", 2);
  setup.registers = {registers_of(0)};  // and none for the next one
  setup.accesses = {{.address = reg::bsel},
                    {.slave = 1, .address = 0x42},
                    {.kind = AccessKind::write, .slave = 1, .address = 0x48, .data = {1}},
                    {.slave = 2, .address = 0x42}};
  Line line(setup);
  run_to_end(line, line.interval());
  const auto records = line.control()->records();
  EXPECT_EQ(records[0].outcome.error, ControlError::refused);
  EXPECT_EQ(records[1].outcome.error, ControlError::refused);
  EXPECT_EQ(records[2].outcome.error, ControlError::refused_or_not_addressed);
  EXPECT_EQ(records[3].outcome.error, ControlError::no_such_slave);
}

TEST(ControlLine, CyclesOfAccesses_AreThoseOfTheProtocolAndBusyOnTop) {
  LineSetup setup = setup_of("pos26,nE,nW,crc6");
  setup.registers = {registers_of(0, {.read_frames = 3, .write_frames = 2})};
  setup.accesses = {{.address = 0, .size = 1},
                    {.address = 0, .size = 5},
                    {.kind = AccessKind::write, .address = 9, .data = {1, 2, 3, 4}},
                    {.kind = AccessKind::broadcast, .command = ControlCommand::control},
                    {.kind = AccessKind::command, .slaves = 1, .command = ControlCommand::user}};
  Line line(setup);
  run_to_end(line, line.interval());
  const auto records = line.control()->records();
  EXPECT_EQ(records[0].cycles, 47U + 3U);
  EXPECT_EQ(records[1].cycles, 33U + 5U * 14U + 5U * 3U - 14U);
  EXPECT_EQ(records[2].outcome.longest_busy, 2 * line.interval());
  EXPECT_FALSE(records[3].outcome.error);
  EXPECT_EQ(records[4].outcome.error, ControlError::not_accepted);
  for (std::size_t i = 0; i < records.size(); ++i) {
    EXPECT_GE(records[i].cycles, least_cycles(setup.accesses[i]));
  }
}

TEST(ControlLine, AccessNotBeforeACycle_Waits) {
  LineSetup setup = setup_of("pos26,nE,nW,crc6");
  setup.registers = {registers_of(0)};
  setup.accesses = {{.address = 0x42, .not_before = 300}};
  Line line(setup);
  run_to_end(line, line.interval());
  const ControlRecord record = line.control()->records()[0];
  EXPECT_EQ(record.cycle, 300U);
  EXPECT_EQ(record.cycles, 33U);  // its zeros have been sent long ago
  EXPECT_EQ(record.time, picoseconds(2'000'000) + 300 * line.interval());
}

TEST(ControlLine, ChannelsSwitchedOff_ComeBackWhenSwitchedOn) {
  LineSetup setup = setup_of("pos26,nE,nW,crc6");
  setup.registers = {registers_of(0)};
  setup.interval = microseconds(100);
  setup.accesses = {{.kind = AccessKind::broadcast, .command = ControlCommand::channels},
                    {.address = 0x42, .size = 2},
                    {.kind = AccessKind::command, .slaves = 1}};
  Line line(setup);
  int bad = 0;
  while (!line.control()->done()) bad += line.next().reading.frame.ok() ? 0 : 1;
  // From the end of the first access to the end of the last one.
  EXPECT_EQ(bad, 47 + 39);
  for (const ControlRecord& record : line.control()->records()) {
    EXPECT_FALSE(record.outcome.error);
  }
  EXPECT_TRUE(line.next().reading.frame.ok());
}

// Every fault occurs; every access ends, and the values that it reports are those in the registers.
TEST(ControlLine, EveryFault_SpoilsNoByteThatIsCalledGood) {
  for (std::size_t k = 0; k < simulated_fault_count; ++k) {
    const auto kind = static_cast<FaultKind>(k);
    SCOPED_TRACE(name_of(kind));
    LineSetup setup = setup_of("pos26,nE,nW,crc6");
    setup.registers = {registers_of(0)};
    for (int i = 0; i < 40; ++i) setup.accesses.push_back({.address = 0x10, .size = 8});
    setup.control.retries = 3;
    setup.control.busy_max = microseconds(200);
    setup.faults = {{.kind = kind, .share = std::uint64_t{1} << 25U}};
    Line line(setup);
    std::uint64_t affected = 0;
    for (int i = 0; i < 50'000 && !line.control()->done(); ++i) {
      const SimulatedCycle& cycle = line.next();
      affected += cycle.faults != 0 ? 1 : 0;
      if (cycle.faults == 0 && cycle.reading.frame.ok()) {
        EXPECT_EQ(cycle.reading.frame->channel_list, cycle.sent.channel_list);
      }
    }
    ASSERT_TRUE(line.control()->done());
    EXPECT_GT(affected, 5U);
    std::size_t good = 0;
    for (const ControlRecord& record : line.control()->records()) {
      good += record.outcome.error ? 0U : 1U;
      for (unsigned i = 0; i < record.data.size(); ++i) {
        EXPECT_EQ(record.data[i], value_of(0, 0x10 + i));
      }
    }
    EXPECT_GT(good, 20U);
  }
}

TEST(ControlLine, BrownOut_BringsBackTheRegistersOfPowerUp) {
  LineSetup setup = setup_of("pos26,nE,nW,crc6");
  setup.registers = {registers_of(0)};
  setup.interval = microseconds(50);
  setup.accesses = {{.kind = AccessKind::write, .address = 5, .data = {0xAA}},
                    {.address = 5},
                    {.address = 5, .not_before = 200}};
  setup.faults = {{.kind = FaultKind::brown_out, .cycle = 150}};
  Line line(setup);
  while (!line.control()->done()) line.next();
  const auto records = line.control()->records();
  EXPECT_EQ(records[1].data, std::vector<std::uint8_t>{0xAA});
  EXPECT_EQ(records[2].data, std::vector<std::uint8_t>{value_of(0, 5)});
}

TEST(ControlLine, UnidirectionalEncoder_GivesNoAnswer) {
  LineSetup setup = setup_of("pos26,nE,nW,crc6");
  setup.accesses = {{.address = 0x42}};
  Line line(setup);
  run_to_end(line, line.interval());
  EXPECT_EQ(line.control()->records()[0].outcome.error, ControlError::no_answer);
}

TEST(ControlLine, WithoutRegisters_CdsStaysZero) {
  Line line(setup_of("pos26,nE,nW,crc6"));
  for (int i = 0; i < 100; ++i) EXPECT_EQ(line.next().reading.cds, false);
  EXPECT_EQ(line.control(), nullptr);
}

// BP3 with 24 bits of position, no data sheet.
EncoderRegisters registers_with_profile() {
  EncoderRegisters registers;
  const std::array<std::uint8_t, 8> values{0x00, 0x62, 0x1A, 0, 0, 0x12, 0x67, 0x55};
  for (unsigned i = 0; i < values.size(); ++i) {
    registers.put(reg::eds_bank + i, values[i], RegisterProtection::read_only);
  }
  for (unsigned i = 0; i < 8; ++i) registers.put(reg::dev_id + i, 0x41, read_write);
  return registers;
}

TEST(ConfiguredLine, UnknownChain_IsReadByWhatItSaysOfItself) {
  LineSetup setup = setup_of("pos24,nE,nW,crc6+pos24,nE,nW,crc6", 2);
  setup.clock = megahertz(1);
  setup.registers = {registers_with_profile(), registers_with_profile()};
  setup.accesses = {{.address = 0x48}, {.slave = 1, .address = 0x42, .size = 2}};
  Line line(setup);
  line.begin_configuration({}, megahertz(1));
  Picoseconds last{};
  while (line.configuring()) {
    for (const wire::Edge& edge : line.configure_next()) {
      EXPECT_GE(edge.time, last);
      last = edge.time;
    }
  }
  ASSERT_TRUE(line.configuration()->ok());
  const Configuration& found = **line.configuration();
  EXPECT_EQ(found.format, setup.format);
  EXPECT_EQ(found.slave_count, 2);
  EXPECT_TRUE(found.channels_were_switched);
  for (int i = 0; i < 300; ++i) {
    const SimulatedCycle& cycle = line.next();
    EXPECT_GT(cycle.time, last);
    last = cycle.time;
    ASSERT_TRUE(cycle.reading.frame.ok()) << name_of(cycle.reading.frame.error().cause);
    ASSERT_EQ(cycle.reading.frame->channel_list, cycle.sent.channel_list);
  }
  ASSERT_TRUE(line.control()->done());
  EXPECT_EQ(line.control()->records()[1].data, (std::vector<std::uint8_t>{0x62, 0x1A}));
}

TEST(ConfiguredLine, UnidirectionalEncoder_SaysThatItIs) {
  Line line(setup_of("pos24,nE,nW,crc6"));
  line.begin_configuration({}, megahertz(1));
  while (line.configuring()) line.configure_next();
  ASSERT_FALSE(line.configuration()->ok());
  EXPECT_EQ(line.configuration()->error().cause, ConfigureError::no_control);
}

// MA of a line with accesses, before an encoder like the one of the line: it answers in the same
// way.
TEST(ControlReplay, RecordedMaster_GetsTheSameAnswersFromOurRegisters) {
  LineSetup setup = setup_of("pos26,nE,nW,crc6");
  setup.ma_delay = setup.slo_delay = setup.internal_delay = Picoseconds{};
  setup.motion = MotionKind::constant;
  setup.registers = {registers_of(0)};
  setup.accesses = {{.kind = AccessKind::write, .address = 5, .data = {0xAA, 0x55}},
                    {.address = 4, .size = 3},
                    {.kind = AccessKind::broadcast, .command = ControlCommand::channels},
                    {.kind = AccessKind::command, .slaves = 1}};
  Line line(setup);
  std::vector<wire::Edge> recorded{{{}, ma_line, wire::Level::high}};
  std::vector<wire::Edge> slo;
  while (!line.control()->done()) {
    for (const wire::Edge& edge : line.next().edges) {
      recorded.push_back(edge);
      if (edge.line == slo_line) slo.push_back(edge);
    }
  }
  Encoder encoder(setup.format, Motion(setup.motion, setup.format.channel_list[0], {}, setup.seed));
  MaReplay replay({.codec = FrameCodec<>(setup.format),
                   .timing = slave_timing(setup.timing, setup.processing),
                   .registers = registers_of(0)},
                  [&](Picoseconds moment) { return encoder.sample(moment); }, {});
  std::vector<wire::Edge> made;
  replay.push(recorded, ma_line, made);
  replay.finish(line.end(), made);
  std::erase_if(
      made, [](const wire::Edge& edge) { return edge.line != slo_line || edge.time.count == 0; });
  EXPECT_EQ(made, slo);
  EXPECT_EQ(replay.registers().read(0, 6), 0x55);
}

}  // namespace control_test
}  // namespace biss::sim
