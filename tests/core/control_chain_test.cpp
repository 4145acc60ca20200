// Control communication on the line itself: a daisy chain of slaves, stepped by the edges of MA,
// and the session at its end. Frames with channels, without channels, and reduced ones.
#include "biss/control/session.hpp"
#include "biss/frame/decode.hpp"
#include "biss/slave/register_server.hpp"
#include "biss/slave/slave.hpp"
#include "tests/core/control_bench.hpp"
#include "tests/core/frames.hpp"
#include "tests/core/slave_bench.hpp"
#include "tests/core/test.hpp"

namespace biss::test::control_chain_test {

using Codec = FrameCodec<CrcFast, 1>;

constexpr FrameFormat format = format_of("pos5,nE,nW,crc6");
constexpr unsigned channel_bits = 13;

/// Commands 00 are the device's to execute.
struct DeviceOwner : TestOwner {
  bool* channels = nullptr;
  void execute(unsigned slave, ControlCommand command, bool broadcast) const {
    TestOwner::execute(slave, command, broadcast);
    if (command == ControlCommand::channels) *channels = !broadcast;
  }
};

struct DeviceSource {
  RegisterServer<DeviceOwner>* server = nullptr;
  std::uint64_t position = 0;
  BasicFrame<1> sample(Picoseconds) const {
    BasicFrame<1> frame;
    frame.channel_list[0].position = position;
    return frame;
  }
  bool cds(bool predecessor) const { return server->cds(predecessor); }
  void cdm(bool bit) const { server->cdm(bit); }
};

struct Device {
  TestRegisters registers;
  bool channels = true;
  RegisterServer<DeviceOwner> server{DeviceOwner{{&registers}, &channels}};
};

using DeviceSlave = Slave<Codec, DeviceSource, 128>;

DeviceSlave slave_at(std::size_t place) {
  const bool chained = place != 0;
  return {Codec(format),
          {.ready = chained ? Picoseconds{} : microseconds(3),
           .timeout = {TimeoutRule::fixed, nanoseconds(chained ? 12'500 : 15'000)},
           .chained = chained},
          DeviceSource{}};
}

template <std::size_t Count>
class ChainLine {
 public:
  ChainLine() : ChainLine(std::make_index_sequence<Count>{}) {}
  ChainLine(const ChainLine&) = delete;
  ChainLine& operator=(const ChainLine&) = delete;

  Device& device(std::size_t k) { return devices_[k]; }
  unsigned channels_on() const {
    unsigned count = 0;
    for (const DeviceSlave& each : chain.slave) count += each.channels_active() ? 1U : 0U;
    return count;
  }

  /// One request of `clocks` clocks (0: a complete frame); then CDM and the timeouts.
  void frame(unsigned clocks = 0) {
    chain.bits.clear();
    if (clocks == 0) clocks = 8 + static_cast<unsigned>(Count) + channel_bits * channels_on();
    chain.clock(clocks);
    const BitView bits = chain.bits.view();
    const std::size_t start = bits.find(true, bits.find(false, 0));
    CdsBit cds = CdsBit::missing;
    if (start + 1 < clocks) cds = bits[start + 1] ? CdsBit::one : CdsBit::zero;
    if (session.step(chain.now, cds)) chain.put(false);
    chain.wait(microseconds(16));
    BISS_EXPECT(chain.slave[Count - 1].state() == SlaveState::idle);
    chain.put(true);
    chain.wait(half);
    for (std::size_t k = 0; k < Count; ++k) {
      chain.slave[k].set_channels_active(devices_[k].channels);
    }
  }
  bool run(unsigned clocks = 0) {
    for (int i = 0; i < 1200 && !session.done(); ++i) frame(clocks);
    return session.done() && !session.outcome().error;
  }

  ControlSession session;
  SlaveChain<DeviceSlave, Count> chain;

 private:
  template <std::size_t... K>
  explicit ChainLine(std::index_sequence<K...>) : chain{{slave_at(K)...}} {
    ((chain.slave[K].source() = {&devices_[K].server, 3 * K + 1}), ...);
  }

