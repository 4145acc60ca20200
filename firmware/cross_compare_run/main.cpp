// Runs the two processors of firmware/cross_compare on one encoder and a channel with faults: torque
// only if both have the position, and none after any fault of the channel or of a processor.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "biss/frame/encode.hpp"
#include "firmware/cross_compare_run/processors.hpp"
#include "firmware/platform/console.hpp"
#include "firmware/platform/startup.hpp"
#include "tests/core/random.hpp"

namespace cross_compare_run {
namespace {

using biss::SafetyState;
using biss::SafetyVerdict;
using cross_compare::Message;

constexpr std::uint32_t cycles = 3000;
constexpr std::uint32_t fault_every = 50;
constexpr biss::Picoseconds period = biss::nanoseconds(31'250);

enum class Fault : std::uint8_t {
  message_lost,     // to B
  message_damaged,  // to A
  message_old,      // to B: that of the request before
  buffer_of_a,      // a bit of A's copy of the answer
  finding_of_b,     // B calculates another position
  line,             // a bit of the answer, in both copies
  echo,             // to B: its own message
  other_pair,       // to A: the message of the processor B of another pair
};
constexpr std::size_t fault_count = 8;
// Of processor A and B: what holds, and why.
struct Held {
  SafetyState state;
  SafetyVerdict cause;
};
struct Expected {
  Held a;
  Held b;
};
constexpr Held none{SafetyState::safe, SafetyVerdict::self_test};
constexpr Held late{SafetyState::latched, SafetyVerdict::watchdog};
constexpr Held differ{SafetyState::failed, SafetyVerdict::disagreement};
constexpr Held crc{SafetyState::latched, SafetyVerdict::cpw_crc};
constexpr std::array<Expected, fault_count> expected{{{none, late},
                                                      {late, none},
                                                      {none, late},
                                                      {differ, differ},
                                                      {differ, none},
                                                      {crc, crc},
                                                      {none, late},
                                                      {late, none}}};

struct Run {
  biss::test::Random random{0x5AFE'0040};
  std::uint64_t position = 0;
  std::uint32_t counter = 1;
  std::uint32_t wrong = 0;
  Message last_of_a{};
};

void expect(Run& run, std::uint32_t cycle, bool right, const char* what) {
  if (right || ++run.wrong > 10) return;
  firmware::write("WRONG in cycle ");
  firmware::write_decimal(cycle);
  firmware::write(": ");
  firmware::write(what);
  firmware::write("\n");
}

biss::FrameBits answer(Run& run) {
  run.position = (run.position + 123'456'789) & biss::low_mask(36);
  run.counter = run.counter == 63 ? 1 : run.counter + 1;
  Plan::Frame frame;
  frame.channel_count = 2;
  frame.lead_clocks = static_cast<std::uint16_t>(2U + run.random.below(5));
  frame.ack_clocks = static_cast<std::uint16_t>(32U + run.random.below(60));
  frame.channel_list[0] = {run.position, 0, true, true};
  frame.channel_list[1] = {run.position >> 8U, run.counter, true, true};
  return biss::encode_frame(frame, Plan::codec()).value();
}

// The clocks of a processor; all four started at other times.
biss::TwoClocks clocks(std::uint32_t cycle, std::int64_t processor) {
  const biss::Picoseconds now = period * cycle + biss::microseconds(700) * processor;
  return {now, now + biss::milliseconds(3)};
}

void check(Run& run, std::uint32_t cycle, const Firmware& processor, const Held& held,
           const char* what) {
  const bool holds = held.state != SafetyState::safe;
  expect(run, cycle, processor.state() == held.state, what);
  expect(run, cycle, !holds || processor.cause() == held.cause, "the cause");
}

// After a fault the machine stops; faults of a processor need a power-up of both.
void recover(Run& run, std::uint32_t cycle, bool power_up) {
  for (const Firmware* each : {&processor_a, &processor_b}) {
    if (power_up) {
      expect(run, cycle, each->power_up(), "the self test fails");
    } else if (each->state() == SafetyState::latched) {
      expect(run, cycle, each->acknowledge(each->cause()), "the acknowledgement");
    }
  }
}

void run_cycles(Run& run) {
  std::uint32_t good_in_a_row = 0;
  for (std::uint32_t cycle = 0; cycle < cycles; ++cycle) {
    const bool faulty = cycle % fault_every == fault_every - 1U;
    const auto fault = static_cast<Fault>(cycle / fault_every % fault_count);
    const auto is = [&](Fault kind) { return faulty && fault == kind; };
    biss::FrameBits bits_a = answer(run);
    // A bit of the CPW, before its CRC.
    const std::size_t bit =
        bits_a.size_bits() - 2U - Plan::payload_bits() + 1U + run.random.below(36);
    if (is(Fault::line)) bits_a.flip(bit);
    const biss::FrameBits bits_b = bits_a;
    if (is(Fault::buffer_of_a)) bits_a.flip(bit);

    Message to_b = processor_a.evaluate(cycle, bits_a.view());
    Message to_a = processor_b.evaluate(cycle, bits_b.view());
    const Message fresh = to_b;
    if (is(Fault::message_lost)) to_b = {};
    if (is(Fault::message_old)) to_b = run.last_of_a;
    if (is(Fault::message_damaged)) to_a[run.random.below(to_a.size())] ^= 0x10;
    if (is(Fault::echo)) to_b = to_a;
    if (is(Fault::finding_of_b) || is(Fault::other_pair)) {
      cross_compare::Address address{cycle, connection, cross_compare::Sender::line};
      auto finding = *cross_compare::decode(address, to_a);
      if (is(Fault::finding_of_b)) finding.spw_position ^= 1U;
      if (is(Fault::other_pair)) ++address.connection;
      to_a = cross_compare::encode(address, finding);
    }
    run.last_of_a = fresh;
    const auto at_a = processor_a.compare(clocks(cycle, 0), to_a);
    const auto at_b = processor_b.compare(clocks(cycle, 1), to_b);
    const bool torque = at_a && at_b && *at_a == *at_b;

    good_in_a_row = faulty ? 0 : good_in_a_row + 1;
    if (faulty) {
      expect(run, cycle, !torque, "torque after a fault");
      // A processor that did not get its message notices in the next period at the latest.
      processor_a.is_safe(clocks(cycle + 1U, 0));
      processor_b.is_safe(clocks(cycle + 1U, 1));
      const Expected& held = expected[static_cast<std::size_t>(fault)];
      check(run, cycle, processor_a, held.a, "the state of processor A");
      check(run, cycle, processor_b, held.b, "the state of processor B");
      const bool power_up =
          processor_a.state() == SafetyState::failed || processor_b.state() == SafetyState::failed;
      recover(run, cycle, power_up);
      // Both start together.
      if (!power_up) good_in_a_row = 0;
    } else if (good_in_a_row < type.setup.start_frames) {
      expect(run, cycle, !torque, "torque while starting");
    } else {
      expect(run, cycle, torque, "no torque without a fault");
      expect(run, cycle, biss::control_position(Plan(), *at_a) == run.position,
             "the position is not the encoder's");
    }
  }
}

constinit Run run;

}  // namespace
}  // namespace cross_compare_run

int firmware_main() {
  using namespace cross_compare_run;
  for (const Firmware* each : {&processor_a, &processor_b}) {
    expect(run, 0, each->state() == SafetyState::untested, "tested before power-up");
    expect(run, 0, each->power_up(), "the self test fails");
  }
  run_cycles(run);
  firmware::write("cycles ");
  firmware::write_decimal(cycles);
  firmware::write(", faults ");
  firmware::write_decimal(cycles / fault_every);
  firmware::write(", wrong ");
  firmware::write_decimal(run.wrong);
  firmware::write("\n");
  return run.wrong == 0 ? 0 : 1;
}
