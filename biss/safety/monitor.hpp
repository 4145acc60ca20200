// The monitor of a BiSS Safety encoder: one step per frame; time and bits are arguments.
//
//   constexpr auto type = safety_configuration("fs-36-28");
//   SafetyMonitor<FixedSafetyPlan<type.frame_format(), type.setup>> monitor;
//   if (!monitor.self_test()) stop();  // at power-up
//   // Every request, answered or not:
//   const SafetyJudgement judgement = monitor.step(TwoClocks{now, second}, bits);
//   judgement.position ? use(judgement.position->low, judgement.position->high) : stop();
//   // At deadline(), or in a tick:
//   if (monitor.watch(TwoClocks{now, second}).verdict != SafetyVerdict::safe) stop();
//
// states.hpp has the states and the transitions between them.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <utility>

#include "biss/base/bits.hpp"
#include "biss/base/units.hpp"
#include "biss/base/wrapping_time.hpp"
#include "biss/frame/encode.hpp"
#include "biss/safety/field_evaluation.hpp"
#include "biss/safety/line_evaluation.hpp"
#include "biss/safety/plan.hpp"
#include "biss/safety/setup.hpp"
#include "biss/safety/verdict.hpp"

namespace biss {

/// One SPI transfer as measured by the clock; ignored unless SafetyClocks::bit_period is given.
struct Transfer {
  Picoseconds time{};
  /// Clocks of MA. step() with bits takes their number; a good frame without it is the fault
  /// `clock`.
  std::uint32_t clocks = 0;
};

/// One clock only. If it runs at a wrong rate or jumps by less than the watchdog's time, nothing
/// detects it; use TwoClocks in a safety function.
struct OneClock {
  Picoseconds now{};
  Transfer transfer{};
};

/// Two independent clocks, read at the same moment. They need not show the same time.
struct TwoClocks {
  Picoseconds now{};
  Picoseconds second{};
  Transfer transfer{};

  constexpr TwoClocks(Picoseconds first_clock, Picoseconds second_clock, Transfer measured)
      : now(first_clock), second(second_clock), transfer(measured) {}
  constexpr TwoClocks(Picoseconds first_clock, Picoseconds second_clock)
      : TwoClocks(first_clock, second_clock, {}) {}
  constexpr TwoClocks(const OneClock& clock) : TwoClocks(clock.now, clock.now, clock.transfer) {}
};

}  // namespace biss

namespace biss::safety_detail {

// ---- The power-up test: every check gets input that it must refuse

// The frames are encoded with the plan's own CRC engines: the second evaluation detects an error of
// these.
template <class Monitor, class First, class Second>
class SelfTest {
  using Frame = typename std::remove_cvref_t<decltype(std::declval<Monitor>().plan())>::Frame;
  using Memory = typename Monitor::Memory;

 public:
  // \param trial a monitor that has seen no frame; it is only for this test
  constexpr explicit SelfTest(Monitor& trial)
      : trial_(trial),
        setup_(trial.plan().setup()),
        format_(trial.plan().format()),
        starting_(trial.memory_),
        safe_(trial.memory_) {}

  constexpr bool passes() {
    return reads_good_frame() && refuses_flips() && refuses_lines() && refuses_errors() &&
           compares() && judges();
  }

 private:
  static constexpr std::uint64_t pattern = 0x5A5A'A5A5'3C3C'C3C3U;
  static constexpr std::uint8_t counter = 20;

  constexpr const ChannelFormat& cpw() const { return format_.channel_list[setup_.cpw]; }
  constexpr const ChannelFormat& spw() const { return format_.channel_list[setup_.spw]; }

  // Encodes into bits_, which are empty if the codec refuses the frame.
  constexpr void encode(std::uint64_t cpw_value, std::uint64_t spw_value, bool cpw_nE = true,
                        bool spw_nE = true) {
    Frame frame;
    frame.channel_count = format_.channel_count;
    frame.lead_clocks = std::max(setup_.bounds.lead_min_clocks, std::uint16_t{1});
    frame.ack_clocks = std::max(setup_.bounds.ack_min_clocks, std::uint16_t{1});
    frame.channel_list[setup_.cpw] = {cpw_value & low_mask(cpw().position_bits()), 0, cpw_nE, true};
    frame.channel_list[setup_.spw] = {spw_value & low_mask(spw().position_bits()), counter, spw_nE,
                                      true};
    payload_at_ = frame.lead_clocks + frame.ack_clocks + std::size_t{2};
    const auto encoded = encode_frame(frame, trial_.plan().codec());
    bits_ = encoded.ok() ? *encoded : FrameBits();
  }

