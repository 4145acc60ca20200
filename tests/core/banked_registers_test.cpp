// The ready-made registers: banks selected by BSEL, protection, the effects of a write.
#include "biss/slave/banked_registers.hpp"
#include "biss/slave/register_server.hpp"
#include "tests/core/test.hpp"

namespace biss::test::banked_registers_test {

using Level = RegisterProtection;

/// Records the last notification.
struct Hooks : NoRegisterHooks {
  std::uint32_t written_count = 0;
  std::uint8_t bank = 0;
  std::uint8_t address = 0;
  std::uint8_t value = 0;
  std::uint8_t next_status = 0;
  std::uint32_t busy_for = 0;
  std::uint32_t executed = 0;

  constexpr void reading(std::uint8_t, std::uint8_t at, std::uint8_t& byte) {
    if (at == 0x68) byte = next_status++;
  }
  constexpr void written(std::uint8_t in, std::uint8_t at, std::uint8_t byte) {
    ++written_count;
    bank = in;
    address = at;
    value = byte;
  }
  constexpr bool busy() { return busy_for != 0 && busy_for-- != 0; }
  constexpr bool accepts(ControlCommand command, bool) { return command == ControlCommand::user; }
  constexpr void execute(ControlCommand, bool) { ++executed; }
};

using Registers = BankedRegisters<3, Hooks>;

constexpr Registers three_banks() {
  Registers registers;
  for (std::uint8_t bank = 0; bank < 3; ++bank) {
    std::array<std::uint8_t, 64> values{};
    for (std::uint8_t i = 0; i < 64; ++i) values[i] = static_cast<std::uint8_t>(bank * 64 + i);
    registers.bank(bank) = RegisterBank(values, bank == 0 ? Level::read_write : Level::read_only);
  }
  registers.put_number<4>(reg::dev_sn, 0x12345678, Level::read_only);
  registers.put_number<1>(0x48, 0, Level::read_write);
  registers.put_number<1>(0x68, 0, Level::read_only);
  return registers;
}

constexpr bool may(Registers& registers, RegisterAccess access, std::uint8_t address) {
  return registers.permits(0, access, address);
}

static_assert(RegisterOwner<Registers> && RegisterOwner<PerSlave<Registers, 2>>);
static_assert(RegisterHooks<NoRegisterHooks>);
static_assert(three_banks().read(0, 0x44) == 0x12 && three_banks().read(0, 0x47) == 0x78);

BISS_TEST(BankedRegisters, Bsel_ChoosesTheWindow) {
  Registers registers = three_banks();
  BISS_EXPECT_EQ(*registers.read(0, 0x40), 0);
  for (const std::uint8_t bank : std::array<std::uint8_t, 4>{2, 0, 1, 2}) {
    BISS_EXPECT(may(registers, RegisterAccess::write, 0x40));
    registers.write(0, 0x40, bank);
    BISS_EXPECT_EQ(*registers.read(0, 0x40), bank);
    BISS_EXPECT_EQ(registers.bsel(), bank);
    for (std::uint8_t address = 0; address < 64; ++address) {
      BISS_EXPECT(may(registers, RegisterAccess::read, address));
      BISS_EXPECT_EQ(may(registers, RegisterAccess::write, address), bank == 0);
      BISS_EXPECT_EQ(*registers.read(0, address), bank * 64 + address);
    }
    BISS_EXPECT_EQ(*registers.read(0, 0x45), 0x34);
  }
}

BISS_TEST(BankedRegisters, BankThatIsNotThere_HasNoRegisters) {
  Registers registers = three_banks();
  for (const std::uint8_t bank : std::array<std::uint8_t, 3>{3, 64, 255}) {
    registers.write(0, 0x40, bank);
    for (std::uint8_t address = 0; address < 64; ++address) {
      BISS_EXPECT(!may(registers, RegisterAccess::read, address));
      BISS_EXPECT(!may(registers, RegisterAccess::write, address));
    }
    BISS_EXPECT(may(registers, RegisterAccess::write, 0x40));
  }
}

BISS_TEST(BankedRegisters, OneBank_RefusesBsel) {
  BankedRegisters<1> registers;
  BISS_EXPECT(!registers.permits(0, RegisterAccess::read, 0x40));
  BISS_EXPECT(!registers.permits(0, RegisterAccess::write, 0x40));
  BISS_EXPECT(!registers.permits(0, RegisterAccess::read, 0x00));
  BISS_EXPECT(!registers.accepts(0, ControlCommand::user, false));
}

BISS_TEST(BankedRegisters, Protection_IsOfEachRegister) {
  Registers registers = three_banks();
  for (std::uint8_t address = 0x41; address < 0x80; ++address) {
    const bool serial = address >= 0x44 && address <= 0x47;
    const bool writable = address == 0x48;
    BISS_EXPECT_EQ(may(registers, RegisterAccess::write, address), writable) << address;
    BISS_EXPECT_EQ(may(registers, RegisterAccess::read, address),
                   serial || writable || address == 0x68)
        << address;
  }
  RegisterBank bank;
  const std::array<std::uint8_t, 3> three{1, 2, 3};
  bank.put(62, three, Level::read_write);
  BISS_EXPECT(bank[62] == 1 && bank[63] == 2 && bank[0] == 0);
  BISS_EXPECT(bank.permits(RegisterAccess::write, 63) && !bank.permits(RegisterAccess::read, 0));
  bank.protect(63, Level::not_available);
  BISS_EXPECT(!bank.permits(RegisterAccess::read, 63));
  bank.put_number<8>(0, 0x1122334455667788, Level::read_only);
  BISS_EXPECT(bank[0] == 0x11 && bank[7] == 0x88 && bank[8] == 0);
}

BISS_TEST(BankedRegisters, Hooks_RenewWhatIsReadAndHearWhatIsWritten) {
  Registers registers = three_banks();
  BISS_EXPECT_EQ(*registers.read(0, 0x68), 0);
  BISS_EXPECT_EQ(*registers.read(0, 0x68), 1);
  registers.write(0, 0x40, 2);
  registers.write(0, 0x48, 0x99);
  BISS_EXPECT_EQ(registers.value(0x48), 0x99);
  BISS_EXPECT_EQ(*registers.read(0, 0x48), 0x99);
  const Hooks& hooks = registers.hooks();
  BISS_EXPECT(hooks.written_count == 2 && hooks.bank == 2);
  BISS_EXPECT(hooks.address == 0x48 && hooks.value == 0x99);
  BISS_EXPECT(registers.accepts(0, ControlCommand::user, true));
  BISS_EXPECT(!registers.accepts(0, ControlCommand::channels, true));
  registers.execute(0, ControlCommand::user, true);
  BISS_EXPECT_EQ(hooks.executed, 1);
}

BISS_TEST(BankedRegisters, Busy_IsCountedForEachByte) {
  Registers registers({}, {.read_frames = 2, .write_frames = 3});
  registers.put_number<1>(0x48, 0, Level::read_write);
  for (int round = 0; round < 2; ++round) {
    BISS_EXPECT(may(registers, RegisterAccess::read, 0x48));
    BISS_EXPECT(!registers.read(0, 0x48) && !registers.read(0, 0x48) && registers.read(0, 0x48));
    BISS_EXPECT(may(registers, RegisterAccess::write, 0x48));
    BISS_EXPECT(!registers.ready(0) && !registers.ready(0) && !registers.ready(0));
    BISS_EXPECT(registers.ready(0));
  }
  registers.hooks().busy_for = 2;
  BISS_EXPECT(may(registers, RegisterAccess::write, 0x48));
  BISS_EXPECT(!registers.ready(0) && !registers.ready(0) && !registers.ready(0));
  BISS_EXPECT(!registers.ready(0) && !registers.ready(0) && registers.ready(0));
}

BISS_TEST(BankedRegisters, PerSlave_KeepsThemApart) {
  PerSlave<Registers, 2> device{{three_banks(), three_banks()}};
  device.write(1, 0x40, 1);
  BISS_EXPECT(device.owner[0].bsel() == 0 && device.owner[1].bsel() == 1);
  BISS_EXPECT(device.permits(0, RegisterAccess::write, 0x00));
  BISS_EXPECT(!device.permits(1, RegisterAccess::write, 0x00));
  BISS_EXPECT_EQ(*device.read(1, 0x03), 67);
  BISS_EXPECT(device.ready(1) && device.accepts(1, ControlCommand::user, false));
  device.execute(1, ControlCommand::user, false);
  BISS_EXPECT(device.owner[0].hooks().executed == 0 && device.owner[1].hooks().executed == 1);
}

}  // namespace biss::test::banked_registers_test
