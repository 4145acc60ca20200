// One part of several that a run is divided into.
#pragma once

#include <cstdint>

namespace biss::lab {

inline constexpr std::uint64_t max_shards = std::uint64_t{1} << 20U;

/// Every count-th block, from block number - 1 on. \pre 1 <= number <= count <= max_shards
struct Shard {
  std::uint64_t number = 1;
  std::uint64_t count = 1;
};

}  // namespace biss::lab
