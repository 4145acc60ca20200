// Runs the axis of firmware/safe_axis with a software encoder: good cycles without a false alarm;
// after each fault of the line or the board, no position until the fault is acknowledged.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/base/units.hpp"
#include "biss/frame/encode.hpp"
#include "biss/safety/configurations.hpp"
#include "biss/safety/monitor.hpp"
#include "firmware/platform/console.hpp"
#include "firmware/platform/startup.hpp"
#include "firmware/safe_axis/safe_axis.hpp"
#include "tests/core/random.hpp"

namespace safe_axis_run {
namespace {

constexpr auto type = biss::safety_configuration("fs-36-28");
using Plan = biss::FixedSafetyPlan<type.frame_format(), type.setup>;
using biss::SafetyVerdict;

// The leading ones and ACK of this encoder, CDS, both words, STOP.
constexpr std::size_t buffer_bytes = 32;
constexpr biss::Picoseconds period = biss::nanoseconds(31'250);
constexpr std::uint32_t cycles = 3000;
constexpr std::uint32_t fault_every = 50;

enum class Fault : std::uint8_t {
  flip,
  no_dma,
  no_interrupt,
  silent,
  error_bit,
  asked_twice,
  clock_jumps
};
constexpr std::array causes{SafetyVerdict::cpw_crc,   SafetyVerdict::no_frame,
                            SafetyVerdict::watchdog,  SafetyVerdict::watchdog,
                            SafetyVerdict::cpw_error, SafetyVerdict::no_frame,
                            SafetyVerdict::clock};

class FakeSpi {
 public:
  bool start(std::span<std::uint8_t> receive) {
    if (!receive_.empty()) return false;
    receive_ = receive;
    return true;
  }
  void write(std::span<const std::uint8_t> bytes) {
    std::fill(receive_.begin(), receive_.end(), std::uint8_t{0});
    std::copy_n(bytes.begin(), std::min(bytes.size(), receive_.size()), receive_.begin());
  }
  void end() { receive_ = {}; }

 private:
  std::span<std::uint8_t> receive_{};
};

struct Run {
  FakeSpi spi;
  safe_axis::SafeAxis<FakeSpi, biss::SafetyMonitor<Plan>, buffer_bytes> axis{spi};
  biss::test::Random random{0x5AFE'0001};
  std::uint64_t position = 0;
  std::uint32_t counter = 1;
  std::uint32_t wrong = 0;
};

biss::FrameBits answer(Run& run, bool nE) {
  run.position = (run.position + 123'456'789) & biss::low_mask(36);
  run.counter = run.counter == 63 ? 1 : run.counter + 1;
  Plan::Frame frame;
  frame.channel_count = 2;
  frame.lead_clocks = static_cast<std::uint16_t>(2U + run.random.below(5));
  frame.ack_clocks = static_cast<std::uint16_t>(33U + run.random.below(60));
  frame.channel_list[0] = {run.position, 0, nE, true};
  frame.channel_list[1] = {run.position >> 8U, run.counter, true, true};
  return biss::encode_frame(frame, Plan::codec()).value();
}

// The hardware's part of a cycle. False: no interrupt occurs.
bool transfer(Run& run, const Fault* fault) {
  auto bits = answer(run, fault == nullptr || *fault != Fault::error_bit);
  if (fault != nullptr && (*fault == Fault::no_interrupt || *fault == Fault::silent)) return false;
  if (fault != nullptr && *fault == Fault::flip) {
    bits.flip(bits.size_bits() - 2U - Plan::payload_bits() + run.random.below(38) + 1U);
  }
  if (fault == nullptr || *fault != Fault::no_dma) run.spi.write(bits.bytes());
  run.spi.end();
  return true;
}

void expect(Run& run, std::uint32_t cycle, bool right, const char* what) {
  if (right || ++run.wrong > 10) return;
  firmware::write("WRONG in cycle ");
  firmware::write_decimal(cycle);
  firmware::write(": ");
  firmware::write(what);
  firmware::write("\n");
}

// The second clock started elsewhere.
biss::TwoClocks clocks(biss::Picoseconds now) { return {now, now + biss::milliseconds(5)}; }

void cycles_of(Run& run) {
  std::uint32_t good_in_a_row = 0;
  for (std::uint32_t cycle = 0; cycle < cycles; ++cycle) {
    const biss::Picoseconds now = period * cycle;
    const bool faulty = cycle % fault_every == fault_every - 1U;
    const auto kind = static_cast<Fault>(cycle / fault_every % causes.size());
    auto asked = clocks(now);
    if (faulty && kind == Fault::clock_jumps) asked.now += biss::microseconds(2);
    run.axis.request(asked);
    // Before the watchdog reacts: the request that the board refuses is reported.
    if (faulty && kind == Fault::asked_twice) run.axis.request(clocks(now + period / 4));
    if (transfer(run, faulty ? &kind : nullptr)) run.axis.transfer_complete();
    biss::Picoseconds end = now + period;
    // The next request is refused, too: the SPI is still busy.
    if (faulty && kind == Fault::no_interrupt)
      run.axis.request(clocks(end - biss::microseconds(1)));
    if (faulty && kind == Fault::silent) end = now + 2 * period;
    const auto position = run.axis.position(clocks(end));
    good_in_a_row = faulty ? 0 : good_in_a_row + 1;
    if (faulty) {
      expect(run, cycle, !position, "a position after a fault");
      expect(run, cycle, run.axis.cause() == causes[static_cast<std::size_t>(kind)], "the cause");
      run.spi.end();
      expect(run, cycle, run.axis.acknowledge(run.axis.cause()), "the fault is not acknowledged");
      expect(run, cycle, run.axis.cause() == SafetyVerdict::starting,
             "the cause of an acknowledged fault");
    } else if (good_in_a_row < type.setup.start_frames) {
      expect(run, cycle, !position, "a position while starting");
    } else {
      expect(run, cycle, position && biss::control_position(Plan(), *position) == run.position,
             "the position is not the axis's");
    }
  }
}

// The end of a transfer that was not started: the last position stays.
void ends_twice(Run& run, biss::Picoseconds now) {
  for (std::uint8_t frame = 0; frame < type.setup.start_frames; ++frame, now += period) {
    run.axis.request(clocks(now));
    if (transfer(run, nullptr)) run.axis.transfer_complete();
    run.axis.transfer_complete();
  }
  const auto position = run.axis.position(clocks(now));
  expect(run, cycles, position && biss::control_position(Plan(), *position) == run.position,
         "an end that nothing waits for changes the position");
}

// A monitor without a self test gives no position.
void untested(Run& run) {
  run.axis.request(clocks({}));
  if (transfer(run, nullptr)) run.axis.transfer_complete();
  expect(run, 0, !run.axis.position(clocks(period)) && run.axis.cause() == SafetyVerdict::self_test,
         "a position before the self test");
}

constinit Run run;

}  // namespace
}  // namespace safe_axis_run

int firmware_main() {
  using namespace safe_axis_run;
  untested(run);
  expect(run, 0, run.axis.power_up(), "the self test fails");
  expect(run, 0, run.axis.cause() == SafetyVerdict::starting, "a cause after the self test");
  cycles_of(run);
  ends_twice(run, period * cycles);
  firmware::write("cycles ");
  firmware::write_decimal(cycles);
  firmware::write(", faults ");
  firmware::write_decimal(cycles / fault_every);
  firmware::write(", wrong ");
  firmware::write_decimal(run.wrong);
  firmware::write("\n");
  return run.wrong == 0 ? 0 : 1;
}