  constexpr bool finds(SafetyVerdict cause, const BitView& bits) const {
    const SafetyFinding first = First::find(trial_.plan(), bits);
    return first.cause == cause && first == Second::find(trial_.plan(), bits);
  }
  constexpr bool finds(SafetyVerdict cause) const { return finds(cause, bits_.view()); }

  constexpr bool reads_good_frame() {
    const std::uint64_t position = pattern & low_mask(cpw().position_bits());
    encode(position, spw_position(cpw(), spw(), position));
    good_ = First::find(trial_.plan(), bits_.view());
    return finds(SafetyVerdict::safe) && good_.life_counter == counter &&
           good_.cpw_position == position;
  }

  // Every single bit that a CRC covers, and every bit of the CRC.
  constexpr bool refuses_flips() {
    std::size_t at = payload_at_;
    for (std::uint8_t k = 0; k < format_.channel_count; ++k) {
      const SafetyVerdict cause = k == setup_.cpw   ? SafetyVerdict::cpw_crc
                                  : k == setup_.spw ? SafetyVerdict::spw_crc
                                                    : SafetyVerdict::no_frame;
      const ChannelFormat& channel = format_.channel_list[k];
      const std::size_t end = at + channel.total_bits();
      if (!channel.crc.present()) at = end;
      for (; at < end; ++at) {
        if (!finds_flipped(at, cause)) return false;
      }
    }
    return true;
  }

  constexpr bool finds_flipped(std::size_t at, SafetyVerdict cause) {
    bits_.flip(at);
    const bool found = finds(cause);
    bits_.flip(at);
    return found;
  }

