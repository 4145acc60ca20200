// Error patterns of 256 frames at once: a word of bits a bit of the frame.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "sim/random.hpp"

namespace biss::lab {

inline constexpr std::size_t lane_words = 4;
inline constexpr std::size_t lane_frames = 64 * lane_words;

/// A bit of each of 256 frames: frame n is bit n % 64 of word n / 64. As wide as vector units may
/// be; the compiler takes it apart where they are narrower.
using Lanes = std::uint64_t __attribute__((vector_size(8 * lane_words)));

constexpr Lanes all_lanes(bool level) {
  const std::uint64_t word = level ? ~std::uint64_t{0} : 0;
  return Lanes{word, word, word, word};
}

inline bool any(const Lanes& lanes) { return (lanes[0] | lanes[1] | lanes[2] | lanes[3]) != 0; }

/// Four xoshiro256++ generators (Blackman and Vigna) side by side.
class LaneRandom {
 public:
  explicit LaneRandom(std::uint64_t seed) {
    sim::Random random(seed);
    for (Lanes& part : state_) {
      for (std::size_t word = 0; word < lane_words; ++word) part[word] = random.next();
    }
  }

  Lanes next() {
    const Lanes result = turned<23>(state_[0] + state_[3]) + state_[0];
    const Lanes shifted = state_[1] << 17U;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= shifted;
    state_[3] = turned<45>(state_[3]);
    return result;
  }

  /// Bits that are 1 with a probability of rate / 2^32 each: a uniform number is compared with the
  /// rate from the top until it is decided for every lane. \pre rate is not 0
  Lanes chosen(std::uint32_t rate) {
    Lanes open = all_lanes(true);
    Lanes below = all_lanes(false);
    do {
      const Lanes drawn = next();
      if ((rate >> 31U) != 0) {
        below |= open & ~drawn;
        open &= drawn;
      } else {
        open &= ~drawn;
      }
      rate <<= 1U;
    } while (rate != 0 && any(open));
    return below;
  }

 private:
  template <unsigned Bits>
  static Lanes turned(const Lanes& value) {
    return (value << Bits) | (value >> (64U - Bits));
  }

  std::array<Lanes, 4> state_{};
};

}  // namespace biss::lab
