// The monitor of a BiSS Safety encoder: one step per frame; time and bits are arguments.
//
//   constexpr auto type = safety_configuration("fs-36-28");
//   SafetyMonitor<FixedSafetyPlan<type.frame_format(), type.setup>> monitor;
//   if (!monitor.self_test()) stop();  // at power-up
//   // Every request, answered or not:
//   const SafetyJudgement judgement = monitor.step(now, bits);
//   judgement.position ? use(*judgement.position) : stop();
//   // At deadline(), or in a tick:
//   if (monitor.watch(now).verdict != SafetyVerdict::safe) stop();
//
//   untested --self_test()--> starting --start_frames good frames--> safe --fault--> latched
//                                ^  ^                                 |                 |
//                                |  '----------- fault, no latch -----'                 |
//                                '------------------- acknowledge() --------------------'
//
// In `starting`, a fault is reported and the count of good frames starts again; only `disagreement`
// latches. In `safe`, a fault within the budget is reported and only that frame has no position.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <utility>

#include "biss/base/bits.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/encode.hpp"
#include "biss/safety/field_evaluation.hpp"
#include "biss/safety/line_evaluation.hpp"
#include "biss/safety/plan.hpp"
#include "biss/safety/setup.hpp"
#include "biss/safety/verdict.hpp"

namespace biss::safety_detail {

// ---- The power-up test: every check gets input that it must refuse

// The frames are encoded with the plan's own CRC engines: the second evaluation detects an error of
// these.
template <class Monitor, class First, class Second>
class SelfTest {
 public:
  // \param starting a monitor that has seen no frame; it is copied
  constexpr explicit SelfTest(const Monitor& starting)
      : starting_(starting), setup_(starting.plan().setup()), format_(starting.plan().format()) {}

  constexpr bool passes() {
    return reads_good_frame() && refuses_flips() && refuses_lines() && refuses_errors() &&
           compares() && judges_frames();
  }

 private:
  static constexpr std::uint64_t pattern = 0x5A5A'A5A5'3C3C'C3C3U;
  static constexpr std::uint8_t counter = 20;

  constexpr const ChannelFormat& cpw() const { return format_.channel_list[setup_.cpw]; }
  constexpr const ChannelFormat& spw() const { return format_.channel_list[setup_.spw]; }

  // Encodes into bits_, which are empty where the codec refuses.
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
    const auto encoded = encode_frame(frame, starting_.plan().codec());
    bits_ = encoded.ok() ? *encoded : FrameBits();
  }

  constexpr bool finds(SafetyVerdict cause, const BitView& bits) const {
    const SafetyFinding first = First::find(starting_.plan(), bits);
    return first.cause == cause && first == Second::find(starting_.plan(), bits);
  }
  constexpr bool finds(SafetyVerdict cause) const { return finds(cause, bits_.view()); }

  constexpr bool reads_good_frame() {
    const std::uint64_t position = pattern & low_mask(cpw().position_bits());
    encode(position, spw_position(cpw(), spw(), position));
    good_ = First::find(starting_.plan(), bits_.view());
    return finds(SafetyVerdict::safe) && good_.life_counter == counter &&
           good_.position == position;
  }

  // Every single bit that a CRC covers, and of the CRC.
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

