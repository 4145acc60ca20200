// A safety encoder with injected faults and its monitor, for the tests of biss/safety.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/base/bit_buffer.hpp"
#include "biss/base/wrapping_time.hpp"
#include "biss/frame/encode.hpp"
#include "biss/safety/configurations.hpp"
#include "biss/safety/monitor.hpp"
#include "tests/core/frames.hpp"

namespace biss::test {

using RunPlan = SafetyPlan<2>;

/// The content of the two words.
struct SafetyWords {
  std::uint64_t cpw = 0;
  std::uint64_t spw = 0;
  std::uint32_t life_counter = 1;
  bool cpw_nE = true;
  bool cpw_nW = true;
  bool spw_nE = true;
  bool spw_nW = true;
};

/// Renishaw's encoders have 32 to 160 clocks of ACK at 10 MHz.
inline constexpr std::uint16_t ack_clocks = 32;

/// One frame of two channels after 2 leading ones and `ack` zeros. \pre the values fit
template <class Plan>
constexpr FrameBits bits_of(const Plan& plan, const SafetyWords& words,
                            std::uint16_t ack = ack_clocks) {
  BasicFrame<2> frame;
  frame.channel_count = 2;
  frame.lead_clocks = 2;
  frame.ack_clocks = ack;
  frame.channel_list[plan.setup().cpw] = {words.cpw, 0, words.cpw_nE, words.cpw_nW};
  frame.channel_list[plan.setup().spw] = {words.spw, words.life_counter, words.spw_nE,
                                          words.spw_nW};
  return *encode_frame(frame, plan.codec());
}

/// The two findings of one frame, which must be equal.
template <class Plan>
struct Findings {
  SafetyFinding first;
  SafetyFinding second;

  constexpr Findings(const Plan& plan, const BitView& bits)
      : first(FieldEvaluation<Plan>::find(plan, bits)),
        second(LineEvaluation<Plan>::find(plan, bits)) {}
  constexpr bool agree() const { return first == second; }
  constexpr bool are(SafetyVerdict cause) const { return agree() && first.cause == cause; }
};

inline RunPlan plan_of(std::string_view name, const auto& change) {
  const SafetyConfiguration& configuration = *find_safety_configuration(name);
  SafetySetup setup = configuration.setup;
  change(setup);
  return {configuration.frame_format(), UnratedSafetySetup(setup)};
}
inline RunPlan plan_of(std::string_view name) {
  return plan_of(name, [](SafetySetup&) {});
}

/// A monitor that has passed its self test, and its encoder: 36 + 28 bits, a frame every cycle.
class SafetyBench {
 public:
  static constexpr Picoseconds cycle = nanoseconds(31'250);

  SafetyBench() : SafetyBench([](SafetySetup&) {}) {}
  explicit SafetyBench(const auto& change, bool tested = true)
      : plan_(plan_of("fs-36-28", change)),
        monitor(plan_),
        passed(tested && monitor.self_test(plan_.fingerprint())) {}

  const RunPlan& plan() const { return plan_; }

  /// The next frame of an encoder without faults, one cycle later.
  SafetyJudgement good() { return send(next()); }
  /// Good frames.
  SafetyJudgement good(unsigned frames) {
    SafetyJudgement judged;
    while (frames-- != 0) judged = good();
    return judged;
  }
  /// Good frames until the monitor is safe. \return how many
  unsigned until_safe(unsigned most = 300) {
    unsigned frames = 0;
    while (monitor.state() != SafetyState::safe && frames++ < most) good();
    return frames;
  }
  /// The next words of the encoder. They count as sent.
  SafetyWords next() {
    counter = counter == 63 ? lowest : counter + 1U;
    position += 1000;
    return words();
  }
  SafetyWords words() const {
    return {.cpw = position & low_mask(36),
            .spw = (position & low_mask(36)) >> 8U,
            .life_counter = counter};
  }
  /// Sends these words, one cycle later.
  SafetyJudgement send(const SafetyWords& sent) {
    wait();
    const FrameBits bits = bits_of(plan_, sent);
    return monitor.step(OneClock{now}, bits.view());
  }
  /// The next words, changed.
  SafetyJudgement send_changed(const auto& change) {
    SafetyWords sent = next();
    change(sent);
    return send(sent);
  }
  /// A frame with changed bits.
  SafetyJudgement send_flipped(std::size_t payload_bit) {
    FrameBits bits = bits_of(plan_, next());
    bits.flip(2U + ack_clocks + 2U + payload_bit);
    wait();
    return monitor.step(OneClock{now}, bits.view());
  }
  /// The fault that is latched.
  bool acknowledge() { return monitor.acknowledge(monitor.latched_cause()); }
  SafetyJudgement watch(Picoseconds at) { return monitor.watch(OneClock{at}); }
  /// No answer to a request.
  SafetyJudgement silence() {
    wait();
    return monitor.step(OneClock{now}, BitView());
  }

 private:
  // The clock may wrap around.
  void wait() { now = wrapping_later(now, cycle); }

  RunPlan plan_;

 public:
  SafetyMonitor<RunPlan> monitor;
  bool passed;
  Picoseconds now{};
  std::uint64_t position = 0x123456789U;
  std::uint32_t counter = 10;
  std::uint32_t lowest = 1;
};

}  // namespace biss::test
