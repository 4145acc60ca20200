// The second of a frame's two evaluations: straight off the line, by other means than the first
// wherever there are any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <utility>

#include "biss/base/bits.hpp"
#include "biss/safety/judgement.hpp"
#include "biss/safety/line_reader.hpp"
#include "biss/safety/line_words.hpp"
#include "biss/safety/plan.hpp"

namespace biss {

/// Fields by their places from START on, CRCs bit by bit as a long division, the comparison with
/// both positions moved to the top of a word, the counter stepped on from a copy of its own.
template <class Plan>
class LineEvaluation {
 public:
  constexpr explicit LineEvaluation(const SafetySetup&) {}

  /// \param bits SLO once a MA clock, as for find_start()
  // Kept apart: inlined into one function the evaluations take each other's registers.
  [[gnu::noinline]] static constexpr SafetyFinding find(const Plan& plan, const BitView& bits) {
    safety_detail::LineReader line(bits);
    if (!is_at_start(line, plan.setup().bounds)) return {.cause = SafetyVerdict::no_frame};
    const FrameFormat& format = plan.format();
    const unsigned stop = payload_at + plan.payload_bits();
    // Nothing is left where there is no START.
    if (line.left() < stop) return {.cause = SafetyVerdict::no_frame};
    const Words words(line);
    if (words.bit(1) && format.cds0) return {.cause = SafetyVerdict::no_frame};
    const SafetyVerdict sums =
        check_sums(plan, words, std::make_index_sequence<Plan::most_channels>());
    if (sums != SafetyVerdict::safe) return {.cause = sums};
    if (line.left() != stop && words.bit(stop)) return {.cause = SafetyVerdict::no_frame};
    return found(plan, words);
  }

  /// Whether the counter may have this value. \param mode none while it is being learned
  constexpr bool counter_follows(std::uint8_t value, std::optional<CounterMode> mode) const {
    if (!begun_) return value != 0 || mode != CounterMode::count_1_63;
    auto next = static_cast<std::uint8_t>(~complement_);
    for (unsigned more = perhaps_; value != next; --more) {
      if (next == 0 && !mode) return value == 1;
      if (more == 0) return false;
      next = after(next, mode);
    }
    return true;
  }
  constexpr void accept_counter(std::uint8_t value, std::optional<CounterMode> mode) {
    begun_ = true;
    perhaps_ = 0;
    expect(after(value, mode));
  }
  /// A frame was not accepted, and the place is kept.
  constexpr void miss_counter(MissedFrames rule, std::optional<CounterMode> mode) {
    if (rule == MissedFrames::perhaps) {
      ++perhaps_;
    } else {
      expect(after(static_cast<std::uint8_t>(~complement_), mode));
    }
  }
  constexpr void lose_place() { begun_ = false; }

 private:
  // START, CDS, the channels, STOP.
  static constexpr unsigned payload_at = 2;
  using Words = safety_detail::LineWords<payload_at + Plan::most_payload_bits + 1U,
                                         payload_at + Plan::least_payload_bits>;

  [[gnu::always_inline]] static constexpr bool is_at_start(safety_detail::LineReader& line,
                                                           const FrameBounds& bounds) {
    const auto runs = line.find_start();
    const std::size_t lead = runs.late + runs.ones;
    return runs.late <= bounds.late_max_clocks && lead >= bounds.lead_min_clocks &&
           lead <= bounds.lead_max_clocks && runs.zeros >= bounds.ack_min_clocks &&
           runs.zeros <= bounds.ack_max_clocks;
  }

  // Where the channel's first bit is.
  [[gnu::always_inline]] static constexpr unsigned begin_of(const FrameFormat& format,
                                                            std::size_t channel) {
    unsigned at = payload_at;
    for (std::size_t k = 0; k < channel; ++k) at += format.channel_list[k].total_bits();
    return at;
  }

  // The cause of the first CRC that is wrong, or safe.
  template <std::size_t... K>
  [[gnu::always_inline]] static constexpr SafetyVerdict check_sums(const Plan& plan,
                                                                   const Words& words,
                                                                   std::index_sequence<K...>) {
    std::size_t first_wrong = Plan::most_channels;
    const bool right = (is_right(plan, words, K, first_wrong) && ...);
    if (right) return SafetyVerdict::safe;
    if (first_wrong == plan.setup().cpw) return SafetyVerdict::cpw_crc;
    return first_wrong == plan.setup().spw ? SafetyVerdict::spw_crc : SafetyVerdict::no_frame;
  }
  [[gnu::always_inline]] static constexpr bool is_right(const Plan& plan, const Words& words,
                                                        std::size_t k, std::size_t& first_wrong) {
    const FrameFormat& format = plan.format();
    if (k >= format.channel_count) return true;
    first_wrong = k;
    return is_divisible(format.channel_list[k], words, begin_of(format, k));
  }

