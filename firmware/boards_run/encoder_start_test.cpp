// The start of an unknown encoder: asked, stored, and checked at the next start.
#include "firmware/boards/encoder_start.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "tests/core/configure_bench.hpp"
#include "tests/core/eds_banks.hpp"
#include "tests/core/test.hpp"

namespace encoder_start_test {

using namespace biss;
using namespace biss::test::configure;
using boards::StartCause;

// ---- Two encoders of the house's examples, and the line

/// 12 bits of turns and 20 in a turn, 10 MHz, adaptive timeout: the banks were typed by hand.
EncoderSlave multiturn(EncoderState& state, std::uint32_t serial = 4711) {
  auto slave = encoder(format_of_profile(0x6222), usual_timing,
                       {.profile = 0x6222, .eds_bank = 1, .serial = serial}, state);
  Registers& registers = slave.source().server.owner();
  constexpr auto read_only = RegisterProtection::read_only;
  registers.bank(1) = RegisterBank(biss::test::one_channel, read_only);
  registers.bank(3) = RegisterBank(biss::test::multiturn_12_20, read_only);
  return slave;
}

/// 18 bits, 4 MHz, fixed timeout.
EncoderSlave rotary(EncoderState& state, std::uint32_t serial = 4712) {
  auto slave = encoder(format_of_profile(0x6214), usual_timing,
                       {.profile = 0x6214, .eds_bank = 1, .serial = serial}, state);
  Registers& registers = slave.source().server.owner();
  CommonPart common{.eds_len = 2, .tma = 250, .to_min = 50, .to_max = 80, .dc_num = 1, .sl_num = 1};
  common.channels[0] = {.bank = 2, .dlen = 20, .cpoly = 0x21};
  put_part(registers, 1, common);
  registers.bank(2) = RegisterBank(biss::test::rotary_18, RegisterProtection::read_only);
  return slave;
}

/// Flash of which power can fail.
struct Flash {
  RecordBytes bytes{};
  /// Bytes that are still written.
  std::size_t power = 0xFFFF'FFFF;
  std::uint32_t stores = 0;

  Flash() { bytes.fill(0xFF); }
  void store(const RecordBytes& from) {
    ++stores;
    bytes.fill(0xFF);
    std::copy_n(from.begin(), std::min(power, from.size()), bytes.begin());
  }
};

/// An SPI peripheral in mode 3 with DMA, the encoder at its pins, and the flash.
struct Port {
  Flash flash{};
  EncoderSlave* slave = nullptr;
  EncoderState* state = nullptr;
  std::span<std::uint8_t> receive{};
  Picoseconds now{};
  Picoseconds period{};
  bool slo = true;
  Picoseconds deadline = never;
  std::uint32_t transfers = 0;

  bool start(std::span<std::uint8_t> into) {
    if (!receive.empty()) return false;
    receive = into;
    ++transfers;
    return true;
  }
  void hold_ma_low() { drive(false); }
  void load(RecordBytes& to) const { to = flash.bytes; }
  void store(const RecordBytes& from) { flash.store(from); }
  Picoseconds set_clock(Hertz most) {
    period = std::max(period_of(most), nanoseconds(200));
    return period;
  }

  void step(Picoseconds at, bool ma) {
    now = at;
    if (slave == nullptr) return;
    slave->set_channels_active(state->channels);
    const StepOutput out = slave->step(now, ma, false);
    slo = out.level;
    deadline = out.deadline;
  }
  void drive(bool level) {
    ma_ = level;
    step(now, level);
  }
  void wait_until(Picoseconds at) {
    while (deadline <= at) step(deadline, ma_);
    now = at;
  }
  /// Makes the transfer that was started. False: there is none.
  bool transfer() {
    if (receive.empty()) return false;
    if (!ma_) drive(true);
    wait_until(now + period);
    for (std::size_t i = 0; i < 8 * receive.size(); ++i) {
      drive(false);
      wait_until(now + period / 2);
      if (!slo && slave != nullptr) {
        receive[i / 8] = static_cast<std::uint8_t>(receive[i / 8] & ~(0x80U >> i % 8));
      }
      drive(true);
      wait_until(now + period / 2);
    }
    receive = {};
    return true;
  }

