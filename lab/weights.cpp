#include "lab/weights.hpp"

#include <bit>

namespace biss::lab {
namespace {

// One row for each bit of the remainder: the data bits that it depends on.
std::vector<std::uint64_t> check_rows(const WordCode& code) {
  std::vector<std::uint64_t> rows(code.crc_bits, 0);
  std::uint32_t remainder = 1;  // of x^0, then of the next power
  for (unsigned power = 0; power < code.bits(); ++power) {
    for (unsigned i = 0; power >= code.crc_bits && i < code.crc_bits; ++i) {
      rows[i] |= std::uint64_t{(remainder >> i) & 1U} << (power - code.crc_bits);
    }
    remainder <<= 1U;
    if (((remainder >> code.crc_bits) & 1U) != 0) remainder ^= code.polynomial;
  }
  return rows;
}

}  // namespace

std::vector<std::uint64_t> dual_words(const WordCode& code) {
  const auto rows = check_rows(code);
  std::vector<std::uint64_t> words(std::size_t{1} << code.crc_bits, 0);
  for (std::size_t h = 1; h < words.size(); ++h) {
    words[h] = words[h & (h - 1)] ^ rows[static_cast<std::size_t>(std::countr_zero(h))];
  }
  return words;
}

Polynomial<Count> weights_of(const WordCode& code, const FixedBits& fixed) {
  const std::uint64_t free = low_mask(code.data_bits) & ~fixed.mask;
  const auto free_bits = static_cast<unsigned>(std::popcount(free)) + code.crc_bits;
  std::vector<SignedCount> dual(free_bits + 1, 0);  // by weight
  const auto words = dual_words(code);
  for (std::size_t h = 0; h < words.size(); ++h) {
    const bool negative = std::popcount(words[h] & fixed.mask & fixed.value) % 2 != 0;
    dual[static_cast<std::size_t>(std::popcount(words[h] & free) + std::popcount(h))] +=
        negative ? -1 : 1;
  }
  std::vector<Polynomial<SignedCount>> terms;
  for (const SignedCount number : dual) terms.push_back({number});
  // At most 2^16 words times the binomial coefficient of 80 and 40: below 2^93.
  const auto sum = macwilliams_sum(terms, 1);
  const auto given = static_cast<std::size_t>(std::popcount(fixed.mask & fixed.value));
  Polynomial<Count> weights(code.bits() + 1, 0);
  for (std::size_t w = 0; w < sum.size(); ++w) {
    weights[w + given] = static_cast<Count>(sum[w]) >> code.crc_bits;
  }
  return weights;
}

unsigned min_distance(const Polynomial<Count>& weights) {
  for (unsigned w = 1; w < weights.size(); ++w) {
    if (weights[w] != 0) return w;
  }
  return 0;
}

}  // namespace biss::lab
