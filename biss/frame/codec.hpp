// A FrameFormat prepared for encoding and decoding, with its CRC engines: nothing is computed per
// frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "biss/base/bits.hpp"
#include "biss/crc/engines.hpp"
#include "biss/crc/placed.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"

namespace biss::frame_detail {

// True if 64-bit words are cheap and mispredicted branches are expensive.
inline constexpr bool selects = sizeof(std::size_t) >= 8;

constexpr std::uint64_t gray_to_binary(std::uint64_t value) {
  for (unsigned shift = 1; shift < 64; shift *= 2) value ^= value >> shift;
  return value;
}

constexpr std::uint64_t binary_to_gray(std::uint64_t value) { return value ^ (value >> 1U); }

constexpr std::uint64_t bits_reversed(std::uint64_t value, unsigned bits) {
  std::uint64_t reversed = 0;
  for (unsigned i = 0; i < bits; ++i) reversed |= ((value >> i) & 1U) << (bits - 1U - i);
  return reversed;
}

// A part of a position from its bits on the line, and the inverse.
constexpr std::uint64_t decoded(const Field& field, bool gray, bool lsb, std::uint64_t data) {
  std::uint64_t value = field.of(data);
  if (lsb) value = bits_reversed(value, field.bits);
  return gray ? gray_to_binary(value) : value;
}

constexpr std::uint64_t encoded(const Field& field, bool gray, bool lsb, std::uint64_t value) {
  value &= low_mask(field.bits);
  if (gray) value = binary_to_gray(value);
  if (lsb) value = bits_reversed(value, field.bits);
  return field.placed(value);
}

[[gnu::noinline, gnu::cold]] constexpr std::uint64_t coded_position_of(const ChannelFormat& format,
                                                                       std::uint64_t data) {
  const ChannelFormat& f = format;
  if (f.position.present()) return decoded(f.position, f.position_gray, f.position_lsb, data);
  const std::uint64_t turns = decoded(f.multiturn, f.multiturn_gray, f.multiturn_lsb, data);
  const std::uint64_t singleturn = decoded(f.singleturn, f.singleturn_gray, f.singleturn_lsb, data);
  // A shift by 64 is undefined; a multiturn value leaves at most 63 bits to the singleturn.
  return singleturn | (f.multiturn.present() ? turns << f.singleturn.bits : 0);
}

constexpr std::uint64_t position_of(const ChannelFormat& format, std::uint64_t data) {
  if (format.coded()) return coded_position_of(format, data);
  if (format.position.present()) return format.position.of(data);
  std::uint64_t position = format.singleturn.of(data);
  if (format.multiturn.present()) position |= format.multiturn.of(data) << format.singleturn.bits;
  return position;
}

// The checksum with the errors of the encoder's maker, bit by bit.
[[gnu::noinline, gnu::cold]] constexpr std::uint16_t deviating_crc(const ChannelFormat& channel,
                                                                   std::uint64_t data, bool cds) {
  const CrcSpec& spec = channel.crc;
  const std::uint64_t covered = spec.without_flags ? ~channel.flags_mask() : ~std::uint64_t{0};
  std::uint32_t reg = spec.start;
  if (spec.with_cds) reg = crc_detail::step(spec, reg, cds);
  for (unsigned i = channel.data_bits; i-- > 0;) {
    if (((covered >> i) & 1U) != 0) reg = crc_detail::step(spec, reg, ((data >> i) & 1U) != 0);
  }
  const std::uint16_t crc = crc_detail::finish(spec, reg);
  return spec.reversed ? static_cast<std::uint16_t>(bits_reversed(crc, spec.width_bits)) : crc;
}

// CRC of a channel's data word by `engine`, or with the errors of the maker.
template <class Engine>
[[gnu::always_inline]] constexpr std::uint16_t sent_crc(const ChannelFormat& channel,
                                                        const Engine& engine, std::uint64_t data,
                                                        bool cds) {
  return channel.crc.deviates() ? deviating_crc(channel, data, cds) : engine(data);
}

// Field by field: a Channel that is copied as a whole waits for its own stores.
constexpr void unpack_into(const ChannelFormat& format, std::uint64_t data, Channel& channel) {
  channel.position = position_of(format, data);
  channel.life_counter = static_cast<std::uint32_t>(format.life_counter.of(data));
  channel.nE = format.error.low_active(data);
  channel.nW = format.warning.low_active(data);
}

// ---- The shifts and masks of a channel in the word that BitView::window() gives, computed once

// The position as one run of bits; multiturn directly above singleturn counts as one run.
constexpr Field position_field(const ChannelFormat& channel) {
  if (channel.position.present()) return channel.position;
  if (!channel.multiturn.present()) return channel.singleturn;
  if (!channel.singleturn.present()) return channel.multiturn;
  return {channel.singleturn.shift, static_cast<std::uint8_t>(channel.position_bits())};
}

constexpr bool is_in_pieces(const ChannelFormat& channel) {
  const bool parted = channel.multiturn.present() && channel.singleturn.present() &&
                      channel.multiturn.shift != channel.singleturn.shift + channel.singleturn.bits;
  return channel.coded() || (!channel.position.present() && parted);
}

// Whether the window that begins a bit before the channel has the bit after it, too.
constexpr bool fits_window(const ChannelFormat& channel) {
  return channel.total_bits() + 2U <= BitView::known_bits;
}

constexpr bool fits_windows(const FrameFormat& format) {
  // The engines check a word without the deviations of a maker.
  if (format.deviates()) return false;
  for (const ChannelFormat& channel : format.channels()) {
    if (!fits_window(channel)) return false;
  }
  return true;
}

// Whether the only channel is one word with the position in one piece: most formats.
constexpr bool is_one_word(const FrameFormat& format) {
  return format.channel_count == 1 && fits_windows(format) && !is_in_pieces(format.channel_list[0]);
}

// The last zero of ACK that leaves room for `clocks` from START on in a word, as a bit of the word;
// 0 if there are too many.
constexpr std::uint64_t last_ack_of(std::size_t clocks, std::size_t word_bits = 64) {
  return clocks < word_bits ? std::uint64_t{1} << (64U - word_bits + clocks) : ~std::uint64_t{0};
}

// A channel in a word: the top bit is the one before the channel (CDS for the first channel), then
// data and CRC, then STOP for the last channel.
class WordPlan {
 public:
  constexpr WordPlan() = default;
  // \pre fits_window()
  constexpr WordPlan(const FrameFormat& format, std::size_t k) {
    const ChannelFormat& channel = format.channel_list[k];
    const unsigned last_data_bit = 63U - channel.data_bits;
    if (k == 0 && format.cds0) must_be_low_ = cds_bit;
    if (k + 1U == format.channel_count) must_be_low_ |= cds_bit >> 1U >> channel.total_bits();
    rest_mask_ = ~std::uint64_t{0} >> 1U >> channel.total_bits();
    data_bits_ = channel.data_bits;
    total_bits_ = static_cast<std::uint8_t>(channel.total_bits());
    in_pieces_ = is_in_pieces(channel) ? 1 : 0;
    const Field position = position_field(channel);
    position_shift_ = static_cast<std::uint8_t>(position.shift + last_data_bit);
    position_mask_ = position.placed(~std::uint64_t{0}) << last_data_bit;
    life_counter_shift_ = static_cast<std::uint8_t>(channel.life_counter.shift + last_data_bit);
    life_counter_mask_ = channel.life_counter.placed(~std::uint64_t{0}) << last_data_bit;
    error_ = Flag(channel.error, last_data_bit);
    warning_ = Flag(channel.warning, last_data_bit);
  }

