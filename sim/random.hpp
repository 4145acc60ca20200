// Random numbers that are the same on every machine; any place of a sequence is reached directly.
#pragma once

#include <cstdint>

#include "biss/base/units.hpp"

namespace biss::sim {

/// SplitMix64's finaliser: neighbouring numbers give very different ones.
constexpr std::uint64_t scrambled(std::uint64_t number) {
  number += 0x9E3779B97F4A7C15U;
  number = (number ^ (number >> 30U)) * 0xBF58476D1CE4E5B9U;
  number = (number ^ (number >> 27U)) * 0x94D049BB133111EBU;
  return number ^ (number >> 31U);
}

/// The parts of a time that part_of() counts.
inline constexpr std::uint64_t time_parts = std::uint64_t{1} << 20U;

/// Returns time * parts / time_parts, rounded down, without an overflow in between.
/// \pre time is not negative, parts is at most time_parts
constexpr Picoseconds part_of(Picoseconds time, std::uint64_t parts) {
  constexpr auto all = static_cast<std::int64_t>(time_parts);
  const auto n = static_cast<std::int64_t>(parts);
  return time / all * n + Picoseconds{time.count % all * n / all};
}

/// A different sequence for each seed.
class Random {
 public:
  explicit constexpr Random(std::uint64_t seed) : state_(scrambled(seed)) {}

  constexpr std::uint64_t next() { return scrambled(state_++); }
  /// 0…limit - 1, almost evenly distributed; 0 if limit is 0. \pre limit is below 2^32
  constexpr std::uint64_t below(std::uint64_t limit) { return ((next() >> 32U) * limit) >> 32U; }

 private:
  std::uint64_t state_;
};

}  // namespace biss::sim