  // No answer, no START, cut short, STOP = 1, CDS = 1 although it must be 0.
  constexpr bool refuses_lines() {
    const BitView line = bits_.view();
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, payload_at_ - 2U,
                                   payload_at_ - 1U, line.size_bits() - 2U}) {
      if (!finds(SafetyVerdict::no_frame, line.first(size))) return false;
    }
    if (!finds_flipped(line.size_bits() - 1U, SafetyVerdict::no_frame)) return false;
    return !format_.cds0 || finds_flipped(payload_at_ - 1U, SafetyVerdict::no_frame);
  }

  constexpr bool refuses_errors() {
    encode(0, 0, false, true);
    if (!finds(SafetyVerdict::cpw_error)) return false;
    encode(0, 0, true, false);
    return finds(SafetyVerdict::spw_error);
  }

  // Across the wrap-around, both ways.
  constexpr bool compares() {
    const unsigned shift = trial_.plan().alignment().spw_shift;
    const std::uint64_t near = setup_.comparison.tolerance_lsb;
    for (const std::uint64_t sign : {std::uint64_t{1}, ~std::uint64_t{0}}) {
      encode(0, (near * sign) << shift);
      if (!finds(SafetyVerdict::safe)) return false;
      encode(0, ((near + 1U) * sign) << shift);
      if (!finds(SafetyVerdict::comparison)) return false;
    }
    return true;
  }

  // Brings the trial to `safe`, with `counter` as its last value, at the time 0.
  constexpr bool reach_safe() {
    const unsigned rounds = setup_.counter.learn_rollovers + 2U + setup_.start_frames / 63U;
    const unsigned frames = (64U - lowest()) * rounds;
    for (unsigned left = frames; left != 0; --left) {
      const unsigned back = left % (64U - lowest());
      const unsigned value =
          counter >= back + lowest() ? counter - back : counter + 64U - lowest() - back;
      step(value, setup_.frame_gap_max * -std::int64_t{left});
    }
    const bool is_safe = step(counter, Picoseconds{}) == SafetyVerdict::safe;
    safe_ = trial_.memory_;
    return is_safe;
  }
  // The trial with this memory.
  constexpr Monitor& put(const Memory& memory) {
    trial_.memory_ = memory;
    trial_.keep();
    return trial_;
  }
  constexpr Monitor& again() { return put(safe_); }

  constexpr SafetyVerdict step(unsigned value, const TwoClocks& now) {
    SafetyFinding finding = good_;
    finding.life_counter = static_cast<std::uint8_t>(value);
    return trial_.step(now, finding, finding).verdict;
  }
  constexpr SafetyVerdict step(unsigned value, Picoseconds now) {
    return step(value, OneClock{now, good_transfer()});
  }
  constexpr Transfer good_transfer() const { return {setup_.clocks.bit_period, 1}; }
  constexpr std::uint8_t lowest() const {
    return setup_.counter.mode == CounterMode::count_0_63 ? 0 : 1;
  }

  constexpr bool judges() {
    return reach_safe() && judges_frames() && judges_clocks() && judges_expectations() &&
           judges_first();
  }

  // Checks every value of the counter, late and early frames, the time without a frame, the latch,
  // and evaluations that differ.
  constexpr bool judges_frames() {
    for (unsigned value = 0; value < 64; ++value) {
      const SafetyVerdict verdict = next_of(value, setup_.frame_gap_max);
      if (verdict == SafetyVerdict::disagreement) return false;
      if (is_fault(verdict) == (value == counter + 1U)) return false;
    }
    const Picoseconds late = setup_.frame_gap_max + picoseconds(1);
    const Picoseconds soon = setup_.frame_gap_min - picoseconds(1);
    // Without a shortest gap, this is before the last good frame.
    const bool still = soon == Picoseconds{} && setup_.clocks.still_requests == 0;
    const auto early = soon < Picoseconds{} ? SafetyVerdict::watchdog
                       : still              ? SafetyVerdict::clock
                                            : SafetyVerdict::early;
    if (next_of(counter + 1U, soon) != early) return false;
    if (again().watch(OneClock{late}).verdict != SafetyVerdict::watchdog) return false;
    SafetyFinding other = good_;
    other.cpw_position ^= 1U;
    if (again().step(OneClock{late}, good_, other).verdict != SafetyVerdict::disagreement) {
      return false;
    }
    if (step(counter + 1U, late) != SafetyVerdict::failed) return false;
    if (next_of(counter + 1U, late) != SafetyVerdict::watchdog) return false;
    return !setup_.latch || step(counter + 2U, late) == SafetyVerdict::latched;
  }
  constexpr SafetyVerdict next_of(unsigned value, Picoseconds now) {
    again();
    return step(value, now);
  }

  // Clocks that differ, in a frame and in a tick; a stopped clock; a transfer's time.
  constexpr bool judges_clocks() {
    const Picoseconds now = setup_.frame_gap_max;
    const Picoseconds apart = setup_.clocks.tolerance + picoseconds(1);
    for (const Picoseconds second : {now - apart, now + apart}) {
      if (clock_verdict({now, second, good_transfer()}) != SafetyVerdict::clock) return false;
      if (again().watch(TwoClocks{now, second}).verdict != SafetyVerdict::clock) return false;
    }
    again().memory_.still_requests = setup_.clocks.still_requests;
    trial_.keep();
    if (step(counter + 1U, Picoseconds{}) != SafetyVerdict::clock) return false;
    if (setup_.clocks.bit_period.count == 0) return true;
    return clock_verdict({now, now, {apart + setup_.clocks.bit_period, 1}}) == SafetyVerdict::clock;
  }
  constexpr SafetyVerdict clock_verdict(const TwoClocks& now) {
    again();
    return step(counter + 1U, now);
  }

  // A position outside the expected bounds, which holds, and one inside.
  constexpr bool judges_expectations() {
    const std::uint64_t value = First::safe_position(trial_.plan(), good_).value;
    const Picoseconds now = setup_.frame_gap_max;
    for (const std::uint64_t beside : {value + 1U, value - 1U}) {
      again().expect_position(beside, beside);
      if (step(counter + 1U, now) != SafetyVerdict::stimulus) return false;
      const auto held = setup_.latch ? SafetyVerdict::latched : SafetyVerdict::stimulus;
      if (step(counter + 2U, 2 * now) != held) return false;
    }
    again().expect_position(value, value);
    return step(counter + 1U, now) == SafetyVerdict::safe;
  }

  // A wrong first value of the counter, which holds.
  constexpr bool judges_first() {
    const unsigned first = setup_.counter.first;
    if (first == any_first_value) return true;
    put(starting_).await_first();
    trial_.keep();
    return step(first == counter ? counter + 1U : counter, Picoseconds{}) ==
               SafetyVerdict::counter_first &&
           step(first, setup_.frame_gap_max) == SafetyVerdict::counter_first;
  }

  Monitor& trial_;
  const SafetySetup& setup_;
  const FrameFormat& format_;
  // The trial before its first frame, and once it is safe.
  const Memory starting_;
  Memory safe_;
  FrameBits bits_;
  std::size_t payload_at_ = 0;
  SafetyFinding good_;
};

}  // namespace biss::safety_detail

