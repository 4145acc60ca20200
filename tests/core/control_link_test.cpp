// The master's session with the slaves' servers on one line: every address, and every result of an
// access.
#include "tests/core/control_link.hpp"
#include "tests/core/test.hpp"

namespace biss::test::control_link_test {

using Byte = std::array<std::uint8_t, 1>;
using Error = ControlError;

constexpr auto none = ControlLink<1>::no_error;

template <std::size_t Count>
void every_address_of_every_slave() {
  ControlLink<Count> link;
  fill(link);
  for (unsigned slave = 0; slave < Count; ++slave) {
    TestRegisters& registers = link.registers[slave];
    for (unsigned address = 0; address < register_count; ++address) {
      Byte byte{};
      BISS_ASSERT(link.read(slave, address, byte)) << address;
      BISS_EXPECT_EQ(byte[0], value_of(slave, address));
      BISS_EXPECT_EQ(link.session.outcome().slaves_present, (1U << Count) - 1U);
      byte[0] = static_cast<std::uint8_t>(~byte[0]);
      BISS_ASSERT(link.write(slave, address, byte)) << address;
      BISS_EXPECT_EQ(registers.value[address], byte[0]);

      registers.protection[address] = RegisterProtection::read_only;
      BISS_EXPECT(link.read(slave, address, byte));
      BISS_EXPECT(!link.write(slave, address, byte));
      BISS_EXPECT(link.error() == Error::refused_or_not_addressed);
      registers.protection[address] = RegisterProtection::not_available;
      BISS_EXPECT(!link.read(slave, address, byte));
      BISS_EXPECT(link.error() == Error::refused);
      BISS_EXPECT(!link.write(slave, address, byte));
      BISS_EXPECT(link.error() == Error::refused_or_not_addressed);
      registers.protection[address] = RegisterProtection::read_write;
    }
    BISS_EXPECT_EQ(registers.writes, register_count);
    registers.writes = 0;
  }
  for (const TestRegisters& registers : link.registers) BISS_EXPECT_EQ(registers.writes, 0);
  Byte byte{};
  if (Count < control_max_slaves) {
    BISS_EXPECT(!link.read(Count, 0, byte) && link.error() == Error::no_such_slave);
  }
}

BISS_TEST(ControlLink, EveryAddress_IsReadWrittenAndRefused) {
  every_address_of_every_slave<1>();
  every_address_of_every_slave<2>();
  every_address_of_every_slave<3>();
  every_address_of_every_slave<8>();
}

BISS_TEST(ControlLink, EveryLength_FromEveryAddress) {
  ControlLink<2> link;
  fill(link);
  for (unsigned address = 0; address < register_count; address += 3) {
    for (unsigned size = 1; size <= 64 && address + size <= register_count; size += 7) {
      std::array<std::uint8_t, 64> bytes{};
      const std::span<std::uint8_t> used(bytes.data(), size);
      link.session = ControlSession();
      BISS_ASSERT(link.read(1, address, used)) << address << ", " << size;
      BISS_EXPECT_EQ(link.session.outcome().frames, register_access_frames(size));
      for (unsigned i = 0; i < size; ++i) BISS_EXPECT_EQ(bytes[i], value_of(1, address + i));
      link.session = ControlSession();
      BISS_ASSERT(link.write(0, address, used)) << address << ", " << size;
      BISS_EXPECT_EQ(link.session.outcome().frames, register_access_frames(size));
      for (unsigned i = 0; i < size; ++i) {
        BISS_EXPECT_EQ(link.registers[0].value[address + i], bytes[i]);
      }
    }
  }
}

/// The last slave of the chain is busy.
template <unsigned Slaves>
void expect_busy_waits() {
  constexpr unsigned id = Slaves - 1;
  for (const std::uint32_t busy : std::array<std::uint32_t, 6>{0, 1, 100, 200, 202, 1'000'000}) {
    for (unsigned address = 0; address < register_count - 1; address += busy < 2 ? 1 : 31) {
      ControlLink<Slaves> link;
      fill(link);
      link.registers[id].busy_frames = busy;
      std::array<std::uint8_t, 2> bytes{0x12, 0x34};
      const bool in_time = ControlLink<Slaves>::cycle * busy <= register_busy_max;
      BISS_EXPECT_EQ(link.write(id, address, bytes), in_time) << busy;
      BISS_EXPECT(link.error() == (in_time ? none : Error::busy_too_long));
      BISS_EXPECT_EQ(link.session.outcome().bytes_done, in_time ? 2 : 1);
      BISS_EXPECT_EQ(link.registers[id].writes, in_time ? 2 : 1);
      link.registers[id].waited = 0;
      BISS_EXPECT_EQ(link.read(id, address, bytes), in_time) << busy;
      if (in_time) {
        BISS_EXPECT(bytes[0] == 0x12 && bytes[1] == 0x34);
        BISS_EXPECT_EQ(link.session.outcome().longest_busy.count,
                       (ControlLink<Slaves>::cycle * busy).count);
      }
      // The other slave is not affected, nor is this one after it is ready.
      Byte byte{};
      if (id != 0) {
        BISS_EXPECT(link.read(0, address, byte) && byte[0] == value_of(0, address));
      }
      link.registers[id].busy_frames = 0;
      BISS_EXPECT(link.read(id, address, byte) && byte[0] == 0x12);
    }
  }
}

BISS_TEST(ControlLink, Busy_IsWaitedForUpToTheLimit) {
  expect_busy_waits<1>();
  expect_busy_waits<2>();
  expect_busy_waits<3>();
  expect_busy_waits<8>();
}

BISS_TEST(ControlLink, BusyBetweenBytes_AsAnIcMhm) {
  ControlLink<1> link({.busy_frames = 1});
  fill(link);
  std::array<std::uint8_t, 16> bytes{};
  BISS_ASSERT(link.read(0, 0x20, bytes));
  BISS_EXPECT_EQ(link.session.outcome().frames, register_access_frames(16) + 15);
  for (unsigned i = 0; i < 16; ++i) BISS_EXPECT_EQ(bytes[i], value_of(0, 0x20 + i));
  bytes.fill(0xA5);
  BISS_ASSERT(link.write(0, 0x30, bytes));
  for (unsigned i = 0; i < 16; ++i) BISS_EXPECT_EQ(link.registers[0].value[0x30 + i], 0xA5);
}

BISS_TEST(ControlLink, OldDevice_RefusesByNeverStarting) {
  ControlLink<1> link({.w_inversion = false});
  link.registers[0].protection.fill(RegisterProtection::not_available);
  Byte byte{};
  BISS_EXPECT(!link.read(0, 0x10, byte) && link.error() == Error::busy_too_long);
  BISS_EXPECT(!link.write(0, 0x10, byte) && link.error() == Error::start_missing);
  link.registers[0].protection.fill(RegisterProtection::read_write);
  BISS_EXPECT(link.read(0, 0x10, byte) && link.write(0, 0x10, byte));
}

BISS_TEST(ControlLink, SequenceIntoAProtectedRegister_StopsInFrontOfIt) {
  ControlLink<1> link;
  fill(link);
  for (unsigned gap = 0x11; gap < 0x18; ++gap) {
    link.registers[0].protection[gap] = RegisterProtection::not_available;
    std::array<std::uint8_t, 8> bytes{};
    BISS_EXPECT(!link.read(0, 0x10, bytes) && link.error() == Error::next_unavailable);
    BISS_EXPECT_EQ(link.session.outcome().bytes_done, gap - 0x10);
    BISS_EXPECT(!link.write(0, 0x10, bytes) && link.error() == Error::next_unavailable);
    BISS_EXPECT_EQ(link.session.outcome().bytes_done, gap - 0x10);
    link.registers[0].protection[gap] = RegisterProtection::read_write;
  }
}

BISS_TEST(ControlLink, Commands_ReachWhomTheyAddress) {
  ControlLink<8> link;
  for (unsigned mask = 1; mask < 256; mask += 6) {
    const auto slaves = static_cast<std::uint8_t>(mask);
    link.session.command(slaves, ControlCommand::user);
    BISS_ASSERT(link.run() && link.error() == none);
    BISS_EXPECT_EQ(link.session.outcome().accepted, mask);
    for (unsigned k = 0; k < 8; ++k) {
      BISS_EXPECT_EQ(link.registers[k].addressed[3], mask >> k & 1U);
      link.registers[k].addressed[3] = 0;
    }
  }
  link.registers[5].accepts = false;
  link.session.command(0xFF, ControlCommand::channels);
  BISS_EXPECT(link.run() && link.error() == Error::not_accepted);
  BISS_EXPECT_EQ(link.registers[0].addressed[0], 0);
  link.session.command(0xFF, ControlCommand::channels, ExecuteIf::any_accepts);
  BISS_EXPECT(link.run() && link.error() == none);
  BISS_EXPECT_EQ(link.session.outcome().accepted, 0xDF);
  BISS_EXPECT(link.registers[0].addressed[0] == 1 && link.registers[5].addressed[0] == 0);
}

BISS_TEST(ControlLink, SlaveWithoutControlCommunication_LeavesItsIdToTheNext) {
  ControlLink<3> link;
  fill(link);
  link.session.command(0b001, ControlCommand::control);
  BISS_ASSERT(link.run() && link.error() == none);
  Byte byte{};
  BISS_EXPECT(link.read(0, 0x10, byte) && byte[0] == value_of(1, 0x10));
  BISS_EXPECT_EQ(link.session.outcome().slaves_present, 0b011);
  BISS_EXPECT(!link.read(2, 0x10, byte) && link.error() == Error::no_such_slave);
  link.session.broadcast(ControlCommand::control);
  BISS_ASSERT(link.run() && link.error() == none);
  BISS_EXPECT(link.read(0, 0x10, byte) && byte[0] == value_of(0, 0x10));
  BISS_EXPECT(link.read(2, 0x10, byte) && byte[0] == value_of(2, 0x10));
}

}  // namespace biss::test::control_link_test
