// The expected verdicts of a safety monitor, computed plainly: bits one by one, counters by
// increments, time as a number that never wraps around. It shares only data types with biss/safety.
#pragma once

#include "biss/frame/format.hpp"
#include "biss/safety/setup.hpp"
#include "biss/safety/verdict.hpp"
#include "fuzz/target.hpp"

namespace biss::fuzz {

using Wide = __int128;

/// One decoded frame.
struct OracleFrame {
  SafetyVerdict cause = SafetyVerdict::no_frame;
  std::uint64_t position = 0;
  std::uint64_t spw_position = 0;
  /// The position of a frame whose cause is safe.
  SafePosition safe{};
  std::int64_t apart = 0;
  unsigned life_counter = 0;
  bool cpw_nW = true;
  bool spw_nW = true;
};

class SafetyOracle {
 public:
  SafetyOracle(const FrameFormat& format, const SafetySetup& setup)
      : format_(format), setup_(setup) {
    encoder_restarted();
  }

  OracleFrame read(const std::vector<bool>& bits) const;
  /// \param ahead by how much the second clock is ahead of the first one
  SafetyJudgement step(Wide now, Wide ahead, const OracleFrame& frame, bool disagree);
  SafetyJudgement watch(Wide now, Wide ahead);
  void expect(std::uint64_t low, std::uint64_t high) { window_ = {low, high}; }
  void acknowledge() {
    if (state_ == SafetyState::latched) start();
  }
  void encoder_restarted() {
    range_ = setup_.counter.mode;
    seen_ = false;
    roll_overs_.clear();
    first_request_ = true;
    not_first_ = false;
    outside_ = false;
    if (state_ == SafetyState::starting || state_ == SafetyState::safe) start();
  }
  std::optional<Wide> deadline() const {
    if (good_ == 0) return std::nullopt;
    return last_good_ + setup_.frame_gap_max.count;
  }
  SafetyState state() const { return state_; }
  std::optional<CounterMode> range() const {
    if (range_ == CounterMode::learned) return std::nullopt;
    return range_;
  }

 private:
  using Bits = std::vector<bool>;

  static bool crc_is_right(const CrcSpec& crc, const Bits& data, const Bits& sent);
  // Frames from the last counter to this one, 64 for never. \param zero 0 is a number like others
  unsigned frames_to(unsigned value, bool zero) const;
  bool zero_counts(unsigned value) const {
    return range_ == CounterMode::learned ? value != 1 : range_ == CounterMode::count_0_63;
  }
  bool may_come(unsigned value, bool zero) const;
  SafetyVerdict counter_verdict(unsigned value) const;
  void take(unsigned value);
  bool clocks_differ(Wide ahead) const {
    const Wide apart = ahead - last_ahead_;
    return good_ != 0 &&
           (apart > setup_.clocks.tolerance.count || -apart > setup_.clocks.tolerance.count);
  }
  bool is_late(Wide gap) const { return gap < 0 || gap > setup_.frame_gap_max.count; }
  bool tolerates(Wide now, SafetyVerdict verdict);
  bool refuse(Wide now, SafetyVerdict verdict);
  void start() {
    state_ = SafetyState::starting;
    forget();
  }
  void forget() {
    good_ = 0;
    missed_ = 0;
    place_.reset();
    roll_overs_.clear();
  }

