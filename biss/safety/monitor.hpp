// The monitor of a BiSS Safety encoder: one step a frame, time and bits passed in.
//
//   constexpr auto& type = safety_configuration("fs-36-28");
//   SafetyMonitor<FixedSafetyPlan<type.frame_format(), type.setup>> monitor;
//   if (!monitor.self_test()) stop();                       // at power-up
//   …
//   const SafetyJudgement told = monitor.step(now, bits);   // every request, answered or not
//   if (told.position) use(*told.position); else stop();
//   …
//   if (monitor.watch(now).verdict != SafetyVerdict::safe) stop();  // at deadline(), or in a tick
//
//   untested --self_test()--> starting --start_frames good ones--> safe --fault--> latched
//                                ^  ^                               |                 |
//                                |  '---------- fault, no latch ----'                 |
//                                '------------------ acknowledge() -------------------'
//
// In `starting` a fault is told and the good frames are counted anew; only `disagreement` latches.
// In `safe` a fault within the budget is told and withholds that frame's position alone.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "biss/base/bits.hpp"
#include "biss/base/units.hpp"
#include "biss/safety/field_evaluation.hpp"
#include "biss/safety/judgement.hpp"
#include "biss/safety/line_evaluation.hpp"
#include "biss/safety/plan.hpp"
#include "biss/safety/self_test.hpp"
#include "biss/safety/verdict.hpp"

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
  /// What latched; meaningful in that state only.
  constexpr SafetyVerdict latched_cause() const { return cause_; }
  /// The counter's range: as set up, or learned; none while it is being learned.
  constexpr std::optional<CounterMode> counter_mode() const { return first_.counter_mode(); }

  /// Shows every check a frame that it must refuse, and good ones; then begins with `starting`.
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

  /// One request's answer.
  /// \param now any clock that does not go backwards, at the same moment of every cycle; it may
  ///   wrap around at the limits of its type. Before the last good frame is the watchdog's.
  /// \param bits SLO once a MA clock, as for find_start(); empty where there was no answer
  constexpr SafetyJudgement step(Picoseconds now, const BitView& bits) {
    return step(now, First::find(plan_, bits), Second::find(plan_, bits));
  }
  /// The same, where decode_frame() or an SpiReader has read these bits already.
  constexpr SafetyJudgement step(Picoseconds now, const BitView& bits,
                                 const Result<typename Plan::Frame, FrameFault>& frame) {
    return step(now, First::find(plan_, frame), Second::find(plan_, bits));
  }
  /// The same, where the evaluations were made apart, on two processors for example.
  constexpr SafetyJudgement step(Picoseconds now, const SafetyFinding& first,
                                 const SafetyFinding& second) {
    if (state_ == SafetyState::untested) return told(SafetyVerdict::self_test);
    if (state_ == SafetyState::latched) return told(SafetyVerdict::latched);
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

  /// Time alone: `watchdog` once the last good frame is too long ago, or where the clock is before
  /// it; else where the monitor is. To be called at deadline(), or as often as one likes. There is
  /// never a position.
  constexpr SafetyJudgement watch(Picoseconds now) {
    if (state_ == SafetyState::untested) return told(SafetyVerdict::self_test);
    if (state_ == SafetyState::latched) return told(SafetyVerdict::latched);
    if (is_late(now)) {
      refuse(now, SafetyVerdict::watchdog);
      return told(SafetyVerdict::watchdog);
    }
    return told(state_ == SafetyState::safe ? SafetyVerdict::safe : SafetyVerdict::starting);
  }

  /// The last moment at which the watchdog is content; none while no frame is awaited.
  constexpr std::optional<Picoseconds> deadline() const {
    if (good_frames_ == 0) return std::nullopt;
    return safety_detail::later(last_good_, plan_.setup().frame_gap_max);
  }

  /// Leaves `latched` for `starting`; in any other state nothing happens. What was learned of the
  /// counter's range stays.
  constexpr void acknowledge() {
    if (state_ == SafetyState::latched) start();
  }

  /// After the encoder was switched off or exchanged: as after self_test(), nothing is remembered,
  /// a latched fault neither. A monitor whose self test has not been passed stays `untested`.
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

  // A clock that went backwards proves nothing either.
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

  // True: the fault is tolerated.
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

  // Room for one more fault in the window that ends now; it is then taken.
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
  // Before the clock has come round to them again.
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

  constexpr SafetyJudgement told(SafetyVerdict verdict) const {
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
