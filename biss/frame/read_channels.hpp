// The channels behind CDS, to a frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include "biss/base/bits.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"

namespace biss::frame_detail {

// Channel k, whose first bit is at `at`, and then the one behind it. False: its CRC is wrong.
template <class Crc, class Frame>
[[gnu::always_inline]] constexpr bool read_channel(const BitView& bits, std::size_t& at,
                                                   const ChannelFormat& channel, const Crc& crc,
                                                   std::size_t k, Frame& frame) {
  const std::uint64_t data = bits.word(at, channel.data_bits);
  at += channel.data_bits;
  if (channel.crc.present()) {
    if (bits.word(at, channel.crc.width_bits) != crc(k, data)) return false;
    at += channel.crc.width_bits;
  }
  unpack_into(channel, data, frame.channel_list[k]);
  return true;
}

// Several channels that are known while compiling: each is read with its own numbers, instead of
// all with what is loaded from memory.
template <class Codec>
inline constexpr bool has_fixed_channels = false;
template <class Codec>
requires(Codec::fixed_channels > 1) inline constexpr bool has_fixed_channels<Codec> = true;

template <std::size_t K, class Codec>
[[gnu::always_inline]] constexpr bool read_fixed_channel(const BitView& bits, std::size_t& at,
                                                         const Codec&, typename Codec::Frame& frame,
                                                         std::size_t& read) {
  const auto crc = [](std::size_t, std::uint64_t data) { return Codec::template crc_of<K>(data); };
  const bool right = read_channel(bits, at, Codec::format().channel_list[K], crc, K, frame);
  read += right ? 1U : 0U;
  return right;
}

// All of them. The first one whose CRC is wrong, or their number.
template <class Codec, std::size_t... K>
[[gnu::always_inline]] constexpr std::size_t read_fixed_channels(const BitView& bits,
                                                                 std::size_t at, const Codec& codec,
                                                                 typename Codec::Frame& frame,
                                                                 std::index_sequence<K...>) {
  std::size_t read = 0;
  static_cast<void>((read_fixed_channel<K>(bits, at, codec, frame, read) && ...));
  return read;
}

// All channels, from the first bit of the first one on. The first one whose CRC is wrong, or their
// number.
template <class Codec>
[[gnu::always_inline]] constexpr std::size_t read_channels(const BitView& bits, std::size_t at,
                                                           const Codec& codec,
                                                           typename Codec::Frame& frame) {
  if constexpr (has_fixed_channels<Codec>) {
    return read_fixed_channels(bits, at, codec, frame,
                               std::make_index_sequence<Codec::fixed_channels>());
  } else {
    const std::size_t count = codec.format().channel_count;
    const auto crc = [&](std::size_t k, std::uint64_t data) { return codec.crc(k, data); };
    for (std::size_t k = 0; k < count; ++k) {
      if (!read_channel(bits, at, codec.format().channel_list[k], crc, k, frame)) return k;
    }
    return count;
  }
}

}  // namespace biss::frame_detail
