// The Hamming distance of a polynomial by length of the data, and what it says of bursts.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace biss::lab {

/// For these lengths of data the smallest undetected error has `distance` wrong bits.
struct DistanceRun {
  unsigned distance = 0;
  unsigned data_bits_min = 1;
  std::optional<unsigned> data_bits_max;  ///< nothing: without end, as always for distance 2

  constexpr bool operator==(const DistanceRun&) const = default;
};

/// All of them, from one data bit on; the distance falls from run to run and the last one is 2 (or
/// less than 2 never comes). For any length, not only those that a channel can have.
/// \pre polynomial is in full form and of degree 1…16
std::vector<DistanceRun> distance_runs(std::uint32_t polynomial);

/// The longest data that still has this distance: 57 for 0x43 and 3. 0: none has it; nothing: all.
std::optional<unsigned> data_bits_with(const std::vector<DistanceRun>& runs, unsigned distance);

/// A burst of `length_bits`: its first and last bit wrong, those between any.
struct BurstShare {
  unsigned length_bits = 0;
  /// Of the 2^(length - 2) such patterns at one place the part that is not seen is 2^-halvings;
  /// nothing: all are seen.
  std::optional<unsigned> halvings;
};

/// A checksum of `crc_bits` sees all bursts up to that length, all but 2^-(crc_bits - 1) of those
/// one bit longer, and all but 2^-crc_bits of all others, wherever they lie. \pre lengths from 2 on
constexpr BurstShare burst_share(unsigned crc_bits, unsigned length_bits) {
  BurstShare burst{length_bits, {}};
  if (length_bits == crc_bits + 1) burst.halvings = crc_bits - 1;
  if (length_bits > crc_bits + 1) burst.halvings = crc_bits;
  return burst;
}

}  // namespace biss::lab
