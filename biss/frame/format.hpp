// FrameFormat: the meaning of the bits of a single-cycle data frame, as data. DeviceTiming
// describes how the device behaves in time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/base/bits.hpp"
#include "biss/crc/spec.hpp"

namespace biss {

/// A BiSS master addresses at most 8 slaves (protocol description D2).
inline constexpr std::size_t max_channels = 8;
inline constexpr unsigned max_channel_bits = max_data_bits + max_crc_bits;
/// Width of the sign-of-life counter of BiSS Safety (Safety Concept A5, Renishaw's data sheet).
inline constexpr unsigned safety_counter_bits = 6;
/// Widest sign-of-life counter that a format may have.
inline constexpr unsigned max_life_counter_bits = 32;

/// A run of bits in a channel's data word. `shift` counts from the last data bit (the one before
/// the CRC), so a value is `(data >> shift) & low_mask(bits)`. `bits` 0: not in this channel.
struct Field {
  std::uint8_t shift = 0;
  std::uint8_t bits = 0;

  constexpr bool operator==(const Field&) const = default;
  constexpr bool present() const { return bits != 0; }
  constexpr std::uint64_t of(std::uint64_t data) const { return (data >> shift) & low_mask(bits); }
  constexpr std::uint64_t placed(std::uint64_t value) const {
    return (value & low_mask(bits)) << shift;
  }
};

/// One bit about the position: nE or nW (low-active, 0 = error or warning), E or W (high-active).
struct FlagField {
  std::uint8_t shift = 0;
  bool present = false;
  bool active_high = false;

  constexpr bool operator==(const FlagField&) const = default;
  constexpr Field place() const { return {shift, static_cast<std::uint8_t>(present ? 1 : 0)}; }
  /// The flag as nE or nW, whatever its polarity on the line: false = error or warning. True when
  /// absent.
  constexpr bool low_active(std::uint64_t data) const {
    return !present || (((data >> shift) & 1U) != 0) != active_high;
  }
  constexpr std::uint64_t placed(bool low_active_value) const {
    if (!present) return 0;
    return std::uint64_t{low_active_value != active_high} << shift;
  }
};

/// One data channel: `data_bits` (1…64) and its CRC. Bits that belong to no field are padding:
/// transmitted, covered by the CRC, not evaluated.
///
/// The position is either `position`, or `multiturn` above `singleturn` (each may be absent).
struct ChannelFormat {
  std::uint8_t data_bits = 0;
  Field position;
  Field multiturn;
  Field singleturn;
  /// Whether each part is in Gray code, and whether its lowest bit comes first.
  bool position_gray : 1 = false;
  bool multiturn_gray : 1 = false;
  bool singleturn_gray : 1 = false;
  bool position_lsb : 1 = false;
  bool multiturn_lsb : 1 = false;
  bool singleturn_lsb : 1 = false;
  FlagField error;
  FlagField warning;
  Field life_counter;
  CrcSpec crc;

  constexpr bool operator==(const ChannelFormat&) const = default;
  /// Data and CRC.
  constexpr unsigned total_bits() const { return unsigned{data_bits} + crc.width_bits; }
  /// Whether a part of the position is not a binary number with its highest bit first.
  constexpr bool coded() const {
    return position_gray || multiturn_gray || singleturn_gray || position_lsb || multiturn_lsb ||
           singleturn_lsb;
  }
  /// The data bits of the flags.
  constexpr std::uint64_t flags_mask() const {
    return std::uint64_t{error.present} << error.shift | std::uint64_t{warning.present}
                                                             << warning.shift;
  }
  /// Width of the position, 0 when the channel carries none.
  constexpr unsigned position_bits() const {
    return position.present() ? position.bits : unsigned{multiturn.bits} + singleturn.bits;
  }
};

/// The whole frame: 1…8 channels in the order on the line.
struct FrameFormat {
  std::array<ChannelFormat, max_channels> channel_list{};
  std::uint8_t channel_count = 0;
  /// CDS must be 0, as on a unidirectional device.
  bool cds0 = false;

  constexpr bool operator==(const FrameFormat&) const = default;
  constexpr std::span<const ChannelFormat> channels() const& {
    return std::span<const ChannelFormat>(channel_list).first(channel_count);
  }
  /// The channels would not outlive a temporary format.
  void channels() const&& = delete;
  /// Bits of all channels, CRCs included, without START, CDS and STOP.
  constexpr unsigned payload_bits() const {
    unsigned sum = 0;
    for (const ChannelFormat& channel : channels()) sum += channel.total_bits();
    return sum;
  }
  /// A checksum has an error of the encoder's maker.
  constexpr bool deviates() const {
    for (const ChannelFormat& channel : channels()) {
      if (channel.crc.deviates()) return true;
    }
    return false;
  }
  /// A checksum belongs to the previous frame, so that a frame alone cannot be checked.
  constexpr bool needs_previous() const {
    for (const ChannelFormat& channel : channels()) {
      if (channel.crc.of_previous) return true;
    }
    return false;
  }
  /// The same bits, with checksums of the previous frame as padding.
  constexpr FrameFormat without_previous() const {
    FrameFormat format = *this;
    for (ChannelFormat& channel : format.channel_list) {
      if (!channel.crc.of_previous) continue;
      const std::uint8_t width = channel.crc.width_bits;
      const auto move = [width](auto& field) {
        field.shift = static_cast<std::uint8_t>(field.shift + width);
      };
      for (Field* field :
           {&channel.position, &channel.multiturn, &channel.singleturn, &channel.life_counter}) {
        if (field->present()) move(*field);
      }
      for (FlagField* flag : {&channel.error, &channel.warning}) {
        if (flag->present) move(*flag);
      }
      channel.data_bits = static_cast<std::uint8_t>(channel.data_bits + width);
      channel.crc = {};
    }
    return format;
  }
};

/// The longest payload of any format.
inline constexpr unsigned max_payload_bits = max_channels * max_channel_bits;

}  // namespace biss
