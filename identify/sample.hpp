// The frames of a capture from which the format is inferred.
#pragma once

#include <algorithm>
#include <cstdint>

#include "biss/base/bit_buffer.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/format.hpp"
#include "identify/gf2.hpp"

namespace biss::identify {

/// A frame whose structure is good: the bits after CDS, as received.
struct Sample {
  /// Number of its request cycle.
  std::uint64_t cycle = 0;
  Picoseconds time{};
  /// As received; 1 is an answer only if `asked`.
  bool cds = false;
  /// A control frame of the master may run, or its CDM was not seen.
  bool asked = false;
  BitBuffer<max_payload_bits + 1> bits;
};

/// A part of the bits after CDS: [begin, end).
struct Span {
  unsigned begin = 0;
  unsigned end = 0;

  bool operator==(const Span&) const = default;
  unsigned bits() const { return end - begin; }
};

/// The bits of a part as a polynomial, the first one on the line with the highest power.
/// \pre the sample has these bits; 128 at most
inline Polynomial polynomial_of(const Sample& sample, Span span) {
  const BitView bits = sample.bits.view();
  const unsigned low = std::min(span.bits(), 64U);
  const unsigned high = span.bits() - low;
  return Polynomial{bits.word(span.begin, high)} << low | bits.word(span.begin + high, low);
}

}  // namespace biss::identify
