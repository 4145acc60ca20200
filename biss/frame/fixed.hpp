// A format that is known at compile time: its shifts, masks and tables become constants.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "biss/base/bits.hpp"
#include "biss/base/result.hpp"
#include "biss/crc/engines.hpp"
#include "biss/crc/placed.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"

namespace biss {

namespace frame_detail {

template <class Crc, std::size_t Channels>
constexpr auto engines_of(const FrameFormat& format) {
  std::array<PlacedCrc<Crc>, Channels> engines{};
  for (std::size_t k = 0; k < Channels; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    engines[k] = PlacedCrc<Crc>(channel.crc, channel.data_bits);
  }
  return engines;
}

template <std::size_t Channels>
constexpr auto plans_of(const FrameFormat& format) {
  std::array<WordPlan, Channels> plans{};
  if (!fits_windows(format)) return plans;
  for (std::size_t k = 0; k < Channels; ++k) plans[k] = WordPlan(format, k);
  return plans;
}

}  // namespace frame_detail

/// A FrameCodec for `Format`; nothing of the format is read from memory.
///
///   constexpr auto format = frame_format("pos26,nE,nW,crc6;cds0");
///   const auto frame = decode_frame(bits, FixedCodec<format>{});
template <FrameFormat Format, class Crc = CrcFast>
class FixedCodec {
  static_assert(Format.channel_count >= 1);
  static_assert(!Format.needs_previous(), "a frame alone cannot be checked");

 public:
  using Frame = BasicFrame<Format.channel_count>;

  static constexpr const FrameFormat& format() { return format_; }
  static constexpr unsigned payload_bits() { return payload_bits_; }
  static constexpr std::size_t fixed_channels = Format.channel_count;
  static constexpr std::uint16_t crc(std::size_t k, std::uint64_t data, bool cds) {
    return frame_detail::sent_crc(format_.channel_list[k], engines_[k], data, cds);
  }
  /// crc() of a channel that is known while compiling: a separate function.
  template <std::size_t K>
  [[gnu::flatten]] static constexpr std::uint16_t crc_of(std::uint64_t data, bool cds) {
    return frame_detail::sent_crc(format_.channel_list[K], engines_[K], data, cds);
  }

  // For decode_frame(), as in FrameCodec.
  static constexpr std::size_t clocks() { return 3U + payload_bits_; }
  static constexpr std::uint64_t last_ack() { return frame_detail::last_ack_of(clocks()); }
  static constexpr bool may_fit_windows = frame_detail::fits_windows(Format);
  static constexpr bool may_be_one_word = frame_detail::is_one_word(Format);
  static constexpr bool fits_windows() { return may_fit_windows; }
  static constexpr bool one_word() { return may_be_one_word; }
  static constexpr const frame_detail::WordPlan& plan(std::size_t k) { return plans_[k]; }
  static constexpr const PlacedCrc<Crc>& engine(std::size_t k) { return engines_[k]; }

 private:
  static constexpr FrameFormat format_ = Format;
  static constexpr auto plans_ = frame_detail::plans_of<Format.channel_count>(Format);
  static constexpr unsigned payload_bits_ = Format.payload_bits();
  static constexpr auto engines_ = frame_detail::engines_of<Crc, Format.channel_count>(Format);
};

/// One channel of `Format`, for a channel at a known place: after a peripheral that finds START
/// itself, or in a buffer whose ACK never changes.
///
///   constexpr auto format = frame_format("pos24,nE,nW,crc6");
///   using Encoder = FixedChannel<format.channel_list[0]>;
///   const auto channel = Encoder::decode(word);
///
/// `Crc` is an engine of biss/crc/engines.hpp; its table is a constant of the class.
template <ChannelFormat Format, class Crc = CrcFast>
class FixedChannel {
  static_assert(Format.data_bits >= 1 && Format.crc.present(), "data with a CRC");
  static_assert(Format.total_bits() <= 64, "data and CRC have to fit one word");
  static_assert(!Format.crc.deviates(), "FixedCodec reads the errors of a maker");

 public:
  static constexpr const ChannelFormat& format() { return format_; }
  /// Data and CRC.
  static constexpr unsigned total_bits() { return Format.total_bits(); }

  /// \param payload the channel's data and CRC as on the line, the last CRC bit in bit 0; bits
  ///   above total_bits() are ignored
  /// \return the values, or `crc`
  [[nodiscard]] static constexpr Result<Channel, FrameError> decode(std::uint64_t payload) {
    const std::uint64_t data = (payload & low_mask(total_bits())) >> Format.crc.width_bits;
    const std::uint64_t received = payload & low_mask(Format.crc.width_bits);
    if (received != crc_(data, Format.data_bits)) return failure(FrameError::crc);
    return unpack(format_, data);
  }

  /// The inverse: data and CRC of these values.
  /// \pre position and life counter fit their fields
  [[nodiscard]] static constexpr std::uint64_t encode(const Channel& channel) {
    const std::uint64_t data = pack(format_, channel);
    return (data << Format.crc.width_bits) | crc_(data, Format.data_bits);
  }

 private:
  static constexpr ChannelFormat format_ = Format;
  static constexpr Crc crc_{Format.crc};
};

}  // namespace biss