namespace biss {

/// `Plan` is a SafetyPlan or FixedSafetyPlan; it is kept by value. `First` and `Second` are the two
/// evaluations. A checksum of the monitor's memory is checked before each use. A monitor cannot be
/// copied, moved or assigned: an older copy would undo `latched`, `failed` and the budget.
template <class Plan, class First = FieldEvaluation<Plan>, class Second = LineEvaluation<Plan>>
class SafetyMonitor {
 public:
  constexpr explicit SafetyMonitor(const Plan& plan = Plan())
      : plan_(plan), memory_(plan.setup()), check_(check_of(memory_)) {}
  SafetyMonitor(const SafetyMonitor&) = delete;
  SafetyMonitor& operator=(const SafetyMonitor&) = delete;

  constexpr const Plan& plan() const { return plan_; }
  constexpr SafetyState state() const { return memory_.state; }
  /// The cause of the fault that holds. \pre state() is latched or failed
  constexpr SafetyVerdict latched_cause() const { return memory_.cause; }
  /// The counter's range, from the setup or learned; none while it is being learned.
  constexpr std::optional<CounterMode> counter_mode() const { return memory_.first.counter_mode(); }

  /// Gives every check a frame that it must refuse, and good frames. Takes as long as a few hundred
  /// frames. At power-up it leads from `untested` to `starting`. In any other state it changes
  /// nothing if it passes, and clears no fault; if it fails, the state is `failed`.
  /// \param expected the fingerprint of the format and the setup, from a constant. The plan in
  ///   memory is compared with it now and before every frame
  /// \return false: a check does not work, or the state was `failed`; every verdict is `self_test` or
  ///   `failed`
  [[nodiscard]] constexpr bool self_test(const SafetyFingerprint& expected) {
    if (!is_intact()) return false;
    memory_.expected = expected;
    const bool passed = plan_.is(expected) && !plan_.mistake() && passes_self_test();
    if (!passed) memory_.cause = SafetyVerdict::self_test;
    change(passed ? SafetyEvent::self_test_passed : SafetyEvent::self_test_failed);
    keep();
    return passed && memory_.state != SafetyState::failed;
  }
  /// The same for a FixedSafetyPlan, which is a constant itself.
  [[nodiscard]] constexpr bool self_test() requires(requires { Plan::fingerprint(); }) {
    return self_test(Plan::fingerprint());
  }

  /// Judges the answer to one request. The monitor cannot detect answers that are all late by a
  /// constant number of requests since power-up, unless SafetyCounter::first or expect_position()
  /// is used.
  /// \param time taken at the same moment of every cycle; it may wrap around at the limits of its
  ///   type. A time before the last good frame gives `watchdog`.
  /// \param bits SLO once per MA clock, as for find_start(); empty without an answer
  constexpr SafetyJudgement step(TwoClocks time, const BitView& bits) {
    if (const auto verdict = obstacle(); verdict != SafetyVerdict::safe) return unjudged(verdict);
    time.transfer.clocks = static_cast<std::uint32_t>(bits.size_bits());
    return judgement_of(time, First::find(plan_, bits), Second::find(plan_, bits));
  }
  /// The same for bits that decode_frame() or an SpiReader has already decoded, within its own
  /// bounds. If it refused the bits before it came to a checksum, the verdict is `no_frame`.
  constexpr SafetyJudgement step(TwoClocks time, const BitView& bits,
                                 const Result<typename Plan::Frame, FrameFault>& frame) {
    if (const auto verdict = obstacle(); verdict != SafetyVerdict::safe) return unjudged(verdict);
    time.transfer.clocks = static_cast<std::uint32_t>(bits.size_bits());
    const SafetyFinding first = First::find(plan_, bits, frame);
    const SafetyFinding second = Second::find(plan_, bits);
    const bool is_refused = !frame.ok() && frame.error().cause != FrameError::crc;
    return is_refused ? judgement_of(time, first, first) : judgement_of(time, first, second);
  }
  /// The same for evaluations that were made separately, for example on two processors.
  constexpr SafetyJudgement step(const TwoClocks& time, const SafetyFinding& first,
                                 const SafetyFinding& second) {
    if (const auto verdict = obstacle(); verdict != SafetyVerdict::safe) return unjudged(verdict);
    return judgement_of(time, first, second);
  }

