// The Hamming distance of a polynomial for each length of the data, and its detection of bursts.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace biss::lab {

/// For these lengths of data the smallest undetected error has `distance` wrong bits.
struct DistanceRun {
  unsigned distance = 0;
  unsigned data_bits_min = 1;
  std::optional<unsigned> data_bits_max;  ///< nothing: unlimited, as always for distance 2

  constexpr bool operator==(const DistanceRun&) const = default;
};

/// All runs, from one data bit on; the distance falls from run to run, to 2 in the last one. For any
/// length, not only those that a channel can have.
/// \pre polynomial is in full form and of degree 1…16
std::vector<DistanceRun> distance_runs(std::uint32_t polynomial);

}  // namespace biss::lab
