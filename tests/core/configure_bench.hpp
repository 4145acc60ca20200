// Encoders with registers on a line with an unconfigured master.
#pragma once

#include "biss/configure/configure_cycle.hpp"
#include "biss/eds/bank.hpp"
#include "biss/eds/bp3_part.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/profile.hpp"
#include "biss/frame/codec.hpp"
#include "biss/master/request.hpp"
#include "biss/slave/banked_registers.hpp"
#include "biss/slave/register_server.hpp"
#include "biss/slave/slave.hpp"
#include "tests/core/scripted_slo.hpp"
#include "tests/core/test.hpp"
#include "tests/core/wire.hpp"

namespace biss::test::configure {

/// The state of one encoder that tests change and check.
struct EncoderState {
  std::uint64_t position = 0;
  bool channels = true;
  bool obeys_channels = true;  // supports command 00
  bool unidirectional = false;
  bool keeps_bsel = false;  // BSEL can be read, not written
  std::uint32_t channel_commands = 0;
};

struct Hooks : NoRegisterHooks {
  EncoderState* state = nullptr;

  bool accepts(ControlCommand command, bool) const {
    return command == ControlCommand::channels && state->obeys_channels;
  }
  void execute(ControlCommand, bool broadcast) const {
    state->channels = !broadcast;
    ++state->channel_commands;
  }
};

inline constexpr std::size_t test_banks = 4;

struct Registers : BankedRegisters<test_banks, Hooks> {
  using Base = BankedRegisters<test_banks, Hooks>;
  using Base::Base;

  bool permits(unsigned slave, RegisterAccess access, std::uint8_t address) {
    if (hooks().state->keeps_bsel && address == reg::bsel && access == RegisterAccess::write) {
      return false;
    }
    return Base::permits(slave, access, address);
  }
};

using Server = RegisterServer<Registers>;
using Codec = FrameCodec<CrcBitwise, 1>;

struct Encoder {
  Server server;
  EncoderState* state = nullptr;

  BasicFrame<1> sample(Picoseconds) const {
    BasicFrame<1> frame;
    frame.channel_count = 1;
    frame.channel_list[0].position = state->position;
    return frame;
  }
  bool cds(bool predecessor) { return !state->unidirectional && server.cds(predecessor); }
  void cdm(bool bit) { server.cdm(bit); }
};

using EncoderSlave = Slave<Codec, Encoder, 256>;
/// A short queue, for a small stack: with a clock of 1 MHz few edges are in transit.
using ShortLine = BasicDelayLine<64>;

/// Encoders in a daisy chain; slave 0 is at the far end.
template <std::size_t Count>
struct Encoders {
  std::array<EncoderSlave, Count> slaves;