 private:
  bool ma_ = true;
};

constexpr Picoseconds cycle = microseconds(100);
constexpr AxisSetup axis_setup{.cycle = cycle, .max_step = no_step_limit};
constexpr LineDelayRange line_delay{.max = nanoseconds(500)};
using Start = boards::EncoderStart<Port, 40>;

/// A board from power-on: its flash and what is connected survive.
struct Board {
  Port port{};
  Flash& flash = port.flash;
  std::optional<Start> start{};
  std::uint32_t cycles = 0;
  boards::StartFault last{};
  std::uint32_t causes = 0;

  void connect(EncoderSlave* slave, EncoderState* state) {
    port.slave = slave;
    port.state = state;
    port.slo = true;
    port.deadline = never;
  }
  void power_on() {
    port.receive = {};
    start.emplace(port, axis_setup, line_delay);
    cycles = causes = 0;
  }
  void one_cycle(bool fails = false, bool is_lost = false) {
    ++cycles;
    port.wait_until(std::max(port.now, cycle * std::int64_t{cycles} + begun_));
    start->request(port.now);
    if (!port.transfer() || is_lost) return;
    start->transfer_ended(!fails);
  }
  /// Runs until a cause, or until it is ready. \return the cause
  std::optional<StartCause> next(std::uint32_t most = 20'000) {
    begun_ = port.now - cycle * std::int64_t{cycles};
    while (!ready() && most-- != 0) {
      if (const auto fault = start->advance()) {
        ++causes;
        last = *fault;
        return last.cause;
      }
      if (!ready()) one_cycle();
    }
    return std::nullopt;
  }
  bool ready() { return start->link() != nullptr; }
  /// Cycles of the link that is ready, until its position.
  void expect_position(std::uint64_t position) {
    BISS_ASSERT(ready());
    for (int i = 0; i < 2; ++i) one_cycle();
    const AxisPosition now = start->link()->axis().position();
    BISS_EXPECT(now.state == AxisState::measured);
    BISS_EXPECT_EQ(static_cast<std::uint64_t>(now.position), position);
  }
  bool has_record() const { return read_record(flash.bytes).ok(); }