  /// Checks the time only: `watchdog` once the last good frame is too long ago, or if the clock is
  /// before it; `clock` if the clocks differ; otherwise the monitor's state. Call it at deadline(),
  /// or at any other time. It never returns a position, not even with `safe`.
  constexpr SafetyJudgement watch(const TwoClocks& time) {
    SafetyVerdict verdict = obstacle();
    if (verdict != SafetyVerdict::safe) return judgement_of(verdict);
    verdict = memory_.state == SafetyState::safe ? SafetyVerdict::safe : SafetyVerdict::starting;
    if (clocks_differ(time)) {
      verdict = SafetyVerdict::clock;
    } else if (is_late(time)) {
      verdict = SafetyVerdict::watchdog;
    }
    if (is_fault(verdict)) {
      refuse(time.now, verdict);
      keep();
    }
    return judgement_of(verdict);
  }

  /// The last moment of the first clock at which the watchdog is satisfied; empty while no frame is
  /// expected.
  constexpr std::optional<Picoseconds> deadline() const {
    if (memory_.good_frames == 0) return std::nullopt;
    return wrapping_later(memory_.last_good, plan_.setup().frame_gap_max);
  }

  /// The next good frame must have its position, in counts of the SPW, from `low` to `high`; `low`
  /// may be above `high`, across the wrap-around. Call it when the axis has moved or is moving: the
  /// position of an old frame is then outside. Only a good frame ends the expectation, in
  /// `starting` or `safe`; no fault, tick, self test, acknowledgement or restart does. A further
  /// call replaces it.
  ///
  /// A position outside is the fault `stimulus`, whether `latch` is on or off. It holds as
  /// `counter_first` does: every further good frame is `stimulus` until encoder_restarted(), also
  /// after acknowledge() and with further expectations. The first good frame after the restart must
  /// meet the last one.
  constexpr void expect_position(std::uint64_t low, std::uint64_t high) {
    if (!is_intact()) return;
    memory_.expected_low = low;
    memory_.expected_high = high;
    memory_.expects_position = 1;
    keep();
  }

  /// Clears the fault with this cause: from `latched` to `starting`. The learned range of the
  /// counter is kept.
  /// \return false if another fault, or none, is latched; nothing changes then
  constexpr bool acknowledge(SafetyVerdict cause) {
    if (!is_intact() || memory_.state != SafetyState::latched || memory_.cause != cause) {
      return false;
    }
    change(SafetyEvent::acknowledged);
    keep();
    return true;
  }

  /// Call it after the encoder was switched off or exchanged, before its first request and, if
  /// SafetyCounter::first is used, after acknowledge(). The monitor forgets the counter's value and
  /// learned range, and starts again: it checks the first value again, and ends `counter_first` and
  /// `stimulus`. As after power-up, only SafetyCounter::first or expect_position() then shows a
  /// constant delay. It clears no latched fault, empties no budget of faults and ends no
  /// expectation.
  constexpr void encoder_restarted() {
    if (!is_intact()) return;
    const SafetySetup& setup = plan_.setup();
    memory_.first = First(setup);
    memory_.second = Second(setup);
    change(SafetyEvent::encoder_restarted);
    lose_place();
    await_first();
    keep();
  }

 private:
  template <class, class, class>
  friend class safety_detail::SelfTest;

  // Whether answers belong to their requests: whether the first one since power-up has the counter's
  // first value, and none is outside of its expected bounds.
  enum class Freshness : std::uint8_t { proven, next_frame, failed, stale };

  static constexpr Freshness before_first(const SafetySetup& setup) {
    return setup.counter.first == any_first_value ? Freshness::proven : Freshness::next_frame;
  }

  struct Memory {
    constexpr explicit Memory(const SafetySetup& chosen)
        : first(chosen), second(chosen), freshness(before_first(chosen)) {}

