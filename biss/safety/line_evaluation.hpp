// The second of the two evaluations of a frame: directly from the line, if possible by other
// methods than the first.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

#include "biss/base/bits.hpp"
#include "biss/safety/plan.hpp"
#include "biss/safety/verdict.hpp"

namespace biss::safety_detail {

// ---- Bits from the line; no code is shared with BitView

class LineReader {
 public:
  constexpr explicit LineReader(const BitView& bits)
      : bytes_(bits.stored()),
        origin_(bits.first_bit_of_stored()),
        end_(origin_ + bits.size_bits()),
        at_(origin_) {}

  constexpr std::size_t left() const { return end_ - at_; }

  // Late zeros, ones, and the zeros of ACK up to START.
  struct Runs {
    std::size_t late = 0;
    std::size_t ones = 0;
    std::size_t zeros = 0;
  };

  // Moves to START, or to the end if there is none.
  [[gnu::always_inline]] constexpr Runs find_start() {
    Runs runs;
    // The ones usually end within the first 32 bits.
    const std::uint32_t front = left() < 32U ? 0 : look(at_);
    const auto ones = static_cast<unsigned>(std::countl_one(front));
    if (ones == 0 || ones == 32) {
      runs.late = run(false);
      runs.ones = run(true);
    } else {
      runs.ones = ones;
      at_ += ones;
    }
    runs.zeros = run(false);
    return runs;
  }

  // The next `Bits` bits in words of 32, the first one at the top; undefined after the end.
  // \pre left() is at least Known
  template <unsigned Bits, unsigned Known, std::size_t... I>
  [[gnu::always_inline]] constexpr auto peek(std::index_sequence<I...>) const {
    const std::size_t first = at_ / 8U;
    const auto skip = static_cast<unsigned>(at_ % 8U);
    // The first bit may be the last one of its byte.
    constexpr std::size_t size = (Bits + 7U + 31U) / 32U;
    std::array<std::uint32_t, sizeof...(I) + 1U> words{
        (I < size ? four_at<(32U * I + 25U <= Known)>(first + 4U * I) : 0U)...};
    if constexpr (size > sizeof...(I)) words[size - 1U] = four_at<false>(first + 4U * (size - 1U));
    return std::array<std::uint32_t, sizeof...(I)>{
        ((words[I] << skip) | (words[I + 1U] >> 1U >> (31U - skip)))...};
  }

 private:
  // Skips the bits of that level, up to the end, and returns their number.
  [[gnu::always_inline]] constexpr std::size_t run(bool level) {
    const std::uint32_t all = level ? ~0U : 0U;
    const std::size_t from = at_;
    if (at_ >= end_) return 0;
    std::uint32_t other = look(at_) ^ all;
    if (other == 0) {
      // From here on, whole bytes are compared; their first bits are known to have the level.
      std::size_t byte = at_ / 8U + 4U;
      while (byte + 4U <= bytes_.size() && (other = four(byte) ^ all) == 0) byte += 4U;
      if (other == 0) other = rest_from(byte) ^ all;
      at_ = byte * 8U;
    }
    at_ = std::min(at_ + static_cast<unsigned>(std::countl_zero(other)), end_);
    return at_ - from;
  }

  // Zeros after the end; not checked if four bytes are known to exist.
  template <bool Inside>
  [[gnu::always_inline]] constexpr std::uint32_t four_at(std::size_t first) const {
    if (Inside || first + 4U <= bytes_.size()) return four(first);
    return rest_from(first);
  }
  constexpr std::uint32_t four(std::size_t first) const {
    const std::uint8_t* byte = bytes_.data() + first;
    return (std::uint32_t{byte[0]} << 24U) | (std::uint32_t{byte[1]} << 16U) |
           (std::uint32_t{byte[2]} << 8U) | byte[3];
  }

  [[gnu::always_inline]] constexpr std::uint32_t look(std::size_t at) const {
    const std::size_t first = at / 8U;
    const auto skip = static_cast<unsigned>(at % 8U);
    if (first + 5U > bytes_.size()) return rest_from(first) << skip;
    return (four(first) << skip) | (std::uint32_t{bytes_[first + 4U]} >> (8U - skip));
  }