  std::array<Device, Count> devices_{};
};

template <std::size_t Count>
void reads_and_writes() {
  ChainLine<Count> line;
  for (std::size_t k = 0; k < Count; ++k) {
    const auto slave = static_cast<unsigned>(k);
    std::array<std::uint8_t, 3> bytes{0x12, static_cast<std::uint8_t>(k), 0x00};
    line.session.write(slave, 0x7D, bytes);
    BISS_ASSERT(line.run()) << k;
    BISS_EXPECT_EQ(line.session.outcome().slaves_present, (1U << Count) - 1U);
    bytes = {};
    line.session.read(slave, 0x7D, bytes);
    BISS_ASSERT(line.run()) << k;
    BISS_EXPECT(bytes[0] == 0x12 && bytes[1] == k && bytes[2] == 0x00);
    for (std::size_t other = 0; other < Count; ++other) {
      BISS_EXPECT_EQ(line.device(other).registers.writes, other <= k ? 3 : 0);
    }
  }
}

BISS_TEST(ControlChain, FramesWithChannels_CarryRegisters) {
  reads_and_writes<1>();
  reads_and_writes<2>();
  reads_and_writes<3>();
  reads_and_writes<8>();
}

BISS_TEST(ControlChain, CommandsSwitchChannels_AndShortFramesDoTheSame) {
  ChainLine<3> line;
  line.session.broadcast(ControlCommand::channels);
  BISS_ASSERT(line.run());
  BISS_EXPECT_EQ(line.channels_on(), 0);
  // LAT, ACK and, as slave 0 needs no time without a position, START after three clocks.
  line.frame(9);
  BISS_EXPECT_EQ(line.chain.bits.view().word(0, 9), 0b100010000U);
  std::array<std::uint8_t, 2> bytes{0xA5, 0x5A};
  line.session.write(1, 0x10, bytes);
  BISS_ASSERT(line.run(7));
  bytes = {};
  line.session.read(1, 0x10, bytes);
  BISS_ASSERT(line.run(7));
  BISS_EXPECT(bytes[0] == 0xA5 && bytes[1] == 0x5A);

  line.session.command(0b100, ControlCommand::channels);
  BISS_ASSERT(line.run(7));
  BISS_EXPECT_EQ(line.channels_on(), 1);
  line.frame();
  const auto frame = decode_frame(line.chain.bits.view(), Codec(format), FrameBounds{});
  BISS_ASSERT(frame.ok());
  BISS_EXPECT_EQ(frame->channel_list[0].position, 7);
  line.session.command(0b011, ControlCommand::channels);
  BISS_ASSERT(line.run());
  BISS_EXPECT_EQ(line.channels_on(), 3);
}

BISS_TEST(ControlChain, ReducedFrames_CarryBroadcastsOnly) {
  ChainLine<2> line;
  line.session.broadcast(ControlCommand::user);
  BISS_ASSERT(line.run(2));
  for (std::size_t k = 0; k < 2; ++k) {
    BISS_EXPECT_EQ(line.device(k).registers.broadcast[3], 1);
  }
  std::array<std::uint8_t, 1> byte{};
  line.session.read(0, 0x10, byte);
  BISS_EXPECT(!line.run(2));
  BISS_EXPECT(line.session.outcome().error == ControlError::frame_lost);
  line.session.read(0, 0x10, byte);
  BISS_EXPECT(line.run());
}

BISS_TEST(ControlChain, FrameCutBehindCds_IsEnough) {
  ChainLine<2> line;
  line.device(0).registers.value[0x42] = 0x62;
  std::array<std::uint8_t, 1> byte{};
  // ACK of 3 us, one clock for the second slave, START, CDS.
  line.session.read(0, 0x42, byte);
  BISS_ASSERT(line.run(7));
  BISS_EXPECT_EQ(byte[0], 0x62);
  line.frame();
  const FrameCodec<CrcFast, 2> both(format_of("pos5,nE,nW,crc6+pos5,nE,nW,crc6"));
  const auto frame = decode_frame(line.chain.bits.view(), both, FrameBounds{});
  BISS_ASSERT(frame.ok());
  BISS_EXPECT(frame->channel_list[0].position == 4 && frame->channel_list[1].position == 1);
}

}  // namespace biss::test::control_chain_test