    SafetyFingerprint expected{};
    Picoseconds last_good{};
    Picoseconds last_good_second{};
    Picoseconds last_request{};
    std::uint64_t expected_low = 0;
    std::uint64_t expected_high = 0;
    std::array<Picoseconds, Plan::most_faults> fault_times{};
    First first;
    Second second;
    SafetyState state = SafetyState::untested;
    SafetyVerdict cause = SafetyVerdict::self_test;
    std::uint16_t still_requests = 0;
    std::uint8_t good_frames = 0;
    std::uint8_t missed = 0;
    std::uint8_t tolerated = 0;
    std::uint8_t oldest = 0;
    std::uint8_t newest = 0;
    Freshness freshness;
    // The flags are not bool: after a fault of the memory they still have a value.
    std::uint8_t expects_position = 0;
    std::uint8_t has_requested = 0;
    std::array<std::uint8_t, 6> spare{};
  };
  // Without padding, so that all bytes can be compared.
  static_assert(std::has_unique_object_representations_v<Memory>);
  static constexpr std::size_t memory_words = sizeof(Memory) / 4U;

  // Without a copy of the memory, except while compiling.
  static constexpr std::uint32_t word_of(const Memory& memory, std::size_t k) {
    if (std::is_constant_evaluated()) {
      return std::bit_cast<std::array<std::uint32_t, memory_words>>(memory)[k];
    }
    const auto* at = reinterpret_cast<const unsigned char*>(&memory) + 4U * k;
    std::uint32_t word = 0;
    __builtin_memcpy(&word, __builtin_assume_aligned(at, 4), 4U);
    return word;
  }
  [[gnu::noinline]] static constexpr std::uint32_t check_of(const Memory& memory) {
    return check_of(memory, std::make_index_sequence<memory_words>());
  }
  template <std::size_t... K>
  static constexpr std::uint32_t check_of(const Memory& memory, std::index_sequence<K...>) {
    safety_detail::Check check;
    (check.add(word_of(memory, K)), ...);
    return check.sum();
  }

  // ---- Memory

  // Read from memory, even if the compiler could take the value as known.
  constexpr bool is_intact() {
    if constexpr (!Plan::checks_memory) return true;
    if (!std::is_constant_evaluated()) asm volatile("" : : "r"(this) : "memory");
    if (check_of(memory_) == check_) return true;
    memory_.state = SafetyState::failed;
    memory_.cause = SafetyVerdict::memory;
    keep();
    return false;
  }
  constexpr void keep() {
    if constexpr (Plan::checks_memory) check_ = check_of(memory_);
  }

  // The verdict for every frame, if frames cannot be judged now; otherwise `safe`.
  constexpr SafetyVerdict obstacle() {
    if (!is_intact()) return SafetyVerdict::memory;
    const SafetyState state = memory_.state;
    if (state == SafetyState::untested) return SafetyVerdict::self_test;
    if (state == SafetyState::latched) return SafetyVerdict::latched;
    // Also for a value that is not a state.
    if (state != SafetyState::starting && state != SafetyState::safe) return SafetyVerdict::failed;
    if (plan_.is(memory_.expected)) return SafetyVerdict::safe;
    hold(SafetyEvent::receiver_fault, SafetyVerdict::memory);
    keep();
    return SafetyVerdict::memory;
  }
  constexpr SafetyJudgement judgement_of(SafetyVerdict verdict) const {
    return {.verdict = verdict, .state = memory_.state};
  }
  // An answer that is not judged. If it is the first answer, no later answer counts as the first.
  constexpr SafetyJudgement unjudged(SafetyVerdict verdict) {
    if (memory_.freshness == Freshness::next_frame) {
      memory_.freshness = Freshness::failed;
      keep();
    }
    return judgement_of(verdict);
  }

  // ---- One frame