  constexpr unsigned total_bits() const { return total_bits_; }
  static constexpr bool cds(std::uint64_t word) { return (word & cds_bit) != 0; }
  constexpr bool stop(std::uint64_t word) const {
    return (word & bits_detail::right(cds_bit >> 1U, total_bits_)) != 0;
  }
  // The bits after the channel.
  constexpr std::uint64_t rest(std::uint64_t word) const { return word & rest_mask_; }
  // STOP is 0, and so is CDS if the format requires it.
  constexpr bool is_low(std::uint64_t word) const { return (word & must_be_low_) == 0; }

  // The data, right-aligned.
  constexpr std::uint64_t data(std::uint64_t word) const {
    return bits_detail::right(word << 1U, 64U - data_bits_);
  }

  // All but the position.
  constexpr void unpack_flags_into(std::uint64_t word, Channel& channel) const {
    channel.life_counter = static_cast<std::uint32_t>(
        bits_detail::right(word & life_counter_mask_, life_counter_shift_));
    channel.nE = error_.low_active(word);
    channel.nW = warning_.low_active(word);
  }
  constexpr bool in_pieces() const { return in_pieces_ != 0; }
  // A position in one piece.
  constexpr std::uint64_t position(std::uint64_t word) const {
    return bits_detail::right(word & position_mask_, position_shift_);
  }

 private:
  static constexpr std::uint64_t cds_bit = std::uint64_t{1} << 63U;