  // No answer, no START, cut short, STOP = 1, CDS = 1 where it must be 0.
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
    const unsigned shift = starting_.plan().alignment().spw_shift;
    const std::uint64_t near = setup_.comparison.tolerance_lsb;
    for (const std::uint64_t sign : {std::uint64_t{1}, ~std::uint64_t{0}}) {
      encode(0, (near * sign) << shift);
      if (!finds(SafetyVerdict::safe)) return false;
      encode(0, ((near + 1U) * sign) << shift);
      if (!finds(SafetyVerdict::comparison)) return false;
    }
    return true;
  }

  // Brings a monitor to `safe`, with `counter` as its last value, at the time 0.
  constexpr bool reach_safe(Monitor& monitor) const {
    const unsigned rounds = setup_.counter.learn_rollovers + 2U + setup_.start_frames / 63U;
    const unsigned frames = (64U - lowest()) * rounds;
    for (unsigned left = frames; left != 0; --left) {
      const unsigned back = left % (64U - lowest());
      const unsigned value =
          counter >= back + lowest() ? counter - back : counter + 64U - lowest() - back;
      step(monitor, value, setup_.frame_gap_max * -std::int64_t{left});
    }
    return step(monitor, counter, {}).verdict == SafetyVerdict::safe;
  }
  constexpr SafetyJudgement step(Monitor& monitor, unsigned value, Picoseconds now) const {
    SafetyFinding finding = good_;
    finding.life_counter = static_cast<std::uint8_t>(value);
    return monitor.step(now, finding, finding);
  }
  constexpr std::uint8_t lowest() const {
    return setup_.counter.mode == CounterMode::count_0_63 ? 0 : 1;
  }

  // Checks every value of the counter, late and early frames, the time without a frame, the latch,
  // and evaluations that differ.
  constexpr bool judges_frames() const {
    Monitor monitor = starting_;
    if (!reach_safe(monitor)) return false;
    for (unsigned value = 0; value < 64; ++value) {
      const SafetyVerdict verdict = next_of(monitor, value, setup_.frame_gap_max);
      if (verdict == SafetyVerdict::disagreement) return false;
      if (is_fault(verdict) == (value == counter + 1U)) return false;
    }
    const Picoseconds late = setup_.frame_gap_max + picoseconds(1);
    const Picoseconds soon = setup_.frame_gap_min - picoseconds(1);
    // Without a shortest gap, this is before the last good frame.
    const auto early = soon < Picoseconds{} ? SafetyVerdict::watchdog : SafetyVerdict::early;
    if (next_of(monitor, counter + 1U, soon) != early) return false;
    if (Monitor(monitor).watch(late).verdict != SafetyVerdict::watchdog) return false;
    SafetyFinding other = good_;
    other.position ^= 1U;
    if (Monitor(monitor).step({}, good_, other).verdict != SafetyVerdict::disagreement) {
      return false;
    }
    if (step(monitor, counter + 1U, late).verdict != SafetyVerdict::watchdog) return false;
    return !setup_.latch || step(monitor, counter + 2U, late).verdict == SafetyVerdict::latched;
  }
  constexpr SafetyVerdict next_of(Monitor monitor, unsigned value, Picoseconds now) const {
    return step(monitor, value, now).verdict;
  }

  using Frame = typename std::remove_cvref_t<decltype(std::declval<Monitor>().plan())>::Frame;

  const Monitor& starting_;
  const SafetySetup& setup_;
  const FrameFormat& format_;
  FrameBits bits_;
  std::size_t payload_at_ = 0;
  SafetyFinding good_;
};

}  // namespace biss::safety_detail

namespace biss {

/// `Plan` is a SafetyPlan or FixedSafetyPlan; it is kept by value. `First` and `Second` are the two
/// evaluations.
template <class Plan, class First = FieldEvaluation<Plan>, class Second = LineEvaluation<Plan>>
class SafetyMonitor {
 public:
  constexpr explicit SafetyMonitor(const Plan& plan = Plan())
      : plan_(plan), first_(plan.setup()), second_(plan.setup()) {}

  constexpr const Plan& plan() const { return plan_; }
  constexpr SafetyState state() const { return state_; }
  /// The cause of the latch. \pre state() is latched
  constexpr SafetyVerdict latched_cause() const { return cause_; }
  /// The counter's range, from the setup or learned; none while it is being learned.
  constexpr std::optional<CounterMode> counter_mode() const { return first_.counter_mode(); }

  /// Gives every check a frame that it must refuse, and good frames; then the state is `starting`.
  /// Takes as long as some hundred frames. False: a check does not work; the state stays
  /// `untested`, and every verdict is `self_test`.
  [[nodiscard]] constexpr bool self_test() {
    state_ = SafetyState::untested;
    SafetyMonitor trial(plan_);
    trial.start();
    if (!safety_detail::SelfTest<SafetyMonitor, First, Second>(trial).passes()) return false;
    forget();
    return true;
  }

