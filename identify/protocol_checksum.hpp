// Whether the words of a line carry a CRC, whatever its polynomial: the generator divides the
// difference of any two words.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "identify/gf2.hpp"

namespace biss::identify {

/// A word of at most 256 bits as a polynomial over GF(2); the bit sent last is the coefficient of 1.
using Word = WidePolynomial;

inline constexpr std::size_t word_bits_max = WidePolynomial::bits_max;

/// Appends a bit that was sent after those of `word`; the first of more than 256 bits is lost.
void append(Word& word, bool bit);

/// A checksum that the words agree on.
struct ChecksumEvidence {
  /// Degree of the common divisor; 0 where there is none.
  unsigned width_bits = 0;
  /// Of the divisor, without its leading 1.
  std::uint32_t polynomial = 0;
  /// Independent bits that agree with it: by chance they do so once in 2^bits captures.
  double bits = 0;
};

/// Searches for the generator of a CRC that ends the words, over the whole word and over each of
/// its ends (a frame of several channels). Up to four in ten words may be damaged. Repetition and
/// parity, whose divisors are powers of x + 1, are not taken for a CRC.
/// \param words of `bits` bits each, distinct; the first 200 are used
ChecksumEvidence find_checksum(std::span<const Word> words, std::size_t bits);

/// The number of bits of the words that change independently of each other.
std::size_t rank_of_differences(std::span<const Word> words);

}  // namespace biss::identify
