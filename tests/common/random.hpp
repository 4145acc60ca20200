// Random numbers whose seed the test prints.
#pragma once

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <random>

namespace biss::test {

/// A generator from this seed, or from another one in each run.
inline std::mt19937_64 random_of(std::uint64_t seed = std::random_device{}()) {
  std::printf("seed %" PRIu64 "\n", seed);
  return std::mt19937_64(seed);
}

}  // namespace biss::test