  /// Judges the answer to one request.
  /// \param now time of any clock that does not go backwards, taken at the same moment of every
  ///   cycle; it may wrap around at the limits of its type. A time before the last good frame gives
  ///   `watchdog`.
  /// \param bits SLO once per MA clock, as for find_start(); empty where there was no answer
  constexpr SafetyJudgement step(Picoseconds now, const BitView& bits) {
    return step(now, First::find(plan_, bits), Second::find(plan_, bits));
  }
  /// The same, where decode_frame() or an SpiReader has already decoded these bits.
  constexpr SafetyJudgement step(Picoseconds now, const BitView& bits,
                                 const Result<typename Plan::Frame, FrameFault>& frame) {
    return step(now, First::find(plan_, frame), Second::find(plan_, bits));
  }
  /// The same, where the evaluations were made separately, on two processors for example.
  constexpr SafetyJudgement step(Picoseconds now, const SafetyFinding& first,
                                 const SafetyFinding& second) {
    if (state_ == SafetyState::untested) return judgement_of(SafetyVerdict::self_test);
    if (state_ == SafetyState::latched) return judgement_of(SafetyVerdict::latched);
    SafetyVerdict verdict = judge(now, first, second);
    bool tolerated = false;
    if (verdict == SafetyVerdict::safe) {
      accept(now, first.life_counter);
      if (state_ != SafetyState::safe) verdict = SafetyVerdict::starting;
    } else {
      tolerated = refuse(now, verdict);
    }
    return {
        .verdict = verdict,
        .state = state_,
        .tolerated = tolerated,
        .cpw_nW = first.cpw_nW,
        .spw_nW = first.spw_nW,
        .life_counter = first.life_counter,
        .difference_lsb = first.difference_lsb,
        .position = verdict == SafetyVerdict::safe ? std::optional(first.position) : std::nullopt};
  }

  /// Checks the time only: `watchdog` once the last good frame is too long ago, or where the clock
  /// is before it; otherwise the monitor's state. To be called at deadline(), or as often as the
  /// caller likes. It never returns a position.
  constexpr SafetyJudgement watch(Picoseconds now) {
    if (state_ == SafetyState::untested) return judgement_of(SafetyVerdict::self_test);
    if (state_ == SafetyState::latched) return judgement_of(SafetyVerdict::latched);
    if (is_late(now)) {
      refuse(now, SafetyVerdict::watchdog);
      return judgement_of(SafetyVerdict::watchdog);
    }
    return judgement_of(state_ == SafetyState::safe ? SafetyVerdict::safe
                                                    : SafetyVerdict::starting);
  }

  /// The last moment at which the watchdog is satisfied; none while no frame is expected.
  constexpr std::optional<Picoseconds> deadline() const {
    if (good_frames_ == 0) return std::nullopt;
    return safety_detail::later(last_good_, plan_.setup().frame_gap_max);
  }

  /// Changes from `latched` to `starting`; in any other state nothing happens. What was learned of
  /// the counter's range stays.
  constexpr void acknowledge() {
    if (state_ == SafetyState::latched) start();
  }

  /// To be called after the encoder was switched off or exchanged. The monitor is as after
  /// self_test(): it keeps nothing, not even a latched fault. A monitor whose self test has not
  /// passed stays `untested`.
  constexpr void restart() {
    if (state_ != SafetyState::untested) forget();
  }

