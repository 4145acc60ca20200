#include "lab/pair.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <utility>

#include "lab/weights.hpp"

namespace biss::lab {
namespace {

// For the error patterns of a pair of words: 2^160 at most. It wraps around, so that a difference may
// be formed in any order as long as the result is not negative.
using Wide = boost::multiprecision::uint256_t;

// The bits that are wrong in the control word and in the safety word.
struct MaskPair {
  std::uint64_t control = 0;
  std::uint64_t safety = 0;

  constexpr auto operator<=>(const MaskPair&) const = default;
};

// The wrong bits so far, and the carries that the next bits need.
struct SumState {
  MaskPair masks;
  bool carry_a = false;
  bool carry_b = false;

  auto operator<=>(const SumState&) const = default;
};

// Adds bit `i` of a term to that bit of a number, and marks in `mask` whether it changes. Two's
// complement: the upper bits of a negative term are 1.
void add_bit(bool v, int term, unsigned i, bool& carry, std::uint64_t& mask) {
  const int sum =
      int{v} + static_cast<int>((std::int64_t{term} >> std::min(i, 62U)) & 1) + int{carry};
  carry = sum > 1;
  mask |= std::uint64_t{(sum % 2 != 0) != v} << i;
}

// Adds how v + a and v + b differ from v in their bits, from the last bit on, for evenly distributed
// v.
void add_sums(std::map<MaskPair, long double>& shares, int a, int b, unsigned bits) {
  std::map<SumState, long double> states{{{}, 1}};
  for (unsigned i = 0; i < bits; ++i) {
    std::map<SumState, long double> next;
    for (const auto& [state, share] : states) {
      for (const bool v : {false, true}) {
        SumState after = state;
        add_bit(v, a, i, after.carry_a, after.masks.control);
        add_bit(v, b, i, after.carry_b, after.masks.safety);
        next[after] += share / 2;
      }
    }
    states = std::move(next);
  }
  for (const auto& [state, share] : states) shares[state.masks] += share;
}

// The wrong bits of both words with which the two values pass, and the control word's value is
// within `error` of the true one.
std::map<MaskPair, long double> masks_within(int error, unsigned bits, unsigned tolerance) {
  std::map<MaskPair, long double> pairs;
  const int most = static_cast<int>(tolerance);
  for (int control = -error; control <= error; ++control) {
    for (int difference = -most; difference <= most; ++difference) {
      add_sums(pairs, control, control + difference, bits);
    }
  }
  return pairs;
}

// One of the two words. Compared bits are renumbered: bit 0 is the least significant one, as in the
// masks.
class Word {
 public:
  Word(const ChannelFormat& channel, const std::vector<ComparedBit>& compared, bool is_control)
      : code_(code_of(channel)) {
    for (auto bit = compared.rbegin(); bit != compared.rend(); ++bit) {
      shifts_.push_back(is_control ? bit->control_shift : bit->safety_shift);
      compared_ |= std::uint64_t{1} << shifts_.back();
    }
    if (channel.error.present) right_ |= std::uint64_t{1} << channel.error.shift;
    right_ |= channel.life_counter.placed(~std::uint64_t{0});
    position_ = channel.position.placed(~std::uint64_t{0}) |
                channel.multiturn.placed(~std::uint64_t{0}) |
                channel.singleturn.placed(~std::uint64_t{0});
  }

  const WordCode& code() const { return code_; }
  unsigned free_bits() const {
    return static_cast<unsigned>(std::popcount(free())) + code_.crc_bits;
  }

  // The bits of a dual word: the compared bits as a number, and the number of free bits that are 1.
  struct Dual {
    std::uint64_t compared = 0;
    unsigned free = 0;
  };
  std::vector<Dual> duals() const {
    std::vector<Dual> duals;
    for (const std::uint64_t word : dual_words(code_)) {
      duals.push_back({gathered(word), static_cast<unsigned>(std::popcount(word & free()) +
                                                             std::popcount(duals.size()))});
    }
    return duals;
  }

  // Accepted patterns in which exactly these compared bits are wrong.
  const Polynomial<Wide>& with(std::uint64_t mask) {
    auto& found = with_[mask];
    if (found.empty()) found = weights({right_ | compared_, scattered(mask)});
    return found;
  }

  // Accepted patterns that leave the whole position right.
  Polynomial<Wide> with_right_position() const { return weights({right_ | position_, 0}); }

 private:
  std::uint64_t free() const { return low_mask(code_.data_bits) & ~right_ & ~compared_; }

  Polynomial<Wide> weights(const FixedBits& fixed) const {
    const auto counts = weights_of(code_, fixed);
    return {counts.begin(), counts.end()};
  }

  std::uint64_t gathered(std::uint64_t word) const {
    std::uint64_t mask = 0;
    for (std::size_t i = 0; i < shifts_.size(); ++i) mask |= ((word >> shifts_[i]) & 1U) << i;
    return mask;
  }
  std::uint64_t scattered(std::uint64_t mask) const {
    std::uint64_t word = 0;
    for (std::size_t i = 0; i < shifts_.size(); ++i) word |= ((mask >> i) & 1U) << shifts_[i];
    return word;
  }

