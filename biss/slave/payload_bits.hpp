// A sampled position as the bits that go out.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "biss/base/bit_buffer.hpp"
#include "biss/frame/codec.hpp"

namespace biss::slave_detail {

/// All channels of one frame, each with its CRC, in the order on the line.
template <class Codec>
class PayloadBits {
 public:
  using Frame = typename Codec::Frame;

  constexpr void clear() {
    bits_.clear();
    loaded_bits_ = 0;
    word_ = empty;
  }

  constexpr void take(const Codec& codec, const Frame& frame) {
    clear();
    const FrameFormat& format = codec.format();
    for (std::size_t k = 0; k < format.channel_count; ++k) {
      const ChannelFormat& channel = format.channel_list[k];
      const std::uint64_t data = pack(channel, frame.channel_list[k]);
      bits_.append(data, channel.data_bits);
      if (channel.crc.present()) bits_.append(codec.crc(k, data), channel.crc.width_bits);
    }
  }

  /// Makes up to 63 more bits ready; false when all have been sent.
  /// \pre none is ready
  constexpr bool load() {
    const auto count =
        static_cast<unsigned>(std::min<std::size_t>(63, bits_.size_bits() - loaded_bits_));
    if (count == 0) return false;
    word_ = (bits_.view().word(loaded_bits_, count) * 2U + 1U) << (63U - count);
    loaded_bits_ = static_cast<std::uint16_t>(loaded_bits_ + count);
    return true;
  }

  /// Gives the next bit that is ready; false: none is, and `bit` is as it was.
  constexpr bool next(bool& bit) {
    const std::uint64_t rest = word_ << 1U;
    if (rest == 0) return false;
    bit = (word_ & empty) != 0;
    word_ = rest;
    return true;
  }

 private:
  static constexpr std::size_t channels = std::tuple_size_v<decltype(Frame::channel_list)>;

  BitBuffer<channels * max_channel_bits> bits_;
  // The bits that are ready from the top down, and a 1 behind the last.
  static constexpr std::uint64_t empty = std::uint64_t{1} << 63U;
  std::uint64_t word_ = empty;
  std::uint16_t loaded_bits_ = 0;
};

}  // namespace biss::slave_detail