  // The remainder of register and data, which lie at the top of the word, after Count bits.
  template <unsigned Count>
  [[gnu::always_inline]] static constexpr std::uint32_t divided_by(std::uint32_t polynomial,
                                                                   std::uint32_t word) {
    if constexpr (Count == 0) {
      return word;
    } else {
      word = (word << 1U) ^ (polynomial & (0U - (word >> 31U)));
      return divided_by<Count - 1U>(polynomial, word);
    }
  }
  // The same for a count that may be known at run time only.
  [[gnu::always_inline]] static constexpr std::uint32_t divided(std::uint32_t word, unsigned count,
                                                                std::uint32_t polynomial) {
    if (count == 32) return divided_by<32>(polynomial, word);
    for (unsigned eights = count / 8U; eights != 0; --eights) {
      word = divided_by<8>(polynomial, word);
    }
    if ((count & 4U) != 0) word = divided_by<4>(polynomial, word);
    if ((count & 2U) != 0) word = divided_by<2>(polynomial, word);
    if ((count & 1U) != 0) word = divided_by<1>(polynomial, word);
    return word;
  }

  [[gnu::always_inline]] static constexpr bool is_divisible(const ChannelFormat& channel,
                                                            const Words& words, unsigned at) {
    const CrcSpec& crc = channel.crc;
    if (!crc.present()) return true;
    const unsigned upper = channel.data_bits < 32 ? channel.data_bits : 32;
    const unsigned lower = channel.data_bits - upper;
    const unsigned unused = 32U - crc.width_bits;
    std::uint32_t polynomial = crc.polynomial << unused;
    // Kept in a register: Arm then takes two instructions a bit, with a constant three.
    if (!std::is_constant_evaluated()) asm("" : "+r"(polynomial));
    std::uint32_t rest = words.top(at, upper) ^ (std::uint32_t{crc.start} << unused);
    rest = divided(rest, upper, polynomial);
    if (lower != 0) rest = divided(rest ^ words.top(at + upper, lower), lower, polynomial);
    const std::uint32_t sent = words.top(at + channel.data_bits, crc.width_bits);
    return (rest ^ sent) == (crc.inverted ? ~0U << unused : 0U);
  }

  // A word's fields by their places on the line.
  struct Word {
    const ChannelFormat& channel;
    const Words& words;
    unsigned end;

    [[gnu::always_inline]] constexpr Word(const FrameFormat& format, std::size_t k,
                                          const Words& line)
        : channel(format.channel_list[k]),
          words(line),
          end(begin_of(format, k) + channel.data_bits) {}

    [[gnu::always_inline]] constexpr std::uint64_t value(const Field& field) const {
      return words.value(end - field.shift - field.bits, field.bits);
    }
    [[gnu::always_inline]] constexpr bool level(const FlagField& flag) const {
      return !flag.present || words.bit(end - 1U - flag.shift) != flag.active_high;
    }
    [[gnu::always_inline]] constexpr const Field& singleturn() const {
      return channel.position.present() ? channel.position : channel.singleturn;
    }
    [[gnu::always_inline]] constexpr std::uint64_t position() const {
      return value(channel.multiturn) << singleturn().bits | value(singleturn());
    }
    // The lower bits of the turns and the upper ones of the singleturn value, at the top of a word.
    [[gnu::always_inline]] constexpr std::uint64_t key(
        const safety_detail::Alignment& alignment) const {
      const unsigned turns = alignment.bits - alignment.singleturn_bits;
      const unsigned front = end - singleturn().shift - singleturn().bits;
      std::uint64_t key = words.value(front, alignment.singleturn_bits);
      if (turns != 0) {
        key |= words.value(end - channel.multiturn.shift - turns, turns)
               << alignment.singleturn_bits;
      }
      return key << (64U - alignment.bits);
    }
  };

  [[gnu::always_inline]] static constexpr SafetyFinding found(const Plan& plan,
                                                              const Words& words) {
    const SafetySetup& setup = plan.setup();
    const Word cpw(plan.format(), setup.cpw, words);
    const Word spw(plan.format(), setup.spw, words);
    const safety_detail::Alignment& alignment = plan.alignment();
    const unsigned unused = 64U - alignment.bits;
    const auto apart = static_cast<std::int64_t>(cpw.key(alignment) - spw.key(alignment));
    const std::int64_t limit = std::int64_t{setup.comparison.tolerance_lsb} << unused;
    SafetyVerdict cause = SafetyVerdict::safe;
    if (apart > limit || apart < -limit) cause = SafetyVerdict::comparison;
    if (!spw.level(spw.channel.error)) cause = SafetyVerdict::spw_error;
    if (!cpw.level(cpw.channel.error)) cause = SafetyVerdict::cpw_error;
    return {.position = cpw.position(),
            .difference_lsb = safety_detail::held(apart >> unused, alignment.bits),
            .life_counter = static_cast<std::uint8_t>(spw.value(spw.channel.life_counter)),
            .cpw_nW = cpw.level(cpw.channel.warning),
            .spw_nW = spw.level(spw.channel.warning),
            .cause = cause};
  }

  // While the range is being learned 0, for which counter_follows() takes 1 as well.
  static constexpr std::uint8_t after(std::uint8_t value, std::optional<CounterMode> mode) {
    if (value != 63) return static_cast<std::uint8_t>(value + 1U);
    return mode == CounterMode::count_1_63 ? 1 : 0;
  }
  constexpr void expect(std::uint8_t next) { complement_ = static_cast<std::uint8_t>(~next); }

  /// Of the next value.
  std::uint8_t complement_ = 0;
  /// So many more values may come instead.
  std::uint8_t perhaps_ = 0;
  bool begun_ = false;
};

}  // namespace biss
