// A seeded random source that gives the same numbers on every machine.
#pragma once

#include <cstdint>

namespace biss::test {

/// SplitMix64 (Steele, Lea, Flood 2014).
class Random {
 public:
  constexpr explicit Random(std::uint64_t seed) : state_(seed) {}

  /// 64 random bits.
  constexpr std::uint64_t next() {
    state_ += 0x9E3779B97F4A7C15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31U);
  }

  /// `count` random bits, 0…64.
  constexpr std::uint64_t bits(unsigned count) { return count == 0 ? 0 : next() >> (64U - count); }

  /// 0…limit - 1. \pre limit is not 0
  constexpr std::uint32_t below(std::uint32_t limit) {
    return static_cast<std::uint32_t>(((next() >> 32U) * limit) >> 32U);
  }

  constexpr bool flip() { return (next() >> 63U) != 0; }

 private:
  std::uint64_t state_;
};

}  // namespace biss::test
