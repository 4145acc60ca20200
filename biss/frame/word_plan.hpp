// The shifts and masks of a short frame of one channel, reckoned beforehand for decode_frame().
#pragma once

#include <cstddef>
#include <cstdint>

#include "biss/base/bits.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"

namespace biss::frame_detail {

// Where 64-bit words are cheap and a wrong guess at a branch is not.
inline constexpr bool selects = sizeof(std::size_t) >= 8;

// The position as one run of bits; multiturn right above singleturn is one.
constexpr Field position_field(const ChannelFormat& channel) {
  if (channel.position.present()) return channel.position;
  if (!channel.multiturn.present()) return channel.singleturn;
  if (!channel.singleturn.present()) return channel.multiturn;
  return {channel.singleturn.shift, static_cast<std::uint8_t>(channel.position_bits())};
}

// What WordPlan describes: one channel with a CRC, which BitView::window() holds from CDS to STOP,
// its position in one piece.
constexpr bool is_one_word(const FrameFormat& format) {
  const ChannelFormat& channel = format.channel_list[0];
  const bool parted = channel.multiturn.present() && channel.singleturn.present() &&
                      channel.multiturn.shift != channel.singleturn.shift + channel.singleturn.bits;
  return format.channel_count == 1 && channel.crc.present() && !channel.singleturn_gray &&
         !parted && format.payload_bits() + 2U <= BitView::sure_bits;
}

// All of it is about the word that BitView::window() gives for CDS, or about the data in it.
class WordPlan {
 public:
  constexpr explicit WordPlan(const FrameFormat& format) : one_word_(is_one_word(format)) {
    if (!one_word_) return;
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

  // False: not such a format, and nothing below may be asked.
  constexpr bool one_word() const { return one_word_; }
  constexpr unsigned payload_bits() const { return payload_bits_; }
  constexpr unsigned data_bits() const { return data_bits_; }
  constexpr bool cds(std::uint64_t word) const { return (word & cds_bit) != 0; }
  // STOP is 0, and CDS where it has to be.
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

  // A flag that is absent is a high-active one that never comes.
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

  bool one_word_;
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
