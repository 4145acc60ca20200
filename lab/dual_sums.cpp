#include "lab/dual_sums.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

namespace biss::lab {
namespace {

// Bits of a word that must come as they were sent, or the monitor says no.
std::uint64_t fixed_bits(const ChannelFormat& word, bool counter) {
  std::uint64_t data = std::uint64_t{1} << word.error.shift;
  if (counter) data |= word.life_counter.placed(~std::uint64_t{0});
  return data << word.crc.width_bits;
}

// Where the position's lowest bit is in a word with its CRC.
unsigned position_shift(const ChannelFormat& word) {
  const unsigned shift = word.position.present()     ? word.position.shift
                         : word.singleturn.present() ? word.singleturn.shift
                                                     : word.multiturn.shift;
  return shift + word.crc.width_bits;
}

// Sums a word of the dual code for each of its index: bit j is whether error bit j turns its sign.
std::vector<std::uint64_t> dual_words(const std::vector<std::uint32_t>& columns, unsigned width) {
  std::vector<std::uint64_t> words(std::size_t{1} << width);
  for (std::size_t word = 0; word < words.size(); ++word) {
    for (std::size_t bit = 0; bit < columns.size(); ++bit) {
      words[word] |= std::uint64_t{std::popcount(word & columns[bit]) % 2 != 0} << bit;
    }
  }
  return words;
}

std::vector<long double> powers_of(long double base) {
  std::vector<long double> powers{1};
  for (std::size_t n = 1; n < weight_count; ++n) powers.push_back(powers.back() * base);
  return powers;
}

// The mean of the sign over all error patterns that the monitor lets pass, for one word of either
// dual code; its mean over all of them is the probability of such a pattern with both CRCs good.
class PassingMean {
 public:
  // position_kept: only patterns that leave the control word's position alone.
  PassingMean(const CampaignFrame& frame, long double rate, bool position_kept)
      : rate_(rate), kept_(position_kept), tilt_(powers_of(1 - 2 * rate)) {
    const safety_detail::Alignment& alignment = frame.plan().alignment();
    bits_ = alignment.bits;
    cpw_shift_ = position_shift(frame.cpw_format()) + alignment.cpw_shift;
    spw_shift_ = position_shift(frame.spw_format()) + alignment.spw_shift;
    tolerant_ = frame.plan().setup().comparison.tolerance_lsb == 1;
    std::uint64_t cpw_fixed = fixed_bits(frame.cpw_format(), false);
    const std::uint64_t spw_fixed = fixed_bits(frame.spw_format(), true);
    const std::uint64_t compared = low_mask(bits_);
    if (position_kept) {
      const std::uint64_t position = low_mask(frame.cpw_format().position_bits())
                                     << position_shift(frame.cpw_format());
      cpw_fixed |= position & ~(compared << cpw_shift_);
    }
    cpw_free_ = low_mask(frame.cpw_bits()) & ~cpw_fixed & ~(compared << cpw_shift_);
    spw_free_ = low_mask(frame.spw_bits()) & ~spw_fixed & ~(compared << spw_shift_);
    fixed_ = powers_of(
        1 - rate)[static_cast<std::size_t>(std::popcount(cpw_fixed) + std::popcount(spw_fixed))];
    const long double good = 1 - rate;
    same_ = powers_of(kept_ ? good * good : good * good + rate * rate);
    apart_ = powers_of(kept_ ? good * good : good * good - rate * rate);
  }

  long double operator()(std::uint64_t cpw, std::uint64_t spw) const {
    const std::uint64_t a = (cpw >> cpw_shift_) & low_mask(bits_);
    const std::uint64_t b = (spw >> spw_shift_) & low_mask(bits_);
    long double sum = equal_above(a ^ b, 0);
    // The values read differ by 1 where their lowest k bits do, as in …0111 and …1000.
    long double differing = 1;
    for (unsigned k = 1; tolerant_ && k <= bits_; ++k) {
      differing *= one_wrong((a >> (k - 1U)) & 1U, (b >> (k - 1U)) & 1U);
      if (differing == 0) break;
      const int pairs = k == bits_ ? 4 : 2;  // from the last value to the first one too
      sum += differing * equal_above(a ^ b, k) *
             std::ldexp(static_cast<long double>(pairs), -static_cast<int>(k));
    }
    return sum * fixed_ *
           tilt_[static_cast<std::size_t>(std::popcount(cpw & cpw_free_) +
                                          std::popcount(spw & spw_free_))];
  }

 private:
  // Compared bits from `from` on are wrong in both words or in none.
  long double equal_above(std::uint64_t apart, unsigned from) const {
    const std::uint64_t upper = from >= bits_ ? 0 : apart >> from;
    const auto differing = static_cast<std::size_t>(std::popcount(upper));
    return apart_[differing] * same_[bits_ - from - differing];
  }
  // A compared bit is wrong in one word only.
  long double one_wrong(std::uint64_t a, std::uint64_t b) const {
    const long double in_spw = b != 0 ? -1 : 1;
    if (kept_) return rate_ * (1 - rate_) * in_spw;
    return rate_ * (1 - rate_) * (in_spw + (a != 0 ? -1 : 1));
  }

  long double rate_;
  bool kept_;
  bool tolerant_ = false;
  unsigned bits_ = 0;
  unsigned cpw_shift_ = 0;
  unsigned spw_shift_ = 0;
  std::uint64_t cpw_free_ = 0;
  std::uint64_t spw_free_ = 0;
  long double fixed_ = 1;
  std::vector<long double> tilt_;
  std::vector<long double> same_;
  std::vector<long double> apart_;
};

long double good_sum(const std::vector<std::uint64_t>& dual, long double rate) {
  const auto tilt = powers_of(1 - 2 * rate);
  long double sum = 0;
  for (const std::uint64_t word : dual) sum += tilt[static_cast<std::size_t>(std::popcount(word))];
  return sum / static_cast<long double>(dual.size());
}

long double passing(const PassingMean& mean, const std::vector<std::uint64_t>& cpw,
                    const std::vector<std::uint64_t>& spw) {
  long double sum = 0;
  for (const std::uint64_t a : cpw) {
    long double row = 0;
    for (const std::uint64_t b : spw) row += mean(a, b);
    sum += row;
  }
  return sum / static_cast<long double>(cpw.size()) / static_cast<long double>(spw.size());
}

}  // namespace

CampaignTheory dual_sums(const CampaignFrame& frame, long double rate) {
  const auto cpw = dual_words(frame.cpw_columns(), frame.cpw_format().crc.width_bits);
  const auto spw = dual_words(frame.spw_columns(), frame.spw_format().crc.width_bits);
  const long double cpw_good = good_sum(cpw, rate);
  const long double spw_good = good_sum(spw, rate);
  const auto intact = powers_of(1 - rate);
  const long double all = passing(PassingMean(frame, rate, false), cpw, spw);
  const long double kept = passing(PassingMean(frame, rate, true), cpw, spw);
  return {cpw_good - intact[frame.cpw_bits()], spw_good - intact[frame.spw_bits()],
          cpw_good * spw_good - intact[frame.bits()], all - intact[frame.bits()], all - kept};
}

}  // namespace biss::lab
