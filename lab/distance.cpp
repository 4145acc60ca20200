#include "lab/distance.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <utility>

namespace biss::lab {

// Extends the word bit by bit and keeps the smallest number of bits whose remainders cancel. A
// pattern may be shifted, so only patterns whose first and last bit are wrong are new.
std::vector<DistanceRun> distance_runs(std::uint32_t polynomial) {
  constexpr unsigned none = 100;
  const auto degree = static_cast<unsigned>(std::bit_width(polynomial)) - 1U;
  // By remainder: the fewest bits that give it, and whether a single bit gives it.
  std::vector<std::uint8_t> fewest(std::size_t{1} << degree, none);
  fewest[0] = 0;
  std::vector<bool> seen(fewest.size());
  std::uint32_t remainder = 1;  // of the new bit
  unsigned distance = none;
  std::vector<DistanceRun> runs;
  for (unsigned bits = 1; runs.empty() || runs.back().distance > 2; ++bits) {
    if (seen[remainder]) {
      distance = 2;
    } else if (seen[remainder ^ 1U]) {
      distance = std::min(distance, 3U);
    } else if (distance > 4) {  // otherwise only 2 and 3 are smaller
      distance = std::min(distance, 1U + fewest[remainder]);
    }
    if (distance > 4) {
      std::vector<std::uint8_t> next = fewest;
      for (std::size_t sum = 0; sum < fewest.size(); ++sum) {
        std::uint8_t& with_bit = next[sum ^ remainder];
        with_bit =
            static_cast<std::uint8_t>(std::min<unsigned>({with_bit, fewest[sum] + 1U, none}));
      }
      fewest = std::move(next);
    }
    seen[remainder] = true;
    remainder <<= 1U;
    if (((remainder >> degree) & 1U) != 0) remainder ^= polynomial;
    if (bits <= degree || (!runs.empty() && runs.back().distance == distance)) continue;
    const unsigned data_bits = bits - degree;
    if (!runs.empty()) runs.back().data_bits_max = data_bits - 1;
    runs.push_back({distance, data_bits, {}});
  }
  return runs;
}

}  // namespace biss::lab