  constexpr SafetyJudgement judgement_of(const TwoClocks& time, const SafetyFinding& first,
                                         const SafetyFinding& second) {
    const bool still = memory_.has_requested != 0 && time.now == memory_.last_request;
    // It stops above the largest number that a setup can allow.
    const unsigned requests = still ? std::min(memory_.still_requests + 1U, 0x100U) : 0U;
    memory_.still_requests = static_cast<std::uint16_t>(requests);
    memory_.last_request = time.now;
    memory_.has_requested = 1;
    SafetyVerdict verdict = judge(time, first, second);
    const SafePosition position = First::safe_position(plan_, first);
    if (verdict == SafetyVerdict::safe) {
      if (!(position == Second::safe_position(plan_, second))) {
        verdict = SafetyVerdict::disagreement;
      } else if (!is_expected(position.value)) {
        verdict = SafetyVerdict::stimulus;
      }
    }
    if (memory_.freshness == Freshness::next_frame) {
      memory_.freshness = verdict == SafetyVerdict::safe ? Freshness::proven : Freshness::failed;
    }
    SafetyJudgement judgement{.cpw_nW = first.cpw_nW(),
                              .spw_nW = first.spw_nW(),
                              .life_counter = first.life_counter,
                              .difference_lsb = first.difference_lsb};
    if (verdict != SafetyVerdict::safe) {
      judgement.tolerated = refuse(time.now, verdict);
    } else {
      accept(time, first.life_counter, second.life_counter);
      if (memory_.state == SafetyState::safe) {
        judgement.position = position;
      } else {
        verdict = SafetyVerdict::starting;
      }
    }
    judgement.verdict = verdict;
    judgement.state = memory_.state;
    keep();
    return judgement;
  }

  constexpr SafetyVerdict judge(const TwoClocks& time, const SafetyFinding& first,
                                const SafetyFinding& second) const {
    if (!(first == second)) return SafetyVerdict::disagreement;
    if (is_clock_wrong(time)) return SafetyVerdict::clock;
    if (is_late(time)) return SafetyVerdict::watchdog;
    if (is_early(time)) return SafetyVerdict::early;
    if (first.cause != SafetyVerdict::safe) return first.cause;
    if (is_transfer_missing(time)) return SafetyVerdict::clock;
    return judge_counter(first.life_counter, second.life_counter);
  }
  constexpr SafetyVerdict judge_counter(std::uint8_t first, std::uint8_t second) const {
    const SafetySetup& setup = plan_.setup();
    if (memory_.first.counter_mode() != memory_.second.counter_mode()) {
      return SafetyVerdict::disagreement;
    }
    const SafetyVerdict counter = memory_.first.judge_counter(first, memory_.missed, setup);
    if ((counter == SafetyVerdict::safe) != memory_.second.counter_follows(second)) {
      return SafetyVerdict::disagreement;
    }
    const bool stale = memory_.freshness == Freshness::failed ||
                       (memory_.freshness == Freshness::next_frame && first != setup.counter.first);
    return counter == SafetyVerdict::safe && stale ? SafetyVerdict::counter_first : counter;
  }
  // Whether the position of an otherwise good frame is expected. The frame ends the expectation.
  constexpr bool is_expected(std::uint64_t value) {
    if (memory_.freshness == Freshness::stale) return false;
    if (memory_.expects_position == 0) return true;
    memory_.expects_position = 0;
    const bool from_low = value >= memory_.expected_low;
    const bool to_high = value <= memory_.expected_high;
    const bool is_within =
        memory_.expected_low <= memory_.expected_high ? from_low && to_high : from_low || to_high;
    if (!is_within) memory_.freshness = Freshness::stale;
    return is_within;
  }

  // ---- Time

  constexpr bool is_clock_wrong(const TwoClocks& time) const {
    const SafetyClocks& clocks = plan_.setup().clocks;
    if (memory_.still_requests > clocks.still_requests || clocks_differ(time)) return true;
    if (clocks.bit_period.count == 0 || time.transfer.clocks == 0) return false;
    const Picoseconds nominal = clocks.bit_period * std::int64_t{time.transfer.clocks};
    return is_apart(time.transfer.time, nominal);
  }
  constexpr bool is_transfer_missing(const TwoClocks& time) const {
    return plan_.setup().clocks.bit_period.count != 0 && time.transfer.clocks == 0;
  }
  constexpr bool clocks_differ(const TwoClocks& time) const {
    return memory_.good_frames != 0 &&
           is_apart(wrapping_elapsed(memory_.last_good, time.now),
                    wrapping_elapsed(memory_.last_good_second, time.second));
  }
  constexpr bool is_apart(Picoseconds a, Picoseconds b) const {
    const Picoseconds tolerance = plan_.setup().clocks.tolerance;
    // The difference of two 64-bit numbers may need 65 bits.
    const Picoseconds apart = wrapping_elapsed(b, a);
    return a < b ? apart >= Picoseconds{} || apart < -tolerance
                 : apart < Picoseconds{} || apart > tolerance;
  }
  // A clock that went backwards proves nothing, either.
  constexpr bool is_late(const TwoClocks& time) const {
    if (memory_.good_frames == 0) return false;
    return is_late(wrapping_elapsed(memory_.last_good, time.now)) ||
           is_late(wrapping_elapsed(memory_.last_good_second, time.second));
  }
  constexpr bool is_late(Picoseconds gap) const {
    return gap < Picoseconds{} || gap > plan_.setup().frame_gap_max;
  }
  constexpr bool is_early(const TwoClocks& time) const {
    if (memory_.good_frames == 0) return false;
    const Picoseconds least = plan_.setup().frame_gap_min;
    return wrapping_elapsed(memory_.last_good, time.now) < least ||
           wrapping_elapsed(memory_.last_good_second, time.second) < least;
  }

