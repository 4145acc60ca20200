// Where the encoder stands from one request to the next.
#pragma once

#include <cstdint>
#include <random>

#include "biss/base/bits.hpp"

namespace biss::sim {

enum class MotionKind : std::uint8_t {
  constant,  ///< the same position for ever
  ramp,      ///< a steady step, round and round
  random,    ///< any position at any time
};

/// Positions of one width, one a request. The same seed gives the same positions on every machine.
class Motion {
 public:
  /// A ramp passes through the whole range in about 1000 requests.
  Motion(MotionKind kind, unsigned position_bits, std::uint64_t seed)
      : kind_(kind), mask_(low_mask(position_bits)), random_(seed), position_(random_() & mask_) {}

  std::uint64_t next() {
    const std::uint64_t now = position_;
    if (kind_ == MotionKind::ramp) position_ = (position_ + (mask_ / 1009 | 1U)) & mask_;
    if (kind_ == MotionKind::random) position_ = random_() & mask_;
    return now;
  }

 private:
  MotionKind kind_;
  std::uint64_t mask_;
  std::mt19937_64 random_;
  std::uint64_t position_;
};

}  // namespace biss::sim
