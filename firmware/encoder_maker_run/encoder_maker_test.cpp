// Runs the encoder of firmware/encoder_maker under QEMU: a software master clocks MA, reads
// positions and accesses the registers in the same frames. Every result is checked.
#include <array>
#include <cstdint>
#include <span>

#include "biss/base/big_endian.hpp"
#include "biss/base/units.hpp"
#include "biss/control/session.hpp"
#include "biss/eds/bank.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "firmware/encoder_maker/encoder.hpp"
#include "firmware/platform/console.hpp"

namespace encoder_maker_run {
namespace {

using biss::ControlCommand;
using biss::ControlError;
using biss::Picoseconds;

constexpr std::uint32_t serial_number = 20'260'001;
constexpr Picoseconds half_period = biss::nanoseconds(500);
/// Frames per round of the encoder's main loop: about 12 ms, within the master's limit of 20 ms.
constexpr std::uint32_t main_loop_frames = 200;

/// A software model of pins, clock, sensor and flash.
struct FakeBoard {
  Picoseconds time = biss::microseconds(100);
  Picoseconds alarm = biss::never;
  bool ma_level = true;
  bool slo = true;
  bool masked = false;
  std::uint32_t stored_offset = 0;
  std::uint32_t stores = 0;

  Picoseconds now() const { return time; }
  bool ma() const { return ma_level; }
  void drive_slo(bool level) { slo = level; }
  void set_alarm(Picoseconds at) { alarm = at; }
  /// A shaft at constant speed, one count in 1024 ns.
  std::uint32_t sensor(Picoseconds at) const {
    return static_cast<std::uint32_t>(at.count >> 20U) & 0xFF'FFFFU;
  }
  int temperature() const { return 23; }
  void mask_interrupts(bool mask) { masked = mask; }
  void store_offset(std::uint32_t offset) {
    stored_offset = offset;
    ++stores;
  }
};

using Codec = biss::FrameCodec<biss::CrcFast, 1>;
constexpr Codec codec{encoder_maker::format};

struct Line {
  FakeBoard board;
  encoder_maker::Encoder<FakeBoard> encoder{board, serial_number, 0};
  biss::ControlSession session;
  std::uint32_t frames = 0;
  std::uint32_t positions = 0;
  std::uint32_t short_frames = 0;
  std::uint32_t accesses = 0;
  std::uint32_t wrong = 0;
  bool channels_on = true;
  std::uint32_t latched = 0;  // the sensor at the first rising edge of MA
  std::uint32_t until_main_loop = main_loop_frames;
};

// Constant-initialised, like every object that is used before firmware_main().
constinit Line line;

void expect(bool right, const char* what) {
  if (right) return;
  ++line.wrong;
  firmware::print("WRONG: ", what, "\n");
}

void wait(Picoseconds time) {
  const Picoseconds end = line.board.time + time;
  while (line.board.alarm <= end) {
    line.board.time = line.board.alarm;
    line.encoder.step();
  }
  line.board.time = end;
}

void put_ma(bool level) {
  expect(!line.board.masked, "an interrupt while they are masked");
  line.board.ma_level = level;
  line.encoder.step();
  wait(half_period);
}

void check_position(const biss::BitBuffer<64>& bits) {
  const auto frame = biss::decode_frame(bits.view(), codec, biss::FrameBounds{});
  expect(frame.ok() && frame->trusted(), "a frame that cannot be trusted");
  if (!frame.ok()) return;
  const std::uint32_t expected = (line.latched + line.board.stored_offset) & 0xFF'FFFFU;
  expect(frame->channel_list[0].position == expected, "the position differs from the sensor");
  ++line.positions;
}

/// One request: LAT, ACK, START, CDS, the channel if it is on, STOP; then CDM and the timeout.
void frame() {
  biss::BitBuffer<64> bits;
  const unsigned clocks = 5 + (line.channels_on ? codec.payload_bits() : 0);
  for (unsigned i = 0; i < clocks; ++i) {
    put_ma(false);
    if (i == 0) line.latched = line.board.sensor(line.board.time);
    put_ma(true);
    bits.append(line.board.slo);
  }
  // 1 until ACK, 0, START.
  const bool begun = bits.view().word(0, 3) == 0b101U;
  expect(begun, "no START when it is due");
  if (line.channels_on) {
    check_position(bits);
  } else {
    ++line.short_frames;
  }
  const bool cds = bits.view()[3];
  const bool cdm =
      line.session.step(line.board.time, begun ? (cds ? biss::CdsBit::one : biss::CdsBit::zero)
                                               : biss::CdsBit::missing);
  if (cdm) put_ma(false);
  wait(biss::microseconds(21));
  expect(line.board.slo && line.board.alarm == biss::never, "not idle after the timeout");
  line.board.ma_level = true;
  line.encoder.step();
  wait(half_period);
  ++line.frames;
  if (--line.until_main_loop != 0) return;
  line.until_main_loop = main_loop_frames;
  line.encoder.do_ordered_work();
}

bool run() {
  ++line.accesses;
  for (int i = 0; i < 3000 && !line.session.done(); ++i) frame();
  return line.session.done() && !line.session.outcome().error;
}

bool read(unsigned address, std::span<std::uint8_t> to) {
  line.session.read(0, address, to);
  return run();
}

bool write(unsigned address, std::span<const std::uint8_t> from) {
  line.session.write(0, address, from);
  return run();
}

void read_what_it_is() {
  std::array<std::uint8_t, 8> id{};
  expect(read(biss::reg::dev_id, id), "device and manufacturer ID");
  expect(id[0] == 'E' && id[6] == 'X' && id[7] == 'X', "its name");
  std::array<std::uint8_t, 7> head{};
  expect(read(biss::reg::eds_bank, head), "EDS bank, profile, serial number");
  expect(head[1] == 0x62 && head[2] == 26, "BP3 with 24 bits of position");
  expect(biss::from_big_endian<4>(std::span(head).last<4>()) == serial_number, "serial number");

  for (unsigned bank = head[0]; bank < head[0] + 2U; ++bank) {
    expect(write(biss::reg::bsel, std::array{static_cast<std::uint8_t>(bank)}), "BSEL");
    biss::EdsBank eds{};
    expect(read(0, eds), "a bank of the EDS");
    expect(eds[0x3F] == biss::eds_checksum(eds) && eds[0] == 1, "its checksum and version");
    expect(!write(0x10, std::array<std::uint8_t, 1>{}), "the EDS can be written");
    expect(line.session.outcome().error == ControlError::refused_or_not_addressed, "not refused");
  }
}

void keep_user_bytes() {
  expect(write(biss::reg::bsel, std::array<std::uint8_t, 1>{encoder_maker::user_bank}), "BSEL 0");
  std::array<std::uint8_t, 32> kept{};
  for (unsigned i = 0; i < kept.size(); ++i) kept[i] = static_cast<std::uint8_t>(7 * i + 3);
  expect(write(0, kept), "32 user bytes");
  std::array<std::uint8_t, 32> back{};
  expect(read(0, back) && back == kept, "the user bytes are not those written");
  expect(!read(32, std::span(back).first(1)), "there are registers after the user bytes");
  expect(line.session.outcome().error == ControlError::refused, "not refused");
}

void preset() {
  namespace address = encoder_maker::address;
  const std::array<std::uint8_t, 3> wanted{0x12, 0x34, 0x56};
  expect(write(address::preset, wanted), "the preset's position");
  line.until_main_loop = main_loop_frames;  // so that the master's access comes first
  expect(write(address::command, std::array{encoder_maker::preset_command}), "the preset");
  std::array<std::uint8_t, 1> command{0xFF};
  expect(read(address::command, command) && command[0] == 0, "it is not done");
  expect(line.board.stores == 1, "the offset is not kept");
  expect(line.session.outcome().longest_busy > Picoseconds{}, "the write was not busy");
  // From here on check_position() counts with the new offset.
  expect(
      ((line.board.sensor(line.board.time) + line.board.stored_offset) & 0xFF'FFFFU) - 0x123456U <
          20'000U,
      "the position differs from the preset");
  expect(write(address::command, std::array<std::uint8_t, 1>{0x77}), "an unknown command");
  std::array<std::uint8_t, 2> status{};
  expect(read(address::status, status) && status[0] == 1, "the status does not show the refusal");
  expect(status[1] == 63, "23 °C");
}

void switch_channels() {
  line.session.broadcast(ControlCommand::channels);
  expect(run(), "channels off");
  line.channels_on = false;
  std::array<std::uint8_t, 2> id{};
  expect(read(biss::reg::mfr_id, id) && id[0] == 'X', "registers in short frames");
  line.session.command(1, ControlCommand::channels);
  expect(run(), "channels on");
  line.channels_on = true;
  expect(read(biss::reg::mfr_id, id) && id[0] == 'X', "registers together with positions again");
}

}  // namespace
}  // namespace encoder_maker_run

int firmware_main() {
  using namespace encoder_maker_run;
  read_what_it_is();
  keep_user_bytes();
  preset();
  switch_channels();
  firmware::print("frames ", line.frames, ": positions ", line.positions, ", short ",
                  line.short_frames, "; accesses ", line.accesses, ", presets ", line.board.stores,
                  "\n", line.wrong, " wrong\n");
  const bool good = line.wrong == 0 && line.short_frames > 80 && line.frames > 2000 &&
                    line.positions == line.frames - line.short_frames;
  return good ? 0 : 1;
}