  // Four bytes at most, then zeros.
  [[gnu::noinline]] constexpr std::uint32_t rest_from(std::size_t first) const {
    std::uint32_t word = 0;
    for (unsigned room = 32; first < bytes_.size(); ++first) {
      room -= 8U;
      word |= std::uint32_t{bytes_[first]} << room;
    }
    return word;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t origin_;
  std::size_t end_;
  std::size_t at_;
};

// ---- A few hundred bits from the line in words of 32

// With offsets that are known at compile time, word and shift are constants: everything is inlined.
template <unsigned Bits, unsigned Known>
class LineWords {
 public:
  // \pre the line has Known bits more; bits that it does not have are not read
  [[gnu::always_inline]] constexpr explicit LineWords(const LineReader& from)
      : words_(from.peek<Bits, Known>(std::make_index_sequence<size>())) {}

  // `count` bits from `offset` on, at the top of a word, zeros below. \pre count is 1…32
  [[gnu::always_inline]] constexpr std::uint32_t top(unsigned offset, unsigned count) const {
    const unsigned skip = offset % 32U;
    std::uint32_t word = words_[offset / 32U] << skip;
    if (skip + count > 32U) word |= words_[offset / 32U + 1U] >> (32U - skip);
    return word & (~0U << (32U - count));
  }

  // `count` bits from `offset` on as a number; 0 for none. \pre count is 0…64
  [[gnu::always_inline]] constexpr std::uint64_t value(unsigned offset, unsigned count) const {
    if (count == 0) return 0;
    if (count <= 32) return top(offset, count) >> (32U - count);
    return (std::uint64_t{top(offset, 32)} << (count - 32U)) |
           (top(offset + 32U, count - 32U) >> (64U - count));
  }

  [[gnu::always_inline]] constexpr bool operator[](unsigned offset) const {
    return ((words_[offset / 32U] >> (31U - offset % 32U)) & 1U) != 0;
  }

 private:
  static constexpr std::size_t size = (Bits + 31U) / 32U;
  std::array<std::uint32_t, size> words_;
};

}  // namespace biss::safety_detail

namespace biss {

/// Reads fields by their places from START on, checks CRCs bit by bit as a long division, compares
/// with both positions moved to the top of a word, and steps its own copy of the counter.
template <class Plan>
class LineEvaluation {
 public:
  constexpr explicit LineEvaluation(const SafetySetup& chosen)
      : range_(chosen.counter.mode == CounterMode::count_1_63   ? Range::from_1
               : chosen.counter.mode == CounterMode::count_0_63 ? Range::from_0
                                                                : Range::unknown) {}

  /// \param bits SLO once a MA clock, as for find_start()
  // Not inlined: in one function the two evaluations compete for registers.
  [[gnu::noinline]] static constexpr SafetyFinding find(const Plan& plan, const BitView& bits) {
    safety_detail::LineReader line(bits);
    if (!is_at_start(line, plan.setup().bounds)) return {.cause = SafetyVerdict::no_frame};
    const FrameFormat& format = plan.format();
    const unsigned stop = payload_at + plan.payload_bits();
    // Without START nothing is left.
    if (line.left() < stop) return {.cause = SafetyVerdict::no_frame};
    const Words words(line);
    if (words[1] && format.cds0) return {.cause = SafetyVerdict::no_frame};
    const SafetyVerdict sums =
        check_sums(plan, words, std::make_index_sequence<Plan::most_channels>());
    if (sums != SafetyVerdict::safe) return {.cause = sums};
    if (line.left() != stop && words[stop]) return {.cause = SafetyVerdict::no_frame};
    return found(plan, words);
  }