 private:
  Picoseconds begun_{};
};

/// A board whose flash has the record of the encoder.
void learn(Board& board, EncoderSlave& slave, EncoderState& state) {
  board.connect(&slave, &state);
  board.power_on();
  BISS_EXPECT(board.next() == StartCause::record);
  BISS_EXPECT(board.last.record == RecordError::erased);
  BISS_EXPECT(board.start->link() == nullptr);
  BISS_EXPECT(!board.next());
  BISS_ASSERT(board.ready());
  BISS_EXPECT(board.has_record());
}

// ---- Tests

BISS_TEST(EncoderStart, FirstStartAndSecondStart_ReadTwoEncoders) {
  for (const bool second : {false, true}) {
    EncoderState state{.position = 0x2'5A5A};
    EncoderSlave slave = second ? rotary(state) : multiturn(state);
    Board board;
    learn(board, slave, state);
    const std::uint32_t first = board.cycles;
    BISS_EXPECT_EQ(board.start->reader().codec().format().channel_list[0].position_bits(),
                   second ? 18U : 32U);
    BISS_EXPECT_EQ(board.port.period.count, second ? 250'000 : 200'000);
    board.expect_position(0x2'5A5A);

    board.power_on();
    BISS_EXPECT(!board.next());
    BISS_EXPECT_EQ(board.causes, 0U);
    BISS_EXPECT_EQ(board.flash.stores, 1U);
    BISS_EXPECT(board.cycles < 400);
    BISS_EXPECT(first > 5'000) << first << ' ' << board.cycles;
    board.expect_position(0x2'5A5A);
  }
}

// The axis has no position before the registers were read in frames of the stored format.
BISS_TEST(EncoderStart, OtherEncoderAtTheSecondStart_IsNamedAndAsked) {
  for (const bool other_format : {false, true}) {
    EncoderState state{.position = 1234};
    EncoderSlave known = multiturn(state);
    EncoderSlave other = other_format ? rotary(state) : multiturn(state, 4713);
    Board board;
    learn(board, known, state);
    board.connect(&other, &state);
    board.power_on();
    const auto cause = board.next();
    BISS_EXPECT(cause == (other_format ? StartCause::registers : StartCause::other_encoder));
    BISS_EXPECT(board.start->link() == nullptr);
    BISS_EXPECT(board.has_record());  // of the known encoder
    BISS_EXPECT(!board.next());
    BISS_EXPECT_EQ(std::uint32_t{read_record(board.flash.bytes)->serial},
                   other_format ? 4712U : 4713U);
    board.expect_position(1234);
  }
}

BISS_TEST(EncoderStart, RecordDamagedInAnyBit_IsNamedAndTheEncoderIsAsked) {
  EncoderState state{.position = 99};
  EncoderSlave slave = rotary(state);
  Board board;
  learn(board, slave, state);
  const RecordBytes good = board.flash.bytes;
  std::array<std::uint32_t, 5> seen{};
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    board.flash.bytes = good;
    board.flash.bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    board.power_on();
    const auto fault = board.start->advance();
    BISS_ASSERT(fault && fault->cause == StartCause::record);
    BISS_EXPECT(!board.ready());
    ++seen[static_cast<std::size_t>(*fault->record)];
  }
  BISS_EXPECT(seen == (std::array<std::uint32_t, 5>{0, 32, 16, 16, 8 * 156 - 64}));
  BISS_EXPECT(!board.next());
  BISS_EXPECT(board.flash.bytes == good);
  board.expect_position(99);
}

BISS_TEST(EncoderStart, PowerLostWhileTheRecordIsWritten_LeavesNoRecord) {
  EncoderState state{.position = 7};
  EncoderSlave slave = multiturn(state);
  Board board;
  learn(board, slave, state);
  const RecordBytes good = board.flash.bytes;
  for (std::size_t written = 0; written < good.size(); ++written) {
    Flash cut;
    cut.power = written;
    cut.store(good);
    BISS_EXPECT(!read_record(cut.bytes).ok());
  }
  // The same in a start, which goes on without a record.
  board.flash = {};
  board.flash.power = 77;
  board.power_on();
  BISS_EXPECT(board.next() == StartCause::record);
  BISS_EXPECT(board.next() == StartCause::not_stored);
  board.expect_position(7);
  board.power_on();
  BISS_EXPECT(board.next() == StartCause::record);
  BISS_EXPECT(board.last.record == RecordError::checksum);
}

// Identity and data sheet of two encoders are never one record.
BISS_TEST(EncoderStart, EncoderChangedWhileItIsAsked_IsAskedAgain) {
  std::uint32_t other = 0;
  for (const bool other_format : {false, true}) {
    for (const std::uint32_t at : {321U, 337U, 343U, 1'100U, 2'200U}) {
      EncoderState state{.position = 4321};
      EncoderSlave before = multiturn(state);
      EncoderSlave after = other_format ? rotary(state) : multiturn(state, 4713);
      Board board;
      board.connect(&before, &state);
      board.power_on();
      BISS_EXPECT(board.next() == StartCause::record);
      while (board.port.transfers < at) board.one_cycle();
      state.channels = true;
      board.connect(&after, &state);
      while (const auto cause = board.next()) {
        BISS_ASSERT(board.causes < 5);
        if (cause == StartCause::other_encoder) ++other;
      }
      BISS_EXPECT_EQ(std::uint32_t{board.start->record().serial}, other_format ? 4712U : 4713U);
      BISS_EXPECT_EQ(board.start->reader().codec().format().channel_list[0].position_bits(),
                     other_format ? 18U : 32U);
      BISS_EXPECT_EQ(board.flash.stores, 1U);
      board.expect_position(4321);
    }
  }
  BISS_EXPECT(other > 0);
}

BISS_TEST(EncoderStart, SilentEncoder_IsNamedUntilItAnswers) {
  EncoderState state{.position = 11};
  EncoderSlave slave = rotary(state);
  Board board;
  board.power_on();
  BISS_EXPECT(board.next() == StartCause::record);
  for (int i = 0; i < 2; ++i) {
    BISS_EXPECT(board.next() == StartCause::configuration);
    BISS_EXPECT(board.last.configure->cause == ConfigureError::no_encoder);
  }
  board.connect(&slave, &state);
  BISS_EXPECT(!board.next());
  board.expect_position(11);

  board.connect(nullptr, nullptr);
  board.power_on();
  BISS_EXPECT(board.next() == StartCause::registers);
  BISS_EXPECT(board.last.control == ControlError::frame_lost);
  BISS_EXPECT(board.has_record());
}

// A board that was reset while it asked may have left the channels off.
BISS_TEST(EncoderStart, ChannelsLeftOff_AreActivatedAgain) {
  EncoderState state{.position = 21};
  EncoderSlave slave = multiturn(state);
  Board board;
  learn(board, slave, state);
  state.channels = false;
  board.power_on();
  BISS_EXPECT(board.next() == StartCause::registers);
  BISS_EXPECT(!board.next());
  board.expect_position(21);
}

BISS_TEST(EncoderStart, DataSheetWithAContradiction_GivesNoPosition) {
  EncoderState state;
  EncoderSlave slave = rotary(state);
  Registers& registers = slave.source().server.owner();
  EdsBank common = content_of(registers, 1);
  common[0x15] = 21;  // DLEN0, and 20 bits in the profile part
  registers.bank(1) = RegisterBank(sealed(common), RegisterProtection::read_only);
  Board board;
  board.connect(&slave, &state);
  board.power_on();
  BISS_EXPECT(board.next() == StartCause::record);
  BISS_EXPECT(board.next() == StartCause::configuration);
  BISS_EXPECT(board.last.configure->cause == ConfigureError::eds_contradiction);
  BISS_EXPECT(board.start->link() == nullptr);
  BISS_EXPECT_EQ(board.flash.stores, 0U);

  // The same data sheet in a record with a good checksum, of other firmware for example.
  SlaveDescription description;
  description.profile = 0x6214;
  description.eds_bank = 1;
  EdsImage image{.common = &common};
  image.profiles[0] = &biss::test::rotary_18;
  board.flash.bytes = std::bit_cast<RecordBytes>(record_of(description, image));
  board.power_on();
  BISS_EXPECT(board.next() == StartCause::configuration);
  BISS_EXPECT(board.last.configure->cause == ConfigureError::eds_contradiction);
}

BISS_TEST(EncoderStart, EncoderWithoutSerialNumber_IsNotStored) {
  EncoderState state{.position = 5};
  EncoderSlave slave = rotary(state, 0xFFFF'FFFF);
  Board board;
  board.connect(&slave, &state);
  board.power_on();
  BISS_EXPECT(board.next() == StartCause::record);
  BISS_EXPECT(board.next() == StartCause::no_serial);
  BISS_EXPECT_EQ(board.flash.stores, 0U);
  board.expect_position(5);
}

// Without a data sheet the clock is 1 MHz and ACK may take 40 µs.
BISS_TEST(EncoderStart, FrameLongerThanTheCycle_IsNamed) {
  EncoderState state;
  EncoderSlave slave = encoder(format_of_profile(0x6222), usual_timing, {.profile = 0x6222}, state);
  Board board;
  board.connect(&slave, &state);
  board.power_on();
  BISS_EXPECT(board.next() == StartCause::record);
  BISS_EXPECT(board.next() == StartCause::cycle);
  BISS_EXPECT(board.start->link() == nullptr);
}

// The DMA reports errors and loses ends in the middle of accesses, at most three times in one.
BISS_TEST(EncoderStart, TransfersThatFail_AreTriedAgain) {
  EncoderState state{.position = 6};
  EncoderSlave slave = multiturn(state);
  Board board;
  board.connect(&slave, &state);
  board.power_on();
  BISS_EXPECT(board.next() == StartCause::record);
  for (int i = 0; i < 20'000 && !board.ready(); ++i) {
    BISS_EXPECT(!board.start->advance());
    if (board.ready()) break;
    board.one_cycle(i % 2999 == 500, i % 2999 == 1900);
  }
  board.expect_position(6);
}

BISS_TEST(EncoderStart, SetupThatFitsNoEncoder_IsNamedAndAsksNothing) {
  const auto axis_error_of = [](const AxisSetup& setup) {
    Port port;
    Start start(port, setup, line_delay);
    const auto fault = start.advance();
    start.request({});
    BISS_EXPECT(fault && fault->cause == StartCause::setup);
    BISS_EXPECT_EQ(port.transfers, 0U);
    return fault ? fault->axis : std::nullopt;
  };
  BISS_EXPECT(axis_error_of({.cycle = cycle}) == AxisError::max_step);
  BISS_EXPECT(axis_error_of({.max_step = 1}) == AxisError::cycle);
}

}  // namespace encoder_start_test
