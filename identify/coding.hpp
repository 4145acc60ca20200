// How smoothly a value moves from frame to frame: what tells a position from other bits, and binary
// from Gray code.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace biss::identify {

/// The data of a channel in a frame with right checksums.
struct DataWord {
  std::uint64_t data = 0;
  std::uint64_t cycle = 0;
  /// Requests since the word before, by the time between them: rows may be missing, or come from
  /// pulses.
  std::uint64_t requests = 0;
};

/// A run of bits in a word; `low` counts from the last data bit.
struct Bits {
  unsigned low = 0;
  unsigned count = 0;

  unsigned high() const { return low + count; }
  std::uint64_t mask() const;
  std::uint64_t of(std::uint64_t data) const { return (data & mask()) >> low; }
};

/// The least number of bits of a singleturn position in Gray code.
inline constexpr unsigned least_gray_bits = 6;

/// How many bits it takes to write down each step of the value in `bits`, the lowest `gray_bits` of
/// it read as Gray code. A smooth motion has short steps, or steps that are nearly alike. Steps
/// over missing cycles are left out.
std::vector<double> step_lengths(std::span<const DataWord> words, Bits bits, unsigned gray_bits);

double sum(const std::vector<double>& values);

/// How a position is coded.
struct Coding {
  /// The lowest bits that are Gray code; 0: all are binary.
  unsigned gray_bits = 0;
  /// The motion shows that the first bit is the most significant one, and that no other coding fits.
  bool sure = false;
};

/// \param bits from the lowest to the highest bit that moves
Coding find_coding(std::span<const DataWord> words, Bits bits);

}  // namespace biss::identify