  /// The position of a finding whose cause is safe, with all numbers at the top of a word, so that
  /// they wrap around by themselves.
  static constexpr SafePosition safe_position(const Plan& plan, const SafetyFinding& finding) {
    const Compared compared(plan.format(), plan.setup());
    const unsigned key_at = 64U - compared.bits;
    const unsigned cpw_at = key_at - compared.cpw_fine_bits;
    const unsigned spw_at = key_at - compared.spw_fine_bits;
    const std::uint64_t value = finding.spw_position << spw_at;
    const std::uint64_t step = std::uint64_t{1} << key_at;
    const std::uint64_t low = (value & (0U - step)) - step * plan.setup().comparison.tolerance_lsb;
    const std::uint64_t high = low + step * (2U * plan.setup().comparison.tolerance_lsb + 1U) - 1U;
    const std::uint64_t aligned = value & (~std::uint64_t{0} << cpw_at);
    const std::uint64_t cpw = finding.cpw_position << cpw_at;
    return {.value = value >> spw_at,
            .low = low >> spw_at,
            .high = high >> spw_at,
            .cpw_only_offset = static_cast<std::int64_t>(cpw - aligned) >> cpw_at,
            .cpw_only_turns = (finding.cpw_position ^ (cpw >> cpw_at)) >> (64U - cpw_at)};
  }

  /// Whether the counter may have this value.
  constexpr bool counter_follows(std::uint8_t value) const {
    if (begun_ == 0) return value != 0 || range_ != Range::from_1;
    auto next = static_cast<std::uint8_t>(~complement_);
    for (unsigned more = perhaps_; value != next; --more) {
      if (next == 0 && range_ == Range::unknown) return value == 1;
      if (more == 0) return false;
      next = after(next);
    }
    return true;
  }
  constexpr void accept_counter(std::uint8_t value, const SafetySetup& setup) {
    if (rolls_over_ != 0 && range_ == Range::unknown) {
      to_0_ = static_cast<std::uint8_t>(value == 0 ? to_0_ + 1U : 0U);
      to_1_ = static_cast<std::uint8_t>(value == 1 ? to_1_ + 1U : 0U);
      if (to_0_ >= setup.counter.learn_rollovers) range_ = Range::from_0;
      if (to_1_ >= setup.counter.learn_rollovers) range_ = Range::from_1;
    }
    rolls_over_ = value == 63 ? 1 : 0;
    begun_ = 1;
    perhaps_ = 0;
    expect(after(value));
  }
  /// A frame was not accepted; the sequence continues.
  constexpr void miss_counter(MissedFrames rule) {
    rolls_over_ = 0;
    if (rule == MissedFrames::perhaps) {
      ++perhaps_;
    } else {
      expect(after(static_cast<std::uint8_t>(~complement_)));
    }
  }
  /// The next value starts a new sequence. The known range stays.
  constexpr void lose_place() {
    begun_ = 0;
    rolls_over_ = 0;
    to_0_ = 0;
    to_1_ = 0;
  }
  /// The counter's range, from the setup or learned; none while it is being learned.
  constexpr std::optional<CounterMode> counter_mode() const {
    if (range_ == Range::unknown) return std::nullopt;
    return range_ == Range::from_1 ? CounterMode::count_1_63 : CounterMode::count_0_63;
  }

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

  // The compared bits: the upper bits of both singleturn values, and the turns that both have.
  // FieldEvaluation has its own calculation.
  struct Compared {
    unsigned singleturn_bits;
    unsigned turns;
    unsigned bits;
    unsigned cpw_fine_bits;
    unsigned spw_fine_bits;

    [[gnu::always_inline]] constexpr Compared(const FrameFormat& whole, const SafetySetup& chosen) {
      const ChannelFormat& cpw = whole.channel_list[chosen.cpw];
      const ChannelFormat& spw = whole.channel_list[chosen.spw];
      // Either `position` or `singleturn` has no bits.
      const unsigned of_cpw = unsigned{cpw.position.bits} + cpw.singleturn.bits;
      const unsigned of_spw = unsigned{spw.position.bits} + spw.singleturn.bits;
      singleturn_bits = chosen.comparison.compare_bits;
      if (singleturn_bits == 0) singleturn_bits = of_cpw < of_spw ? of_cpw : of_spw;
      turns = 0;
      if (chosen.comparison.multiturn == MultiturnRule::with_carry) {
        turns = cpw.multiturn.bits < spw.multiturn.bits ? cpw.multiturn.bits : spw.multiturn.bits;
      }
      bits = turns + singleturn_bits;
      cpw_fine_bits = of_cpw - singleturn_bits;
      spw_fine_bits = of_spw - singleturn_bits;
    }
  };

