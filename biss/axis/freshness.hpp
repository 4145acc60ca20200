// Fresh data: the bytes of a transfer belong to its request, or they do not count as data.
//
// A peripheral can report the end of a transfer in which nothing was received: the DMA channel is
// dead, or the cache still has the old bytes. The buffer then contains the previous frame, with a
// good CRC. Therefore each request starts with a buffer of ones. If it still has only ones, the
// cause is no_response.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "biss/base/language.hpp"

namespace biss {

/// The receive buffers of one encoder, and the request that waits for its answer. There are two
/// buffers, because a transfer that has not ended may still write to its own.
///
/// One interrupt must not interrupt another one here: give them the same priority.
///
/// Each buffer begins and ends at a multiple of `alignment`: a word by default. With a data cache it
/// has to be the size of a line.
template <std::size_t max_bytes, std::size_t alignment = 4>
class FreshBuffer {
  static_assert(max_bytes <= 0xFFFF);

 public:
  constexpr FreshBuffer() = default;
  // A running transfer writes to this object's buffer; a copy would never receive the bytes.
  FreshBuffer(const FreshBuffer&) = delete;
  FreshBuffer& operator=(const FreshBuffer&) = delete;

  /// Starts a transfer of `bytes` bytes into a buffer of ones. An earlier request that still waits
  /// is given up.
  /// \param start called with the buffer; returns false if nothing was started
  /// \return false: nothing was started, and an earlier request still waits; also for 0 bytes or
  ///   more than max_bytes
  template <class Start>
  constexpr bool begin(std::size_t bytes, const Start& start) {
    if (bytes == 0 || bytes > max_bytes) return false;
    Buffer& next = buffers_[1U - current_];
    // All of it, so that the compiler knows the number of words.
    next.bytes.fill(0xFF);
    if (!start(std::span(next.bytes).first(bytes))) return false;
    current_ = static_cast<std::uint8_t>(1U - current_);
    bytes_ = static_cast<std::uint16_t>(bytes);
    waits_ = true;
    if (++number_ == 0) number_ = 1;
    return true;
  }

  /// Ends the request that waits.
  /// \return the received bytes, valid until the second begin() after this; empty if no request
  ///   waits: no buffer then has new data
  constexpr std::optional<std::span<const std::uint8_t>> end() {
    if (!waits_) return std::nullopt;
    waits_ = false;
    return std::span<const std::uint8_t>(buffers_[current_].bytes).first(bytes_);
  }

  constexpr bool waits() const { return waits_; }
  /// The number of the last request that was started, from 1; 0 before it. It wraps around.
  constexpr std::uint32_t number() const { return number_; }

 private:
  struct alignas(alignment) Buffer {
    std::array<std::uint8_t, (max_bytes + alignment - 1) / alignment * alignment> bytes{};
  };

  std::uint32_t number_ = 0;
  std::uint16_t bytes_ = 0;
  std::uint8_t current_ = 0;
  bool waits_ = false;
  std::array<Buffer, 2> buffers_{};
};

}  // namespace biss
