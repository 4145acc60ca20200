// A FrameFormat prepared for encoding and decoding, with its CRC engines: nothing is computed per
// frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "biss/base/bits.hpp"
#include "biss/crc/engines.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"

namespace biss::frame_detail {

// ---- The shifts and masks of a short frame of one channel, computed once for decode_frame()

// True where 64-bit words are cheap and mispredicted branches are not.
inline constexpr bool selects = sizeof(std::size_t) >= 8;

// The position as one run of bits; multiturn directly above singleturn is one.
constexpr Field position_field(const ChannelFormat& channel) {
  if (channel.position.present()) return channel.position;
  if (!channel.multiturn.present()) return channel.singleturn;
  if (!channel.singleturn.present()) return channel.multiturn;
  return {channel.singleturn.shift, static_cast<std::uint8_t>(channel.position_bits())};
}

// True for the formats of WordPlan: one channel with a CRC, its position in one piece, that fits
// BitView::window() from CDS to STOP.
constexpr bool is_one_word(const FrameFormat& format) {
  const ChannelFormat& channel = format.channel_list[0];
  const bool parted = channel.multiturn.present() && channel.singleturn.present() &&
                      channel.multiturn.shift != channel.singleturn.shift + channel.singleturn.bits;
  return format.channel_count == 1 && channel.crc.present() && !channel.singleturn_gray &&
         !parted && format.payload_bits() + 2U <= BitView::known_bits;
}

// All members describe the word that BitView::window() gives for CDS, or the data in it.
class WordPlan {
 public:
  constexpr explicit WordPlan(const FrameFormat& format) : one_word_(is_one_word(format) ? 1 : 0) {
    if (one_word_ == 0) return;
    const ChannelFormat& channel = format.channel_list[0];
    payload_bits_ = static_cast<std::uint8_t>(format.payload_bits());
    data_bits_ = channel.data_bits;
    crc_bits_ = channel.crc.width_bits;
    must_be_low_ = (cds_bit >> 1U >> payload_bits_) | (format.cds0 ? cds_bit : 0U);
    const Field position = position_field(channel);
    position_shift_ = position.shift;
    position_mask_ = position.placed(~std::uint64_t{0});
    life_counter_shift_ = channel.life_counter.shift;
    life_counter_mask_ = channel.life_counter.placed(~std::uint64_t{0});
    error_ = Flag(channel.error);
    warning_ = Flag(channel.warning);
  }

  // False: another format; the other members are undefined.
  constexpr bool one_word() const { return one_word_ != 0; }
  constexpr unsigned payload_bits() const { return payload_bits_; }
  constexpr unsigned data_bits() const { return data_bits_; }
  constexpr bool cds(std::uint64_t word) const { return (word & cds_bit) != 0; }
  // STOP is 0, and so is CDS where the format requires it.
  constexpr bool is_low(std::uint64_t word) const { return (word & must_be_low_) == 0; }
  constexpr std::uint64_t data(std::uint64_t word) const {
    return word << 1U >> (64U - data_bits_);
  }
  constexpr std::uint64_t crc(std::uint64_t word) const {
    return word << 1U << data_bits_ >> (64U - crc_bits_);
  }

  constexpr void unpack_into(std::uint64_t data, Channel& channel) const {
    channel.position = (data & position_mask_) >> position_shift_;
    channel.life_counter =
        static_cast<std::uint32_t>((data & life_counter_mask_) >> life_counter_shift_);
    channel.nE = error_.low_active(data);
    channel.nW = warning_.low_active(data);
  }

 private:
  static constexpr std::uint64_t cds_bit = std::uint64_t{1} << 63U;

  // An absent flag acts as a high-active one that is always 0.
  struct Flag {
    std::uint64_t mask = 0;
    bool active_high = true;

    constexpr Flag() = default;
    constexpr explicit Flag(const FlagField& field)
        : mask(field.present ? std::uint64_t{1} << field.shift : 0U),
          active_high(!field.present || field.active_high) {}
    constexpr bool low_active(std::uint64_t data) const {
      return ((data & mask) != 0) != active_high;
    }
  };

  // Not bool: after a fault of the memory it still has a value.
  std::uint8_t one_word_;
  std::uint8_t payload_bits_ = 1;
  std::uint8_t data_bits_ = 1;
  std::uint8_t crc_bits_ = 1;
  std::uint8_t position_shift_ = 0;
  std::uint8_t life_counter_shift_ = 0;
  std::uint64_t must_be_low_ = 0;
  std::uint64_t position_mask_ = 0;
  std::uint64_t life_counter_mask_ = 0;
  Flag error_;
  Flag warning_;
};

}  // namespace biss::frame_detail

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

// Field by field: a Channel that is copied as a whole waits for its own stores.
constexpr void unpack_into(const ChannelFormat& format, std::uint64_t data, Channel& channel) {
  channel.position = position_of(format, data);
  channel.life_counter = static_cast<std::uint32_t>(format.life_counter.of(data));
  channel.nE = format.error.low_active(data);
  channel.nW = format.warning.low_active(data);
}

}  // namespace frame_detail

/// The values in a channel's data word.
/// \param data the channel's data_bits, right-aligned, without CRC
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

/// A format with its CRC engines. `Crc` is an engine of biss/crc/engines.hpp. `Channels` is the
/// number of channels it has room for, so that firmware with one channel stores one table.
template <class Crc = CrcFast, std::size_t Channels = max_channels>
class FrameCodec {
  static_assert(Channels >= 1 && Channels <= max_channels);

 public:
  /// The type of frame that decoding with this codec gives.
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
  /// One channel with a CRC that BitView::window() holds from CDS to STOP: most formats.
  constexpr bool one_word() const { return plan_.one_word(); }
  /// For decode_frame().
  constexpr const frame_detail::WordPlan& plan() const { return plan_; }
  /// What the engine of channel k computes: the CRC of its format.
  constexpr const CrcSpec& engine_spec(std::size_t k) const { return engines_[k].spec(); }
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

/// The codec without tables, for a few frames or for little memory.
using PlainCodec = FrameCodec<CrcBitwise>;

}  // namespace biss
