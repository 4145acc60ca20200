#include "identify/protocol_checksum.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace biss::identify {

namespace {

constexpr std::size_t distinct_words_used = 200;
constexpr unsigned width_min = 3;
constexpr unsigned width_max = 16;
// A divisor is found from this many words and confirmed by the others.
constexpr std::size_t words_of_a_try = 6;

bool is_power_of_x_plus_1(Word word) {
  while (degree(word) > 0) {
    const auto [quotient, rest] = divided(word, Word{3});
    if (degree(rest) >= 0) return false;
    word = quotient;
  }
  return true;
}

// The generator that words chosen by `attempt` have in common, tested on all.
ChecksumEvidence try_words(std::span<const Word> words, std::size_t bits, std::size_t attempt) {
  const auto pick = [&](std::size_t k) {
    return words[(attempt * 7 + k * (2 * attempt + 3)) % words.size()].lower_part(bits);
  };
  const Word base = pick(0);
  Word divisor{};
  for (std::size_t k = 1; k < words_of_a_try; ++k) {
    // Factors x are only bits after the checksum that never change.
    divisor = without_x(common_divisor(divisor, base ^ pick(k)));
    if (degree(divisor) >= 0 && degree(divisor) < static_cast<int>(width_min)) return {};
  }
  const int width = degree(divisor);
  if (width < static_cast<int>(width_min) || width > static_cast<int>(width_max)) return {};
  if (is_power_of_x_plus_1(divisor)) return {};
  std::vector<Word> agreeing;
  for (const Word& word : words) {
    const Word part = word.lower_part(bits);
    if (degree(remainder(base ^ part, divisor)) < 0) agreeing.push_back(part);
  }
  if (10 * agreeing.size() < 6 * words.size()) return {};
  const double rank = static_cast<double>(rank_of_differences(agreeing));
  ChecksumEvidence found;
  found.width_bits = static_cast<unsigned>(width);
  found.polynomial = static_cast<std::uint32_t>(divisor.low() ^ std::uint64_t{1} << width);
  found.bits = (rank - 1) * width;
  return found;
}

ChecksumEvidence best_of_tries(std::span<const Word> words, std::size_t bits, std::size_t tries) {
  ChecksumEvidence best;
  for (std::size_t attempt = 0; attempt < tries; ++attempt) {
    const ChecksumEvidence found = try_words(words, bits, attempt);
    if (found.bits > best.bits) best = found;
  }
  return best;
}

}  // namespace

void append(Word& word, bool bit) {
  word = word << 1 ^ Word { bit ? 1U : 0U };
}

ChecksumEvidence find_checksum(std::span<const Word> words, std::size_t bits) {
  words = words.first(std::min(words.size(), distinct_words_used));
  if (words.size() < 3 || bits > word_bits_max) return {};
  ChecksumEvidence best = best_of_tries(words, bits, 16);
  if (best.bits >= 12) return best;
  constexpr std::size_t shortest_end = 8;
  for (std::size_t end = shortest_end; end < bits; ++end) {
    ChecksumEvidence found = best_of_tries(words, end, 3);
    found.bits -= std::log2(static_cast<double>(bits));
    if (found.bits > best.bits) best = found;
    if (best.bits >= 20) break;
  }
  return best;
}

std::size_t rank_of_differences(std::span<const Word> words) {
  Basis<Word> basis;
  for (std::size_t i = 1; i < std::min(words.size(), distinct_words_used); ++i) {
    basis.add(words[0] ^ words[i]);
  }
  return basis.rank();
}

}  // namespace biss::identify