  WordCode code_;
  std::vector<std::uint8_t> shifts_;
  std::uint64_t compared_ = 0;
  std::uint64_t right_ = 0;  // bits that must not be wrong
  std::uint64_t position_ = 0;
  std::map<std::uint64_t, Polynomial<Wide>> with_;
};

// Patterns over both words that both checksums accept and whose wrong compared bits differ in
// exactly `mask`: MacWilliams' theorem over the pairs of dual words. A compared bit outside the
// mask is wrong in both words or in neither: a factor 1 + z^2, or 1 - z^2 if it is in one of the
// two dual words. A compared bit in the mask is wrong in one word: 2z, -2z if it is in both dual
// words, 0 if it is in one. Each mask is the effect of a carry, the lowest bits, so each pair of
// dual words is visited once for all masks.
class JointCount {
 public:
  JointCount(const Word& control, const Word& safety, unsigned compared)
      : compared_(compared),
        free_bits_(control.free_bits() + safety.free_bits()),
        checks_(control.code().crc_bits + safety.code().crc_bits),
        numbers_(compared + 1, std::vector<std::int64_t>((compared + 1) * (free_bits_ + 1), 0)) {
    const std::vector<Word::Dual> safety_duals = safety.duals();
    for (const Word::Dual& a : control.duals()) {
      // The sign of a mask is the parity of the control word's bits in it.
      std::vector<std::int64_t> signs{1};
      for (unsigned i = 0; i < compared; ++i) {
        signs.push_back(((a.compared >> i) & 1U) != 0 ? -signs.back() : signs.back());
      }
      for (const Word::Dual& b : safety_duals) {
        const std::uint64_t one = a.compared ^ b.compared;
        const unsigned at =
            static_cast<unsigned>(std::popcount(one)) * (free_bits_ + 1) + a.free + b.free;
        const unsigned most = std::min(compared, static_cast<unsigned>(std::countr_zero(one)));
        for (unsigned lowest = 0; lowest <= most; ++lowest) numbers_[lowest][at] += signs[lowest];
      }
    }
  }

  // \pre mask is 0…01…1, of `compared` bits
  Polynomial<Wide> of(std::uint64_t mask) const {
    const auto differing = static_cast<unsigned>(std::popcount(mask));
    const unsigned agreeing = compared_ - differing;
    const std::vector<std::int64_t>& numbers = numbers_[differing];
    std::vector<Polynomial<Wide>> outer;
    for (unsigned i = 0; i <= agreeing; ++i) {
      std::vector<Polynomial<Wide>> inner;
      for (unsigned k = 0; k <= free_bits_; ++k) {
        inner.push_back({Wide(numbers[i * (free_bits_ + 1) + k])});
      }
      outer.push_back(macwilliams_sum(inner, 1));
    }
    Polynomial<Wide> sum = macwilliams_sum(outer, 2);
    sum.insert(sum.begin(), differing, Wide());
    for (Wide& count : sum) count = count << differing >> checks_;
    return sum;
  }