  FrameFormat format_;
  SafetySetup setup_;
  SafetyState state_ = SafetyState::starting;
  CounterMode range_{};
  bool seen_ = false;  // the range, in the counter itself
  std::optional<unsigned> place_;
  std::vector<unsigned> roll_overs_;  // the counters after 63, while learning
  unsigned missed_ = 0;
  unsigned good_ = 0;
  Wide last_good_ = 0;
  Wide last_ahead_ = 0;
  std::optional<Wide> last_request_;
  unsigned still_ = 0;
  bool first_request_ = true;  // since the encoder's power-up
  bool not_first_ = false;
  bool outside_ = false;  // of an expectation, since then
  std::optional<std::array<std::uint64_t, 2>> window_;
  std::vector<Wide> tolerated_;
};

inline bool SafetyOracle::crc_is_right(const CrcSpec& crc, const Bits& data, const Bits& sent) {
  std::uint32_t rest = crc.start;
  for (const bool bit : data) {
    const bool out = ((rest >> (crc.width_bits - 1U)) & 1U) != 0;
    rest = rest << 1U & (low_mask(crc.width_bits));
    if (out != bit) rest ^= crc.polynomial & low_mask(crc.width_bits);
  }
  for (unsigned i = 0; i < crc.width_bits; ++i) {
    const bool bit = ((rest >> (crc.width_bits - 1U - i)) & 1U) != 0;
    if (sent[i] == (bit != crc.inverted)) continue;
    return false;
  }
  return true;
}

inline OracleFrame SafetyOracle::read(const Bits& bits) const {
  const FrameBounds& bounds = setup_.bounds;
  std::size_t at = 0;
  const auto run = [&](bool level) {
    std::size_t count = 0;
    while (at < bits.size() && bits[at] == level) ++at, ++count;
    return count;
  };
  const std::size_t late = run(false);
  const std::size_t lead = late + run(true);
  const std::size_t ack = run(false);
  OracleFrame frame;
  if (at + 2U + format_.payload_bits() > bits.size()) return frame;
  if (late > bounds.late_max_clocks || lead < bounds.lead_min_clocks ||
      lead > bounds.lead_max_clocks || ack < bounds.ack_min_clocks || ack > bounds.ack_max_clocks) {
    return frame;
  }
  if (bits[at + 1U] && format_.cds0) return frame;
  at += 2;
  const auto take = [&](std::size_t count) {
    const auto begin = bits.begin() + static_cast<std::ptrdiff_t>(at);
    at += count;
    return Bits(begin, begin + static_cast<std::ptrdiff_t>(count));
  };
  std::vector<Bits> words;
  for (std::size_t k = 0; k < format_.channel_count; ++k) {
    const ChannelFormat& channel = format_.channel_list[k];
    words.push_back(take(channel.data_bits));
    if (channel.crc.present() &&
        !crc_is_right(channel.crc, words[k], take(channel.crc.width_bits))) {
      frame.cause = k == setup_.cpw   ? SafetyVerdict::cpw_crc
                    : k == setup_.spw ? SafetyVerdict::spw_crc
                                      : SafetyVerdict::no_frame;
      return frame;
    }
  }
  if (at < bits.size() && bits[at]) return frame;

  // A field lies `shift` bits before the CRC.
  const auto value = [&](std::size_t k, const Field& field) {
    std::uint64_t number = 0;
    const std::size_t end = words[k].size() - field.shift;
    for (std::size_t i = end - field.bits; i < end; ++i)
      number = number * 2U + (words[k][i] ? 1 : 0);
    return number;
  };
  const auto flag = [&](std::size_t k, const FlagField& field) {
    return !field.present || words[k][words[k].size() - 1U - field.shift] != field.active_high;
  };
  struct Place {
    std::uint64_t turns, single;
    unsigned turn_bits, single_bits;
  };
  const auto place = [&](std::size_t k) -> Place {
    const ChannelFormat& word = format_.channel_list[k];
    if (word.position.present()) return {0, value(k, word.position), 0, word.position.bits};
    return {value(k, word.multiturn), value(k, word.singleturn), word.multiturn.bits,
            word.singleturn.bits};
  };
  const ChannelFormat& cpw = format_.channel_list[setup_.cpw];
  const ChannelFormat& spw = format_.channel_list[setup_.spw];
  const Place a = place(setup_.cpw);
  const Place b = place(setup_.spw);
  unsigned bits_compared = setup_.comparison.compare_bits;
  if (bits_compared == 0)
    bits_compared = a.single_bits < b.single_bits ? a.single_bits : b.single_bits;
  unsigned turn_bits = a.turn_bits < b.turn_bits ? a.turn_bits : b.turn_bits;
  if (setup_.comparison.multiturn == MultiturnRule::ignored) turn_bits = 0;
  const auto compared = [&](const Place& p) {
    const Wide turns = p.turns % (Wide{1} << turn_bits);
    return (turns << bits_compared) + (Wide{p.single} >> (p.single_bits - bits_compared));
  };
  const Wide round = Wide{1} << (turn_bits + bits_compared);
  Wide apart = compared(a) - compared(b);
  while (apart >= round / 2) apart -= round;
  while (apart < -round / 2) apart += round;

  const Wide tolerance = setup_.comparison.tolerance_lsb;
  const bool near = apart <= tolerance && apart >= -tolerance;
  frame.cause = !flag(setup_.cpw, cpw.error)   ? SafetyVerdict::cpw_error
                : !flag(setup_.spw, spw.error) ? SafetyVerdict::spw_error
                : !near                        ? SafetyVerdict::comparison
                                               : SafetyVerdict::safe;
  frame.position = (a.turns << a.single_bits) | a.single;
  frame.spw_position = (b.turns << b.single_bits) | b.single;
  {
    // Plain numbers: both positions in 128 bits, modulo the range that is compared.
    const Wide turn = Wide{1} << turn_bits;
    const unsigned fine = b.single_bits - bits_compared;
    const Wide step = Wide{1} << fine;
    const Wide range = turn << b.single_bits;
    const Wide spw_value = ((b.turns % turn) << b.single_bits) + b.single;
    const auto wrapped = [](Wide number, Wide modulus) {
      return static_cast<std::uint64_t>(((number % modulus) + modulus) % modulus);
    };
    const Wide from = spw_value / step * step - step * setup_.comparison.tolerance_lsb;
    const Wide to = spw_value / step * step + step * (setup_.comparison.tolerance_lsb + 1) - 1;
    const Wide cpw_range = turn << a.single_bits;
    const Wide cpw_value = ((a.turns % turn) << a.single_bits) + a.single;
    const Wide aligned = a.single_bits >= b.single_bits
                             ? spw_value << (a.single_bits - b.single_bits)
                             : spw_value >> (b.single_bits - a.single_bits);
    Wide offset = cpw_value - aligned;
    while (offset >= cpw_range / 2) offset -= cpw_range;
    while (offset < -cpw_range / 2) offset += cpw_range;
    frame.safe = {.value = static_cast<std::uint64_t>(spw_value),
                  .low = wrapped(from, range),
                  .high = wrapped(to, range),
                  .cpw_only_offset = static_cast<std::int64_t>(offset),
                  .cpw_only_turns = a.turns / static_cast<std::uint64_t>(turn)};
  }
  constexpr Wide most = INT32_MAX;
  if (turn_bits + bits_compared > 32) apart = apart > most ? most : apart < -most ? -most : apart;
  frame.apart = static_cast<std::int64_t>(apart);
  frame.life_counter = static_cast<unsigned>(value(setup_.spw, spw.life_counter));
  frame.cpw_nW = flag(setup_.cpw, cpw.warning);
  frame.spw_nW = flag(setup_.spw, spw.warning);
  return frame;
}

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