  // ---- State changes by a frame

  constexpr void accept(const TwoClocks& time, std::uint8_t first, std::uint8_t second) {
    const SafetySetup& setup = plan_.setup();
    memory_.first.accept_counter(first, memory_.missed, setup);
    memory_.second.accept_counter(second, setup);
    if (setup.budget.faults != 0) drop_old_faults(time.now);
    memory_.last_good = time.now;
    memory_.last_good_second = time.second;
    memory_.missed = 0;
    if (memory_.good_frames < setup.start_frames) ++memory_.good_frames;
    const bool last = memory_.good_frames == setup.start_frames && memory_.first.counter_mode();
    change(last ? SafetyEvent::last_start_frame : SafetyEvent::good_frame);
  }

  // Returns true if the fault is tolerated.
  constexpr bool refuse(Picoseconds now, SafetyVerdict cause) {
    const SafetySetup& setup = plan_.setup();
    if (memory_.state == SafetyState::safe && is_tolerable(cause) && is_within_budget(now)) {
      ++memory_.missed;
      memory_.second.miss_counter(setup.counter.missed);
      change(SafetyEvent::tolerated_fault);
      return true;
    }
    if (place_of(cause) == FaultPlace::receiver) {
      hold(SafetyEvent::receiver_fault, cause);
    } else {
      hold(setup.latch ? SafetyEvent::fault : SafetyEvent::unlatched_fault, cause);
    }
    return false;
  }
  // A fault ends the sequence of good frames; its cause is kept if it holds.
  constexpr void hold(SafetyEvent event, SafetyVerdict cause) {
    change(event);
    lose_place();
    if (memory_.state != SafetyState::starting) memory_.cause = cause;
  }

  // Whether the window that ends now has room for one more fault, which is then counted.
  constexpr bool is_within_budget(Picoseconds now) {
    const SafetyBudget& budget = plan_.setup().budget;
    if (budget.faults == 0) return false;
    if (memory_.tolerated == budget.faults && is_in_window(memory_.oldest, now)) return false;
    memory_.fault_times[memory_.oldest] = now;
    memory_.newest = memory_.oldest;
    memory_.oldest =
        static_cast<std::uint8_t>(memory_.oldest + 1U == budget.faults ? 0 : memory_.oldest + 1U);
    if (memory_.tolerated < budget.faults) ++memory_.tolerated;
    return true;
  }
  // Before the wrapped clock reaches their times again.
  constexpr void drop_old_faults(Picoseconds now) {
    if (!is_in_window(memory_.newest, now)) memory_.tolerated = 0;
  }
  constexpr bool is_in_window(std::uint8_t fault, Picoseconds now) const {
    return wrapping_elapsed(memory_.fault_times[fault], now) <= plan_.setup().budget.window;
  }

  constexpr void change(SafetyEvent event) { memory_.state = next_state(memory_.state, event); }
  constexpr void lose_place() {
    memory_.good_frames = 0;
    memory_.missed = 0;
    memory_.first.lose_place();
    memory_.second.lose_place();
  }
  constexpr void await_first() { memory_.freshness = before_first(plan_.setup()); }

  // Uses a separate monitor with the plan as it is in memory now.
  constexpr bool passes_self_test() const {
    SafetyMonitor trial(plan_);
    trial.memory_.expected = memory_.expected;
    trial.memory_.freshness = Freshness::proven;
    trial.change(SafetyEvent::self_test_passed);
    trial.keep();
    return safety_detail::SelfTest<SafetyMonitor, First, Second>(trial).passes();
  }

  [[no_unique_address]] Plan plan_;
  Memory memory_;
  std::uint32_t check_;
};

}  // namespace biss