  // The bit of a flag, and its level for an error or a warning; an absent flag never has it.
  struct Flag {
    std::uint64_t mask = 0;
    std::uint64_t active = 1;

    constexpr Flag() = default;
    constexpr Flag(const FlagField& field, unsigned last_data_bit) {
      if (!field.present) return;
      mask = std::uint64_t{1} << field.shift << last_data_bit;
      active = field.active_high ? mask : 0;
    }
    constexpr bool low_active(std::uint64_t word) const { return (word & mask) != active; }
  };

  std::uint64_t must_be_low_ = 0;
  std::uint64_t rest_mask_ = 0;
  std::uint64_t position_mask_ = 0;
  std::uint64_t life_counter_mask_ = 0;
  Flag error_;
  Flag warning_;
  std::uint8_t data_bits_ = 1;
  std::uint8_t total_bits_ = 1;
  // Not bool: after a fault of the memory it still has a value.
  std::uint8_t in_pieces_ = 0;
  std::uint8_t position_shift_ = 0;
  std::uint8_t life_counter_shift_ = 0;
};

}  // namespace biss::frame_detail

namespace biss {

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
    data |= frame_detail::encoded(format.position, format.position_gray, format.position_lsb,
                                  channel.position);
  } else {
    data |= frame_detail::encoded(format.singleturn, format.singleturn_gray, format.singleturn_lsb,
                                  channel.position);
    if (format.multiturn.present()) {
      data |= frame_detail::encoded(format.multiturn, format.multiturn_gray, format.multiturn_lsb,
                                    channel.position >> format.singleturn.bits);
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
  constexpr explicit FrameCodec(const FrameFormat& format)
      : clocks_(3U + format.payload_bits()),
        payload_bits_(static_cast<std::uint16_t>(format.payload_bits())),
        fits_windows_(frame_detail::fits_windows(format) ? 1 : 0),
        one_word_(frame_detail::is_one_word(format) ? 1 : 0),
        last_ack_((Channels == 2 ? fits_windows_ : one_word_) != 0
                      ? frame_detail::last_ack_of(clocks_)
                      : ~std::uint64_t{0}),
        format_(format) {
    for (std::size_t k = 0; k < format.channel_count; ++k) {
      const ChannelFormat& channel = format.channel_list[k];
      engines_[k] = PlacedCrc<Crc>(channel.crc, channel.data_bits);
      if (fits_windows_ != 0) plans_[k] = frame_detail::WordPlan(format, k);
    }
  }

  constexpr const FrameFormat& format() const { return format_; }
  constexpr unsigned payload_bits() const { return payload_bits_; }
  /// The CRC of channel k, as its engine computes it.
  constexpr const CrcSpec& engine_spec(std::size_t k) const { return engines_[k].spec(); }
  /// CRC of channel k's data word, as transmitted in a frame with this CDS; with
  /// CrcSpec::of_previous, in the frame after it. \pre the channel has a CRC
  constexpr std::uint16_t crc(std::size_t k, std::uint64_t data, bool cds) const {
    return frame_detail::sent_crc(format_.channel_list[k], engines_[k], data, cds);
  }

  // For decode_frame(): whether every channel fits BitView::window(), whether there is one only and
  // its position is in one piece, and whether this is possible at all.
  constexpr bool fits_windows() const { return fits_windows_ != 0; }
  constexpr bool one_word() const { return one_word_ != 0; }
  // From START to STOP.
  constexpr std::size_t clocks() const { return clocks_; }
  // The value of frame_detail::last_ack_of(); 0 if the format is not decoded inline.
  constexpr std::uint64_t last_ack() const { return last_ack_; }
  static constexpr bool may_fit_windows = true;
  static constexpr bool may_be_one_word = true;
  // Only if fits_windows().
  constexpr const frame_detail::WordPlan& plan(std::size_t k) const { return plans_[k]; }
  constexpr const PlacedCrc<Crc>& engine(std::size_t k) const { return engines_[k]; }

 private:
  std::size_t clocks_;
  std::uint16_t payload_bits_;
  // Not bool: after a fault of the memory it still has a value.
  std::uint8_t fits_windows_;
  std::uint8_t one_word_;
  std::uint64_t last_ack_;
  std::array<frame_detail::WordPlan, Channels> plans_{};
  FrameFormat format_;
  std::array<PlacedCrc<Crc>, Channels> engines_{};
};

/// The codec without tables, for a few frames or for little memory.
using PlainCodec = FrameCodec<CrcBitwise>;

}  // namespace biss
