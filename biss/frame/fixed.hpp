// A channel whose format is known while compiling: its shifts, masks and table become constants.
#pragma once

#include <cstdint>

#include "biss/base/bits.hpp"
#include "biss/base/result.hpp"
#include "biss/crc/engines.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"

namespace biss {

/// One channel of `Format`, for where its place is known and nothing has to be searched: behind a
/// peripheral that finds START itself, or in a buffer whose ACK never changes.
///
///   constexpr auto format = parse_format("pos24,nE,nW,crc6").value();
///   using Encoder = FixedChannel<format.channel_list[0]>;
///   const auto channel = Encoder::decode(word);
///
/// `Crc` is any engine of biss/crc/engines.hpp; its table is a constant of the class.
template <ChannelFormat Format, class Crc = CrcFast>
class FixedChannel {
  static_assert(Format.data_bits >= 1 && Format.crc.present(), "data with a CRC");
  static_assert(Format.total_bits() <= 64, "data and CRC have to fit one word");

 public:
  static constexpr const ChannelFormat& format() { return format_; }
  /// Data and CRC.
  static constexpr unsigned total_bits() { return Format.total_bits(); }

  /// \param payload the channel's data and CRC as on the line, the last CRC bit in bit 0; bits
  ///   above total_bits() are not looked at
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