  // The place of the channel's first bit.
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
  // The same for a count that may be known only at run time.
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
    // Kept in a register: Arm then takes two instructions a bit; with a constant it takes three.
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

    [[gnu::always_inline]] constexpr Word(const FrameFormat& whole, std::size_t number,
                                          const Words& from)
        : channel(whole.channel_list[number]),
          words(from),
          end(begin_of(whole, number) + channel.data_bits) {}

    [[gnu::always_inline]] constexpr std::uint64_t value(const Field& field) const {
      return words.value(end - field.shift - field.bits, field.bits);
    }
    [[gnu::always_inline]] constexpr bool level(const FlagField& flag) const {
      return !flag.present || words[end - 1U - flag.shift] != flag.active_high;
    }
    [[gnu::always_inline]] constexpr const Field& singleturn() const {
      return channel.position.present() ? channel.position : channel.singleturn;
    }
    [[gnu::always_inline]] constexpr std::uint64_t position() const {
      return value(channel.multiturn) << singleturn().bits | value(singleturn());
    }
    // The lower bits of the turns and the upper ones of the singleturn value, at the top of a word.
    [[gnu::always_inline]] constexpr std::uint64_t key(const Compared& compared) const {
      const unsigned front = end - singleturn().shift - singleturn().bits;
      std::uint64_t key = words.value(front, compared.singleturn_bits);
      if (compared.turns != 0) {
        key |= words.value(end - channel.multiturn.shift - compared.turns, compared.turns)
               << compared.singleturn_bits;
      }
      return key << (64U - compared.bits);
    }
  };

  [[gnu::always_inline]] static constexpr SafetyFinding found(const Plan& plan,
                                                              const Words& words) {
    const SafetySetup& setup = plan.setup();
    const Word cpw(plan.format(), setup.cpw, words);
    const Word spw(plan.format(), setup.spw, words);
    const Compared compared(plan.format(), setup);
    const unsigned unused = 64U - compared.bits;
    const auto apart = static_cast<std::int64_t>(cpw.key(compared) - spw.key(compared));
    const std::int64_t limit = std::int64_t{setup.comparison.tolerance_lsb} << unused;
    SafetyVerdict cause = SafetyVerdict::safe;
    if (apart > limit || apart < -limit) cause = SafetyVerdict::comparison;
    if (!spw.level(spw.channel.error)) cause = SafetyVerdict::spw_error;
    if (!cpw.level(cpw.channel.error)) cause = SafetyVerdict::cpw_error;
    unsigned warnings = cpw.level(cpw.channel.warning) ? 1 : 0;
    warnings = 2U * warnings + (spw.level(spw.channel.warning) ? 1U : 0U);
    std::int64_t difference = apart >> unused;
    if (compared.bits > 32) {
      constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
      difference = std::max(std::min(difference, most), -most);
    }
    return {.cpw_position = cpw.position(),
            .spw_position = spw.position(),
            .difference_lsb = static_cast<std::int32_t>(difference),
            .life_counter = static_cast<std::uint8_t>(spw.value(spw.channel.life_counter)),
            .nW = static_cast<std::uint8_t>(warnings),
            .cause = cause};
  }

  enum class Range : std::uint8_t { from_0, from_1, unknown };

  // While the range is being learned, 0; counter_follows() then accepts 1, too.
  constexpr std::uint8_t after(std::uint8_t value) const {
    if (value != 63) return static_cast<std::uint8_t>(value + 1U);
    return range_ == Range::from_1 ? 1 : 0;
  }
  constexpr void expect(std::uint8_t next) { complement_ = static_cast<std::uint8_t>(~next); }

  /// The complement of the next value.
  std::uint8_t complement_ = 0;
  /// How many further values are accepted as well.
  std::uint8_t perhaps_ = 0;
  Range range_;
  // The flags are not bool: after a fault of the memory they still have a value.
  std::uint8_t begun_ = 0;
  /// The last frame was good and had 63.
  std::uint8_t rolls_over_ = 0;
  /// Roll-overs in a row to 0 and to 1.
  std::uint8_t to_0_ = 0;
  std::uint8_t to_1_ = 0;
};

}  // namespace biss
