// The examples of the core's headers, compiled but never run. header_examples.py compares the lines
// between two `// ----` with the named header.
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "biss/axis/scale.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/configure/configure_cycle.hpp"
#include "biss/control/session.hpp"
#include "biss/eds/check.hpp"
#include "biss/eds/device.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/master/polled_read.hpp"
#include "biss/master/request.hpp"
#include "biss/safety/configurations.hpp"
#include "biss/safety/monitor.hpp"
#include "biss/slave/banked_registers.hpp"
#include "biss/slave/register_server.hpp"
#include "biss/slave/slave.hpp"

namespace biss {

void use(auto&&...);
void print(auto&&...);
void read_with(auto&&...);
void wait_until(Picoseconds);
void stop();

// ---- biss/catalogue/catalogue.hpp
namespace catalogue_example {
constexpr CatalogueEntry encoder = catalogue_encoder("resolute-26");
using Codec = FixedCodec<encoder.frame_format()>;
}  // namespace catalogue_example

// ---- biss/configure/configurator.hpp
void configure(Picoseconds now, CdsBit cds) {
  Configurator configurator;
  while (!configurator.done()) {
    const ConfigureRequest& request = configurator.request();
    // Make a request of request.kind, not before request.at, that ends with `cdm`:
    const bool cdm = configurator.answer(now, cds);
    use(request, cdm);
  }
}

// ---- biss/configure/configure_cycle.hpp
void configure_by_cycle(Picoseconds now, bool slo, Picoseconds period) {
  ConfigureCycle cycle;
  StepOutput out = cycle.begin(now);
  while (!cycle.done()) out = cycle.step(now, slo);  // at each change of SLO and each deadline
  const auto result = cycle.result();
  if (result.ok()) read_with(result->format, result->master_setup(period));
  use(out);
}

// ---- biss/control/session.hpp
void read_profile(Picoseconds now, CdsBit cds) {
  ControlSession session;
  std::array<std::uint8_t, 2> profile;
  session.read(0, 0x42, profile);
  // Once per BiSS frame, between its CDS and its end:
  const bool cdm = session.step(now, cds);  // the CDM bit that ends this frame
  if (session.done() && !session.outcome().error) use(profile);
  use(cdm);
  const auto transfer = [](bool ahead) { use(ahead); };
  transfer(session.cdm_ahead());
  session.take_cds(now, cds);
}

// ---- biss/eds/check.hpp
void check(const EdsImage& image) {
  check_eds(image, [](const biss::EdsFinding& finding) { print(finding); });
}

// ---- biss/eds/device.hpp
void describe(const EdsImage& image, Hertz clock) {
  const auto device =
      describe_device(image, {}, [](const biss::EdsRemark& remark) { print(remark); });
  if (device.ok()) use(device->format, timing_at(*device, clock));
}

// ---- biss/frame/fixed.hpp
void decode(const BitView& bits) {
  constexpr auto format = frame_format("pos26,nE,nW,crc6;cds0");
  const auto frame = decode_frame(bits, FixedCodec<format>{});
  use(frame);
}
void decode_channel(std::uint64_t word) {
  constexpr auto format = frame_format("pos24,nE,nW,crc6");
  using Encoder = FixedChannel<format.channel_list[0]>;
  const auto channel = Encoder::decode(word);
  use(channel);
}

// ---- biss/axis/scale.hpp
template <class Axis>
void scale(const Axis& axis) {
  constexpr AxisScale microdegrees{360'000'000, 1 << 26};  // an encoder of 26 bits per turn
  const auto angle = microdegrees(axis.position().position);
  use(angle);
}

// ---- biss/frame/format_text.hpp
namespace format_example {
constexpr FrameFormat format = frame_format("pos26,nE,nW,crc6;cds0");
}

// ---- biss/master/polled_read.hpp
namespace polled_example {
constexpr FixedCodec<frame_format("pos18,nE,nW,crc6")> codec;
constexpr DeviceTiming timing{.timeout = {TimeoutRule::fixed, microseconds(20)}};
void other_work();
struct Board {              // an SPI; for pins see PolledPins
  std::uint8_t transfer();  // makes eight clocks and returns the bits
  // Only if the board has a clock:
  static constexpr biss::Picoseconds time_step = biss::microseconds(1);
  biss::Picoseconds now();
};
void read(Board& board) {
  constexpr biss::SpiSetup setup{.period = biss::microseconds(2),
                                 .line_delay = {.max = biss::microseconds(1)},
                                 .max_pause = biss::microseconds(12)};
  constexpr biss::SpiReader reader(codec, setup, timing);
  biss::PolledRequest request(board, setup, timing);
  std::array<std::uint8_t, reader.bytes()> buffer;

  request.start(buffer);                                              // reader.bytes() bytes
  while (request.step() == biss::PolledState::running) other_work();  // shorter than max_pause
  use(reader.read(buffer));
}
}  // namespace polled_example

// ---- biss/master/request.hpp
void request(RequestCycle<PlainCodec>& master, Picoseconds now, bool slo) {
  StepOutput out = master.begin(now, slo);
  while (!master.done()) {
    wait_until(out.deadline);  // or until SLO changes
    out = master.step(now, slo);
  }
  use(master.reading());
}

// ---- biss/safety/monitor.hpp
void monitor(Picoseconds now, Picoseconds second, const BitView& bits) {
  constexpr auto type = safety_configuration("fs-36-28");
  SafetyMonitor<FixedSafetyPlan<type.frame_format(), type.setup>> monitor;
  if (!monitor.self_test()) stop();  // at power-up
  // Every request, answered or not:
  const SafetyJudgement judgement = monitor.step(TwoClocks{now, second}, bits);
  judgement.position ? use(judgement.position->low, judgement.position->high) : stop();
  // At deadline(), or in a tick:
  if (monitor.watch(TwoClocks{now, second}).verdict != SafetyVerdict::safe) stop();
}

// ---- biss/safety/plan.hpp
void plan() {
  constexpr auto type = safety_configuration("fs-36-28");
  SafetyMonitor<FixedSafetyPlan<type.frame_format(), type.setup>> monitor;
  use(monitor);
}

// ---- biss/slave/banked_registers.hpp
namespace banks_example {
struct Device : NoRegisterHooks {  // what the registers do
  void written(std::uint8_t bank, std::uint8_t address, std::uint8_t value);
};
void serve(std::span<const std::uint8_t, bank_bytes> eds) {
  BankedRegisters<2, Device> registers;
  registers.bank(1) = RegisterBank(eds, RegisterProtection::read_only);
  registers.put_number<2>(reg::mfr_id, 0x6943, RegisterProtection::read_only);
  RegisterServer server(registers);
  use(server);
}
}  // namespace banks_example

// ---- biss/slave/register_server.hpp
namespace server_example {
struct Registers {
  bool permits(unsigned slave, RegisterAccess access, std::uint8_t address);
  std::optional<std::uint8_t> read(unsigned slave, std::uint8_t address);
  bool ready(unsigned slave);
  void write(unsigned slave, std::uint8_t address, std::uint8_t value);
  bool accepts(unsigned slave, ControlCommand command, bool broadcast);
  void execute(unsigned slave, ControlCommand command, bool broadcast);
};
RegisterServer server(Registers{});  // a RegisterOwner
struct Encoder {                     // the source of a Slave
  bool cds(bool predecessor) { return server.cds(predecessor); }
  void cdm(bool bit) { server.cdm(bit); }
};
}  // namespace server_example

// ---- biss/slave/slave.hpp
namespace slave_example {
struct Encoder {
  BasicFrame<1> sample(Picoseconds moment);  // the channels' values at that moment
  bool cds(bool predecessor);                // the CDS bit, requested when it is sent
  void cdm(bool bit);                        // the CDM bit, after a frame has ended
};
void answer(const FrameCodec<CrcFast, 1>& codec, const DeviceTiming& device, Picoseconds now,
            bool ma, bool sli) {
  Slave slave(codec, slave_timing(device), Encoder{});
  StepOutput out = slave.step(now, ma, sli);  // at each change of an input, and at out.deadline
  use(out);
}
}  // namespace slave_example

}  // namespace biss