 private:
  constexpr SafetyVerdict judge(Picoseconds now, const SafetyFinding& first,
                                const SafetyFinding& second) const {
    if (!(first == second)) return SafetyVerdict::disagreement;
    if (is_late(now)) return SafetyVerdict::watchdog;
    if (is_early(now)) return SafetyVerdict::early;
    if (first.cause != SafetyVerdict::safe) return first.cause;
    const SafetySetup& setup = plan_.setup();
    const SafetyVerdict counter = first_.judge_counter(first.life_counter, missed_, setup);
    const bool follows = second_.counter_follows(second.life_counter, first_.counter_mode());
    if ((counter == SafetyVerdict::safe) != follows) return SafetyVerdict::disagreement;
    return counter;
  }

  // A clock that went backwards proves nothing, either.
  constexpr bool is_late(Picoseconds now) const {
    if (good_frames_ == 0) return false;
    const Picoseconds gap = safety_detail::elapsed(last_good_, now);
    return gap < Picoseconds{} || gap > plan_.setup().frame_gap_max;
  }
  constexpr bool is_early(Picoseconds now) const {
    return good_frames_ != 0 &&
           safety_detail::elapsed(last_good_, now) < plan_.setup().frame_gap_min;
  }

  constexpr void accept(Picoseconds now, std::uint8_t life_counter) {
    const SafetySetup& setup = plan_.setup();
    first_.accept_counter(life_counter, missed_, setup);
    second_.accept_counter(life_counter, first_.counter_mode());
    if (setup.budget.faults != 0) drop_old_faults(now);
    last_good_ = now;
    missed_ = 0;
    if (good_frames_ < setup.start_frames) ++good_frames_;
    if (good_frames_ == setup.start_frames && first_.counter_mode()) state_ = SafetyState::safe;
  }

  // Returns true where the fault is tolerated.
  constexpr bool refuse(Picoseconds now, SafetyVerdict cause) {
    if (state_ == SafetyState::safe && is_tolerable(cause) && is_within_budget(now)) {
      ++missed_;
      second_.miss_counter(plan_.setup().counter.missed, first_.counter_mode());
      return true;
    }
    const bool holds = state_ == SafetyState::safe || cause == SafetyVerdict::disagreement;
    start();
    if (holds && plan_.setup().latch) {
      state_ = SafetyState::latched;
      cause_ = cause;
    }
    return false;
  }

  // Whether the window that ends now has room for one more fault, which is then counted.
  constexpr bool is_within_budget(Picoseconds now) {
    const SafetyBudget& budget = plan_.setup().budget;
    if (budget.faults == 0) return false;
    if (tolerated_ == budget.faults && is_in_window(oldest_, now)) return false;
    fault_times_[oldest_] = now;
    newest_ = oldest_;
    oldest_ = static_cast<std::uint8_t>(oldest_ + 1U == budget.faults ? 0 : oldest_ + 1U);
    if (tolerated_ < budget.faults) ++tolerated_;
    return true;
  }
  // Before the wrapped clock reaches their times again.
  constexpr void drop_old_faults(Picoseconds now) {
    if (!is_in_window(newest_, now)) tolerated_ = 0;
  }
  constexpr bool is_in_window(std::uint8_t fault, Picoseconds now) const {
    return safety_detail::elapsed(fault_times_[fault], now) <= plan_.setup().budget.window;
  }

  constexpr void forget() {
    first_ = First(plan_.setup());
    tolerated_ = 0;
    start();
  }

  constexpr void start() {
    state_ = SafetyState::starting;
    good_frames_ = 0;
    first_.lose_place();
    second_.lose_place();
  }

  constexpr SafetyJudgement judgement_of(SafetyVerdict verdict) const {
    return {.verdict = verdict, .state = state_};
  }

  [[no_unique_address]] Plan plan_;
  Picoseconds last_good_{};
  std::array<Picoseconds, max_tolerated_faults> fault_times_{};
  First first_;
  Second second_;
  SafetyState state_ = SafetyState::untested;
  SafetyVerdict cause_ = SafetyVerdict::self_test;
  std::uint8_t good_frames_ = 0;
  std::uint8_t missed_ = 0;
  std::uint8_t tolerated_ = 0;
  std::uint8_t oldest_ = 0;
  std::uint8_t newest_ = 0;
};

}  // namespace biss
