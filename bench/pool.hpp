// Varied input: SPI buffers with one frame each, at varied offsets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "biss/frame/frame.hpp"

namespace biss::bench {

inline constexpr std::size_t pool_size = 4096;
inline constexpr std::uint64_t pool_seed = 0xB155'BE7C;

/// The same numbers on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// `count` random bits, 0…64.
  std::uint64_t bits(unsigned count) { return count == 0 ? 0 : engine_() >> (64U - count); }
  /// 0…limit - 1, with a negligible bias.
  std::uint32_t below(std::uint32_t limit) {
    return static_cast<std::uint32_t>(((engine_() >> 32U) * limit) >> 32U);
  }

 private:
  std::mt19937_64 engine_;
};

/// 4096 buffers of one format, all of one length; unless a shape says otherwise, 2 to 9 ones and ACK
/// of 33 to 160 clocks. Random positions and flags, so that START comes at any bit; zeros after STOP.
/// A pool fits a second-level cache.
class Pool {
 public:
  /// The bits before the data, and the length of all buffers; 0: the length that the longest frame
  /// needs.
  struct Shape {
    std::uint16_t lead_least = 2;
    std::uint16_t lead_most = 9;
    std::uint16_t ack_least = 33;
    std::uint16_t ack_most = 160;
    std::size_t bytes = 0;
  };

  explicit Pool(std::string_view format) : Pool(format, Shape()) {}
  /// \pre every frame fits shape.bytes
  Pool(std::string_view format, const Shape& shape);

  /// The buffers by index; small enough to stay in registers. The pool must outlive it.
  struct Buffers {
    const std::uint8_t* bytes;
    std::size_t size;

    std::span<const std::uint8_t> operator[](std::size_t index) const {
      return {bytes + index * size, size};
    }
  };
  Buffers buffers() const { return {bytes_.data(), stride_}; }
  /// The encoded frame.
  const Frame& frame(std::size_t index) const { return frames_[index]; }

 private:
  std::size_t stride_;
  std::vector<std::uint8_t> bytes_;
  std::vector<Frame> frames_;
};

}  // namespace biss::bench
