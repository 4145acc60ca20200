// biss_slave: the core's Slave, with callbacks in C.
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "biss/frame/codec.hpp"
#include "biss/slave/register_server.hpp"
#include "biss/slave/slave.hpp"
#include "capi/device.hpp"

namespace biss::capi {

namespace {

// The owner of the core's register server; it passes the calls on.
struct CallbackRegisters {
  biss_slave_setup setup;
  bool channels_active = true;

  bool permits(unsigned, RegisterAccess access, std::uint8_t address) const {
    return setup.register_permits(setup.user, access == RegisterAccess::write, address);
  }
  std::optional<std::uint8_t> read(unsigned, std::uint8_t address) const {
    const int value = setup.register_read(setup.user, address);
    if (value < 0) return std::nullopt;
    return static_cast<std::uint8_t>(value);
  }
  static bool ready(unsigned) { return true; }
  void write(unsigned, std::uint8_t address, std::uint8_t value) const {
    setup.register_write(setup.user, address, value);
  }
  static bool accepts(unsigned, ControlCommand command, bool /*broadcast*/) {
    return command == ControlCommand::channels || command == ControlCommand::control;
  }
  void execute(unsigned, ControlCommand command, bool broadcast) {
    if (command == ControlCommand::channels) channels_active = !broadcast;
  }
};

// The owner of the core's slave.
class CallbackSource {
 public:
  CallbackSource(const biss_slave_setup& setup, const FrameFormat& format)
      : setup_(setup), format_(format) {
    if (setup.register_permits != nullptr) registers_.emplace(CallbackRegisters{setup});
  }

  Frame sample(Picoseconds moment) {
    std::array<biss_channel, max_channels> channels{};
    for (biss_channel& channel : channels) channel.nE = channel.nW = true;
    setup_.sample(setup_.user, moment.count, channels.data(), format_.channel_count);
    Frame frame;
    frame.channel_count = format_.channel_count;
    frame.channel_list = std::bit_cast<std::array<Channel, max_channels>>(channels);
    if (!fits(channels)) {
      value_range_ = true;
      frame.channel_list.fill({.nE = false, .nW = false});
    }
    return frame;
  }

  // The CDS of a predecessor is passed on.
  bool cds(bool predecessor) {
    if (registers_) return registers_->cds(predecessor);
    return (setup_.cds != nullptr && setup_.cds(setup_.user)) || predecessor;
  }
  void cdm(bool bit) {
    if (registers_) return registers_->cdm(bit);
    if (setup_.cdm != nullptr) setup_.cdm(setup_.user, bit);
  }
  /// As the master commanded.
  bool channels_active() const { return !registers_ || registers_->owner().channels_active; }

  /// Whether a value did not fit since the last call.
  bool take_value_range() { return std::exchange(value_range_, false); }

 private:
  bool fits(std::span<const biss_channel, max_channels> channels) const {
    for (std::size_t k = 0; k < format_.channel_count; ++k) {
      const ChannelFormat& format = format_.channel_list[k];
      if ((channels[k].position & ~low_mask(format.position_bits())) != 0) return false;
      if ((channels[k].life_counter & ~low_mask(format.life_counter.bits)) != 0) return false;
    }
    return true;
  }

  biss_slave_setup setup_;
  FrameFormat format_;
  std::optional<RegisterServer<CallbackRegisters>> registers_;
  bool value_range_ = false;
};

biss_status check_registers(const biss_slave_setup& setup, const FrameFormat& format) {
  const bool read = setup.register_read != nullptr;
  const bool write = setup.register_write != nullptr;
  if (read != write || read != (setup.register_permits != nullptr)) return BISS_NULL_ARGUMENT;
  if (!read) return BISS_OK;
  // Their answers are in CDS.
  const bool possible = setup.cds == nullptr && setup.cdm == nullptr && !format.cds0;
  return possible ? BISS_OK : BISS_BAD_SETUP;
}

SlaveTiming timing_of(const Described& device, const biss_slave_setup& setup) {
  SlaveTiming timing = slave_timing(device.timing, picoseconds(setup.ready_ps));
  timing.chained = setup.chained;
  return timing;
}

struct Encoder {
  Encoder(const Described& device, const biss_slave_setup& setup)
      : slave(FrameCodec<>(device.format), timing_of(device, setup),
              CallbackSource(setup, device.format)) {}

  Slave<FrameCodec<>, CallbackSource> slave;
  Clock clock;
  bool stepping = false;
};

}  // namespace

extern "C" {

biss_slave_setup biss_slave_defaults(const biss_format* format) {
  biss_slave_setup setup{};
  setup.format = format;
  return setup;
}

biss_status biss_slave_init(biss_slave* slave, const biss_slave_setup* setup) {
  if (const auto wrong = begin_init(slave, setup)) return wrong;
  if (setup->sample == nullptr) return BISS_NULL_ARGUMENT;
  Described device;
  if (const auto wrong = read(setup->format, device)) return wrong;
  if (!is_duration(setup->ready_ps)) return BISS_BAD_SETUP;
  if (const auto wrong = check_registers(*setup, device.format)) return wrong;
  return make<Encoder>(slave, device, *setup);
}

biss_status biss_slave_step(biss_slave* slave, int64_t now_ps, bool ma, bool sli,
                            biss_output* out) {
  if (const auto wrong = check_call(slave, out)) return wrong;
  auto& encoder = thing<Encoder>(slave);
  if (encoder.stepping) return BISS_REENTERED;
  if (const auto wrong = encoder.clock.check(now_ps)) return wrong;
  encoder.clock.set(now_ps);
  encoder.stepping = true;
  const StepOutput output = encoder.slave.step(picoseconds(now_ps), ma, sli);
  encoder.stepping = false;
  encoder.slave.set_channels_active(encoder.slave.source().channels_active());
  *out = {output.level, output.deadline.count};
  return encoder.slave.source().take_value_range() ? BISS_VALUE_RANGE : BISS_OK;
}

const char* biss_slave_state(const biss_slave* slave) {
  return is_open(slave) ? name_of(thing<Encoder>(slave).slave.state()).data() : nullptr;
}

}  // extern "C"

}  // namespace biss::capi
