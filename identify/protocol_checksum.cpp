#include "identify/protocol_checksum.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace biss::identify {

namespace {

constexpr std::size_t distinct_words_used = 200;
constexpr unsigned width_min = 3;
constexpr unsigned width_max = 16;
// A divisor is found from this many words and confirmed by the others.
constexpr std::size_t words_of_a_try = 6;

// -1 for the polynomial 0.
int degree(const Word& word) {
  for (int i = 3; i >= 0; --i) {
    const std::uint64_t part = word[static_cast<std::size_t>(i)];
    if (part != 0) return 64 * i + 63 - std::countl_zero(part);
  }
  return -1;
}

Word sum(const Word& a, const Word& b) {
  return {a[0] ^ b[0], a[1] ^ b[1], a[2] ^ b[2], a[3] ^ b[3]};
}

Word times_power(const Word& word, unsigned power) {
  Word out{};
  const std::size_t words = power / 64;
  const unsigned bits = power % 64;
  for (std::size_t i = words; i < 4; ++i) {
    out[i] = word[i - words] << bits;
    if (bits != 0 && i > words) out[i] |= word[i - words - 1] >> (64 - bits);
  }
  return out;
}

Word over_x(const Word& word) {
  return {word[0] >> 1U | word[1] << 63U, word[1] >> 1U | word[2] << 63U,
          word[2] >> 1U | word[3] << 63U, word[3] >> 1U};
}

Word remainder(Word word, const Word& divisor) {
  const int size = degree(divisor);
  for (int at = degree(word); at >= size; at = degree(word)) {
    word = sum(word, times_power(divisor, static_cast<unsigned>(at - size)));
  }
  return word;
}

// Without factors x: they are only bits after the checksum that never change.
Word common_divisor(Word a, Word b) {
  while (degree(b) >= 0) {
    const Word rest = remainder(a, b);
    a = b;
    b = rest;
  }
  while (degree(a) > 0 && (a[0] & 1U) == 0) a = over_x(a);
  return a;
}

bool is_power_of_x_plus_1(Word word) {
  const Word x_plus_1{3, 0, 0, 0};
  while (degree(word) > 0) {
    // Of a polynomial that x + 1 divides, the quotient's coefficients are the running sums.
    if (degree(remainder(word, x_plus_1)) >= 0) return false;
    Word quotient{};
    bool carry = false;
    for (int i = degree(word); i > 0; --i) {
      const auto at = static_cast<std::size_t>(i);
      carry = carry != ((word[at / 64] >> (at % 64) & 1U) != 0);
      if (carry) quotient[(at - 1) / 64] |= std::uint64_t{1} << ((at - 1) % 64);
    }
    word = quotient;
  }
  return true;
}

Word lower_part(const Word& word, std::size_t bits) {
  Word out{};
  for (std::size_t i = 0; i < 4 && 64 * i < bits; ++i) {
    const std::size_t left = bits - 64 * i;
    out[i] = left >= 64 ? word[i] : word[i] & ((std::uint64_t{1} << left) - 1U);
  }
  return out;
}

// The generator that words chosen by `attempt` have in common, tested on all.
ChecksumEvidence try_words(std::span<const Word> words, std::size_t bits, std::size_t attempt) {
  const auto pick = [&](std::size_t k) {
    return lower_part(words[(attempt * 7 + k * (2 * attempt + 3)) % words.size()], bits);
  };
  const Word base = pick(0);
  Word divisor{};
  for (std::size_t k = 1; k < words_of_a_try; ++k) {
    divisor = common_divisor(divisor, sum(base, pick(k)));
    if (degree(divisor) >= 0 && degree(divisor) < static_cast<int>(width_min)) return {};
  }
  const int width = degree(divisor);
  if (width < static_cast<int>(width_min) || width > static_cast<int>(width_max)) return {};
  if (is_power_of_x_plus_1(divisor)) return {};
  std::vector<Word> agreeing;
  for (const Word& word : words) {
    const Word part = lower_part(word, bits);
    if (degree(remainder(sum(base, part), divisor)) < 0) agreeing.push_back(part);
  }
  if (10 * agreeing.size() < 6 * words.size()) return {};
  const double rank = static_cast<double>(rank_of_differences(agreeing));
  ChecksumEvidence found;
  found.width_bits = static_cast<unsigned>(width);
  found.polynomial = static_cast<std::uint32_t>(divisor[0] ^ std::uint64_t{1} << width);
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
  word = times_power(word, 1);
  word[0] |= bit ? 1U : 0U;
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
  std::vector<Word> basis;
  for (std::size_t i = 1; i < std::min(words.size(), distinct_words_used); ++i) {
    Word difference = sum(words[0], words[i]);
    for (const Word& each : basis) {
      const Word reduced = sum(difference, each);
      if (reduced[3] != difference[3]   ? reduced[3] < difference[3]
          : reduced[2] != difference[2] ? reduced[2] < difference[2]
          : reduced[1] != difference[1] ? reduced[1] < difference[1]
                                        : reduced[0] < difference[0]) {
        difference = reduced;
      }
    }
    if (degree(difference) < 0) continue;
    basis.push_back(difference);
    // Largest first, so that one pass reduces.
    std::sort(basis.begin(), basis.end(),
              [](const Word& a, const Word& b) { return degree(a) > degree(b); });
  }
  return basis.size();
}

}  // namespace biss::identify
