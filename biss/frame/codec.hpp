// A FrameFormat made ready for use: the CRC engines stand beside it, nothing is computed per frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "biss/crc/engines.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"
#include "biss/frame/word_plan.hpp"

namespace biss {

namespace frame_detail {

constexpr std::uint64_t gray_to_binary(std::uint64_t value) {
  for (unsigned shift = 1; shift < 64; shift *= 2) value ^= value >> shift;
  return value;
}

constexpr std::uint64_t binary_to_gray(std::uint64_t value) { return value ^ (value >> 1U); }

constexpr std::uint64_t position_of(const ChannelFormat& format, std::uint64_t data) {
  if (format.position.present()) return format.position.of(data);
  std::uint64_t position = format.singleturn.of(data);
  if (format.singleturn_gray) position = gray_to_binary(position);
  // A shift by 64 is undefined; a multiturn value leaves at most 63 bits to the singleturn.
  if (format.multiturn.present()) position |= format.multiturn.of(data) << format.singleturn.bits;
  return position;
}

// Field by field into place: a Channel that is copied as a whole waits for its own stores.
constexpr void unpack_into(const ChannelFormat& format, std::uint64_t data, Channel& channel) {
  channel.position = position_of(format, data);
  channel.life_counter = static_cast<std::uint32_t>(format.life_counter.of(data));
  channel.nE = format.error.low_active(data);
  channel.nW = format.warning.low_active(data);
}

}  // namespace frame_detail

/// The values in a channel's data word.
/// \param data the channel's data_bits right-aligned, without CRC
constexpr Channel unpack(const ChannelFormat& format, std::uint64_t data) {
  Channel channel;
  frame_detail::unpack_into(format, data, channel);
  return channel;
}

/// The data word for a channel's values; padding is 0. The inverse of unpack().
/// \pre position and life counter fit their fields (encode_frame() checks)
constexpr std::uint64_t pack(const ChannelFormat& format, const Channel& channel) {
  std::uint64_t data = format.life_counter.placed(channel.life_counter);
  if (format.position.present()) {
    data |= format.position.placed(channel.position);
  } else {
    std::uint64_t singleturn = channel.position & low_mask(format.singleturn.bits);
    if (format.singleturn_gray) singleturn = frame_detail::binary_to_gray(singleturn);
    data |= format.singleturn.placed(singleturn);
    if (format.multiturn.present()) {
      data |= format.multiturn.placed(channel.position >> format.singleturn.bits);
    }
  }
  return data | format.error.placed(channel.nE) | format.warning.placed(channel.nW);
}

/// A format with its CRC engines. `Crc` is any engine of biss/crc/engines.hpp; `Channels` is how
/// many channels it has room for, so that firmware with one channel pays for one table.
template <class Crc = CrcFast, std::size_t Channels = max_channels>
class FrameCodec {
  static_assert(Channels >= 1 && Channels <= max_channels);

 public:
  /// What decoding with this codec gives.
  using Frame = BasicFrame<Channels>;

  /// \pre format has 1…Channels channels
  constexpr explicit FrameCodec(const FrameFormat& format) : format_(format), plan_(format) {
    for (std::size_t k = 0; k < format.channel_count; ++k) {
      engines_[k] = Crc(format.channel_list[k].crc);
    }
    payload_bits_ = static_cast<std::uint16_t>(format.payload_bits());
  }

  constexpr const FrameFormat& format() const { return format_; }
  constexpr unsigned payload_bits() const { return payload_bits_; }
  /// Whether one_word() can be true.
  static constexpr bool may_be_one_word = true;
  /// One channel with a CRC, which BitView::window() holds from CDS to STOP: most formats.
  constexpr bool one_word() const { return plan_.one_word(); }
  /// For decode_frame().
  constexpr const frame_detail::WordPlan& plan() const { return plan_; }
  /// CRC of channel k's data word, as transmitted. \pre the channel has a CRC
  constexpr std::uint16_t crc(std::size_t k, std::uint64_t data) const {
    return engines_[k](data, format_.channel_list[k].data_bits);
  }

 private:
  FrameFormat format_;
  frame_detail::WordPlan plan_;
  std::uint16_t payload_bits_ = 0;
  std::array<Crc, Channels> engines_{};
};

/// The codec without tables: for a few frames, or for no memory.
using PlainCodec = FrameCodec<CrcBitwise>;

}  // namespace biss