 private:
  unsigned compared_;
  unsigned free_bits_;
  unsigned checks_;
  // For each mask, by its number of bits.
  std::vector<std::vector<std::int64_t>> numbers_;
};

Undetected& add_share(Undetected& sum, const Polynomial<Wide>& counts, long double share) {
  for (std::size_t w = 0; w < counts.size(); ++w) {
    if (counts[w] != 0) sum[w] += share * counts[w].convert_to<long double>();
  }
  return sum;
}

void subtract(Polynomial<Wide>& from, const Polynomial<Wide>& what) {
  if (from.size() < what.size()) from.resize(what.size());
  for (std::size_t w = 0; w < what.size(); ++w) from[w] -= what[w];
}

}  // namespace

std::vector<ComparedBit> compared_bits(const ChannelFormat& control, const ChannelFormat& safety,
                                       const SafetyComparison& comparison) {
  const auto fine = [](const ChannelFormat& channel) {
    return channel.position.present() ? channel.position : channel.singleturn;
  };
  if (control.coded() || safety.coded()) return {};
  if (control.crc.deviates() || safety.crc.deviates()) return {};
  std::vector<ComparedBit> bits;
  const Field a = fine(control);
  const Field b = fine(safety);
  const unsigned both = std::min(a.bits, b.bits);
  const unsigned asked = comparison.compare_bits;
  const unsigned compared = asked == 0 ? both : std::min(asked, both);
  const bool turns = comparison.multiturn == MultiturnRule::with_carry;
  const unsigned turn_bits = turns ? std::min(control.multiturn.bits, safety.multiturn.bits) : 0U;
  const auto add = [&bits](unsigned control_shift, unsigned safety_shift) {
    bits.push_back(
        {static_cast<std::uint8_t>(control_shift), static_cast<std::uint8_t>(safety_shift)});
  };
  for (unsigned i = turn_bits; i-- > 0;) {
    add(control.multiturn.shift + i, safety.multiturn.shift + i);
  }
  for (unsigned i = 1; i <= compared; ++i) {
    add(unsigned{a.shift} + a.bits - i, unsigned{b.shift} + b.bits - i);
  }
  return bits;
}

std::map<std::uint64_t, long double> passing_masks(unsigned bits, unsigned tolerance) {
  std::map<std::uint64_t, long double> masks;
  for (const auto& [pair, share] : masks_within(0, bits, tolerance)) masks[pair.safety] += share;
  return masks;
}

std::optional<PairError> pair_problem(const FrameFormat& format,
                                      const SafetyComparison& comparison) {
  const ChannelFormat& control = format.channel_list[0];
  const ChannelFormat& safety = format.channel_list[1];
  if (format.channel_count < 2 || control.position_bits() == 0 || safety.position_bits() == 0) {
    return PairError::no_pair;
  }
  const auto compared = compared_bits(control, safety, comparison).size();
  if (compared == 0) return PairError::nothing_to_compare;
  if (comparison.tolerance_lsb > (compared == 1 ? 0U : 1U)) return PairError::tolerance;
  if (control.crc.width_bits + safety.crc.width_bits > 24) return PairError::too_many_checks;
  return {};
}

PairWeights pair_weights(const FrameFormat& format, const SafetyComparison& comparison) {
  const ChannelFormat& first = format.channel_list[0];
  const ChannelFormat& second = format.channel_list[1];
  const auto compared = compared_bits(first, second, comparison);
  const auto bits = static_cast<unsigned>(compared.size());

  Word control(first, compared, true);
  Word safety(second, compared, false);
  const JointCount joint(control, safety, bits);
  const auto harmless = masks_within(comparison.tolerance_lsb, bits, comparison.tolerance_lsb);
  const auto right_control = control.with_right_position();

  PairWeights out;
  out.bits = control.code().bits() + safety.code().bits();
  out.compared_bits = bits;
  out.accepted.assign(out.bits + 1, 0);
  out.wrong.assign(out.bits + 1, 0);
  out.beyond_tolerance.assign(out.bits + 1, 0);
  for (const auto& [mask, share] : passing_masks(bits, comparison.tolerance_lsb)) {
    const auto all = joint.of(mask);
    add_share(out.accepted, all, share);
    auto wrong = all;
    subtract(wrong, product_of(right_control, safety.with(mask)));
    add_share(out.wrong, wrong, share);
    // Patterns that are harmless for some positions are counted one by one, all others together.
    auto rest = all;
    for (const auto& [masks, harmless_share] : harmless) {
      if ((masks.control ^ masks.safety) != mask) continue;
      const auto these = product_of(control.with(masks.control), safety.with(masks.safety));
      subtract(rest, these);
      add_share(out.beyond_tolerance, these, share - harmless_share);
    }
    add_share(out.beyond_tolerance, rest, share);
  }
  out.accepted[0] = 0;  // nothing wrong
  return out;
}

const char* text_of(PairError error) {
  constexpr std::array texts{
      "two channels with a position each are needed", "the two positions have no bit to compare",
      "the tolerance is more than 1, or more than 0 with a single compared bit",
      "the two checksums together have more than 24 bits"};
  return texts[static_cast<std::size_t>(error)];
}

std::optional<UndetectedShares> undetected_shares(const FrameFormat& format,
                                                  const SafetyComparison& comparison) {
  if (pair_problem(format, comparison)) return std::nullopt;
  FrameFormat exchanged = format;
  std::swap(exchanged.channel_list[0], exchanged.channel_list[1]);
  const PairWeights by_cpw = pair_weights(format, comparison);
  const PairWeights by_spw = pair_weights(exchanged, comparison);
  const auto share = [](const Undetected& of) { return probability(of, rated_bit_error_rate); };
  return UndetectedShares{.by_cpw = share(by_cpw.beyond_tolerance),
                          .by_spw = share(by_spw.beyond_tolerance),
                          .control_position = share(by_cpw.wrong)};
}

std::optional<SafetyRating> safety_rating(const FrameFormat& format,
                                          const SafetyComparison& comparison) {
  const auto shares = undetected_shares(format, comparison);
  if (!shares) return std::nullopt;
  // Rounded up, by more than the possible error of the sum.
  const long double scaled = std::ceil(shares->safe_position() * 1e24L * (1 + 1e-9L));
  if (scaled > 1e19L) return std::nullopt;
  SafetyRating rating;
  rating.words = rated_words(format.channel_list[0], format.channel_list[1], comparison);
  rating.residual_e24 = static_cast<std::uint64_t>(scaled);
  rating.check = rating_check(rating.words, rating.residual_e24);
  return rating;
}

}  // namespace biss::lab
