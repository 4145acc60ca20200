// How many error patterns of each weight a checksum does not see: exact, by MacWilliams' theorem
// over all words of the dual code.
#pragma once

#include <cstdint>
#include <vector>

#include "biss/crc/spec.hpp"
#include "biss/frame/format.hpp"
#include "lab/polynomial.hpp"
#include "lab/wide.hpp"

namespace biss::lab {

/// A word as it is protected: data bits, then the checksum. Start value and inversion do not matter
/// to what is detected, so only the polynomial counts. Without checksum (crc_bits 0) every pattern
/// is accepted.
struct WordCode {
  std::uint32_t polynomial = 0;  ///< full form
  unsigned crc_bits = 0;         ///< 0…16
  unsigned data_bits = 0;        ///< 1…64

  constexpr unsigned bits() const { return data_bits + crc_bits; }
};

constexpr WordCode code_of(const ChannelFormat& channel) {
  return {channel.crc.polynomial, channel.crc.width_bits, channel.data_bits};
}

/// Data bits of an error pattern whose values are given: those of `mask` are as in `value`. Bits
/// count from the last data bit, as in Field.
struct FixedBits {
  std::uint64_t mask = 0;
  std::uint64_t value = 0;
};

/// For each word h of the dual code, 2^crc_bits of them: the data bits in which it is 1. The bits
/// of h itself are those of the checksum.
std::vector<std::uint64_t> dual_words(const WordCode& code);

/// A[w]: the number of patterns of w wrong bits that the checksum accepts, w = 0…bits(); A[0] is 1,
/// the pattern without a wrong bit. With fixed bits, of those among them that have these values.
/// \pre the polynomial is in full form
Polynomial<Count> weights_of(const WordCode& code, const FixedBits& fixed = {});

/// The smallest number of wrong bits, from 1, that can be accepted; 0 when there is none.
unsigned min_distance(const Polynomial<Count>& weights);

}  // namespace biss::lab