  StepOutput step(Picoseconds now, bool ma) {
    StepOutput all{.level = false};
    for (EncoderSlave& slave : slaves) {
      slave.set_channels_active(slave.source().state->channels);
      const StepOutput one = slave.step(now, ma, all.level);
      all = {one.level, std::min(one.deadline, all.deadline)};
    }
    return all;
  }
  Registers& registers(std::size_t k = 0) { return slaves[k].source().server.owner(); }
};

/// An encoder with the fields of the register map; the rest is not available.
struct Description {
  std::uint16_t profile = 0;
  std::uint8_t eds_bank = 0;
  std::uint32_t serial = 0xFFFF'FFFF;
  std::uint64_t device = 0x4142'4344'4546;
  std::uint16_t manufacturer = 0x6943;
  RegisterServerOptions options{};
};

inline EncoderSlave encoder(const FrameFormat& format, const SlaveTiming& timing,
                            const Description& description, EncoderState& state) {
  Hooks hooks;
  hooks.state = &state;
  Registers registers(hooks);
  constexpr auto read_only = RegisterProtection::read_only;
  registers.put_number<1>(reg::eds_bank, description.eds_bank, read_only);
  registers.put_number<2>(reg::bp_id, description.profile, read_only);
  registers.put_number<4>(reg::dev_sn, description.serial, read_only);
  registers.put_number<6>(reg::dev_id, description.device, read_only);
  registers.put_number<2>(reg::mfr_id, description.manufacturer, read_only);
  return EncoderSlave(Codec(format), timing,
                      Encoder{Server(registers, description.options), &state});
}

/// A part of a data sheet with its checksum, in a bank that is read-only.
template <class Part>
void put_part(Registers& registers, std::size_t bank, const Part& part) {
  registers.bank(bank) = RegisterBank(sealed(build_bank(part)), RegisterProtection::read_only);
}
inline EdsBank content_of(Registers& registers, std::size_t bank) {
  EdsBank bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = registers.bank(bank)[i];
  return bytes;
}

/// Bank 1: a common part with one channel; bank 2: its BP3 part, 12 bits of turns.
inline void put_eds(Registers& registers, std::uint16_t profile) {
  const auto position = static_cast<std::uint8_t>((profile & 0x7FU) - 2U);
  CommonPart common{.eds_len = 2,
                    .tma = 125,
                    .tclk_max = 10,
                    .tcyc = 160,
                    .tbusy_max = 40,
                    .busy_s = 1,
                    .dc_num = 1,
                    .sl_num = 1};
  common.channels[0] = {.bank = 2, .dlen = static_cast<std::uint8_t>(position + 2), .cpoly = 0x21};
  Bp3Part part{.bp_id = profile, .mt_len = 12};
  part.fi_len = static_cast<std::uint8_t>(position - 12);
  put_part(registers, 1, common);
  put_part(registers, 2, part);
}

inline FrameFormat format_of_profile(std::uint16_t profile) {
  return profile_format(profile).value();
}

inline constexpr SlaveTiming usual_timing{.ready = microseconds(3),
                                          .timeout = {TimeoutRule::fixed, microseconds(20)}};
/// The timing of slave `k` of a daisy chain.
constexpr SlaveTiming chain_timing(std::size_t k) {
  SlaveTiming timing = usual_timing;
  timing.chained = k != 0;
  return timing;
}

/// A master that configures itself, and the encoders.
template <class Device>
struct Line {
  ConfigureCycle cycle;
  Device& device;
  ShortLine way_out{Picoseconds{}};
  ShortLine way_back{Picoseconds{}};
  Picoseconds now{};
  /// From request `cut_at` on, for `cut_for` requests, SLO is high and the encoders receive
  /// nothing.
  std::uint32_t cut_at = 0xFFFF'FFFF;
  std::uint32_t cut_for = 0xFFFF'FFFF;
  /// MA low without an edge.
  Picoseconds longest_low{};

  Line(Device& of, const ConfigureOptions& options = {}, Picoseconds delay = {})
      : cycle(options), device(of), way_out(delay / 2), way_back(delay - delay / 2) {}

  /// Runs the complete configuration. False: it has not ended.
  bool run(std::uint64_t most_steps = 30'000'000) {
    StepOutput out = cycle.begin(now);
    StepOutput answered;
    bool ma_seen = true;
    Picoseconds fell = never;
    for (std::uint64_t i = 0; i < most_steps && !cycle.done(); ++i) {
      const std::uint32_t number = cycle.configurator().requests();
      const bool cut = number >= cut_at && number - cut_at < cut_for;
      const bool ma = way_out.level(now);
      if (!cut) ma_seen = ma;
      answered = device.step(now, ma_seen);
      way_back.put(now, answered.level);
      const bool slo = way_back.level(now);
      out = cycle.step(now, cut || slo);
      way_out.put(now, out.level);
      if (out.level) {
        if (fell != never) longest_low = std::max(longest_low, now - fell);
        fell = never;
      } else if (fell == never) {
        fell = now;
      }
      if (cycle.done()) break;
      now = std::max(now, std::min(std::min(out.deadline, answered.deadline),
                                   std::min(way_out.next(), way_back.next())));
    }
    BISS_EXPECT(out.level);
    return cycle.done();
  }
  /// Runs the complete configuration, which succeeds. \return its result, or nothing
  std::optional<Configuration> configured() {
    BISS_EXPECT(run());
    const auto result = cycle.result();
    if (result.ok()) return *result;
    BISS_EXPECT(result.ok()) << "cause " << static_cast<int>(result.error().cause);
    return std::nullopt;
  }
  ConfigureError cause() const {
    const auto result = cycle.result();
    BISS_EXPECT(!result.ok());
    return result.ok() ? ConfigureError{} : result.error().cause;
  }
};

/// Reads the line with the result of the configuration only.
template <class Device>
[[gnu::noinline]] auto read_with(const Configuration& config, Device& device, Picoseconds now,
                                 Picoseconds delay) {
  using Master = RequestCycle<FrameCodec<CrcBitwise, 3>>;
  test::Wire<Master, Device&, ShortLine> wire{
      .master{FrameCodec<CrcBitwise, 3>(config.format),
              config.master_setup(period_of(config.timing.clock_max))},
      .device = device,
      .way_out{ShortLine(delay / 2)},
      .way_back{ShortLine(delay - delay / 2)}};
  wire.now = now;
  return wire.request().frame;
}

}  // namespace biss::test::configure
