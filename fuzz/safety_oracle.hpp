// The expected verdicts of a safety monitor, computed plainly: bits one by one, counters by
// increments, time as a number that never wraps around. It shares only data types with biss/safety.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "biss/frame/format.hpp"
#include "biss/safety/setup.hpp"
#include "biss/safety/verdict.hpp"

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

}  // namespace biss::fuzz
