// The states and the sign of life of the oracle for the safety monitor.
#pragma once

#include <algorithm>

#include "fuzz/safety_oracle.hpp"

namespace biss::fuzz {

inline unsigned SafetyOracle::frames_to(unsigned value, bool zero) const {
  unsigned at = *place_;
  for (unsigned frames = 0; frames < 64; ++frames) {
    if (at == value) return frames;
    at = at == 63 ? (zero ? 0 : 1) : at + 1U;
  }
  return 64;
}

inline bool SafetyOracle::may_come(unsigned value, bool zero) const {
  const unsigned frames = frames_to(value, zero);
  if (setup_.counter.missed == MissedFrames::counted) return frames == missed_ + 1U;
  return frames >= 1 && frames <= missed_ + 1U;
}

inline SafetyVerdict SafetyOracle::counter_verdict(unsigned value) const {
  if (!place_) {
    const bool never = range_ == CounterMode::count_1_63 && value == 0;
    return never ? SafetyVerdict::counter_mode : SafetyVerdict::safe;
  }
  const bool zero = zero_counts(value);
  if (may_come(value, zero)) return SafetyVerdict::safe;
  if (value == *place_) return SafetyVerdict::counter_repeated;
  if (range() && !seen_ && may_come(value, !zero)) return SafetyVerdict::counter_mode;
  const unsigned ahead = frames_to(value, zero);
  if (ahead == 64) return SafetyVerdict::counter_foreign;
  if (ahead <= missed_) return SafetyVerdict::counter_backwards;
  if (ahead <= missed_ + 1U + setup_.counter.near_frames) return SafetyVerdict::counter_skipped;
  const unsigned behind = (zero ? 64U : 63U) - ahead;
  return behind <= setup_.counter.near_frames ? SafetyVerdict::counter_backwards
                                              : SafetyVerdict::counter_foreign;
}

inline void SafetyOracle::take(unsigned value) {
  if (place_ == 63U && missed_ == 0) {
    if (range_ == CounterMode::learned) {
      if (!roll_overs_.empty() && roll_overs_.back() != value) roll_overs_.clear();
      roll_overs_.push_back(value);
      if (roll_overs_.size() >= setup_.counter.learn_rollovers) {
        range_ = value == 0 ? CounterMode::count_0_63 : CounterMode::count_1_63;
      }
    }
    seen_ = range().has_value();
  }
  place_ = value;
  missed_ = 0;
}

inline bool SafetyOracle::tolerates(Wide now, SafetyVerdict verdict) {
  using enum SafetyVerdict;
  const bool never = verdict == disagreement || verdict == clock || verdict == watchdog ||
                     verdict == cpw_error || verdict == spw_error || verdict == comparison ||
                     verdict == counter_mode || verdict == counter_first || verdict == stimulus;
  if (state_ != SafetyState::safe || never) return false;
  const auto in_window = std::count_if(tolerated_.begin(), tolerated_.end(), [&](Wide then) {
    return now - then <= setup_.budget.window.count;
  });
  return in_window < setup_.budget.faults;
}

// True: tolerated.
inline bool SafetyOracle::refuse(Wide now, SafetyVerdict verdict) {
  if (tolerates(now, verdict)) {
    tolerated_.push_back(now);
    ++missed_;
    return true;
  }
  const bool was_safe = state_ == SafetyState::safe;
  start();
  if (was_safe && setup_.latch) state_ = SafetyState::latched;
  if (verdict == SafetyVerdict::disagreement) state_ = SafetyState::failed;
  return false;
}

inline SafetyJudgement SafetyOracle::step(Wide now, Wide ahead, const OracleFrame& frame,
                                          bool disagree) {
  if (state_ == SafetyState::latched) {
    not_first_ = not_first_ || first_request_;
    first_request_ = false;
    return {.verdict = SafetyVerdict::latched, .state = state_};
  }
  if (state_ == SafetyState::failed) return {.verdict = SafetyVerdict::failed, .state = state_};
  still_ = last_request_ == now ? still_ + 1 : 0;
  last_request_ = now;
  SafetyJudgement judged{.cpw_nW = frame.cpw_nW,
                         .spw_nW = frame.spw_nW,
                         .life_counter = static_cast<std::uint8_t>(frame.life_counter),
                         .difference_lsb = static_cast<std::int32_t>(frame.apart)};
  const Wide gap = now - last_good_;
  const Wide other_gap = gap + ahead - last_ahead_;
  const Wide least = setup_.frame_gap_min.count;
  const bool first_wrong =
      setup_.counter.first != any_first_value &&
      (not_first_ || (first_request_ && frame.life_counter != setup_.counter.first));
  judged.verdict = disagree ? SafetyVerdict::disagreement
                   : still_ > setup_.clocks.still_requests || clocks_differ(ahead)
                       ? SafetyVerdict::clock
                   : good_ != 0 && (is_late(gap) || is_late(other_gap)) ? SafetyVerdict::watchdog
                   : good_ != 0 && (gap < least || other_gap < least)   ? SafetyVerdict::early
                   : frame.cause != SafetyVerdict::safe                 ? frame.cause
                                                        : counter_verdict(frame.life_counter);
  if (judged.verdict == SafetyVerdict::safe && first_wrong) {
    judged.verdict = SafetyVerdict::counter_first;
  } else if (judged.verdict == SafetyVerdict::safe && window_ && !outside_) {
    const auto [low, high] = *window_;
    const std::uint64_t at = frame.safe.value;
    outside_ = !(low <= high ? at >= low && at <= high : at >= low || at <= high);
    window_.reset();
  }
  if (judged.verdict == SafetyVerdict::safe && outside_) judged.verdict = SafetyVerdict::stimulus;
  // A first answer that is only outside has the first value.
  if (first_request_ && judged.verdict != SafetyVerdict::safe &&
      judged.verdict != SafetyVerdict::stimulus) {
    not_first_ = true;
  }
  first_request_ = false;
  if (judged.verdict != SafetyVerdict::safe) {
    judged.tolerated = refuse(now, judged.verdict);
  } else {
    take(frame.life_counter);
    last_good_ = now;
    last_ahead_ = ahead;
    ++good_;
    if (good_ >= setup_.start_frames && range()) state_ = SafetyState::safe;
    if (state_ == SafetyState::safe) {
      judged.position = frame.safe;
    } else {
      judged.verdict = SafetyVerdict::starting;
    }
  }
  judged.state = state_;
  return judged;
}

inline SafetyJudgement SafetyOracle::watch(Wide now, Wide ahead) {
  if (state_ == SafetyState::latched) return {.verdict = SafetyVerdict::latched, .state = state_};
  if (state_ == SafetyState::failed) return {.verdict = SafetyVerdict::failed, .state = state_};
  const Wide gap = now - last_good_;
  const bool late = good_ != 0 && (is_late(gap) || is_late(gap + ahead - last_ahead_));
  if (clocks_differ(ahead) || late) {
    const SafetyVerdict verdict =
        clocks_differ(ahead) ? SafetyVerdict::clock : SafetyVerdict::watchdog;
    refuse(now, verdict);
    return {.verdict = verdict, .state = state_};
  }
  const bool safe = state_ == SafetyState::safe;
  return {.verdict = safe ? SafetyVerdict::safe : SafetyVerdict::starting, .state = state_};
}

}  // namespace biss::fuzz
