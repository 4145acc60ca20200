// How often a frame read from a wrong START passes every check. Exact: counted, not estimated.
//
// START is lost and a later 1 is taken for it, or a bit flipped in ACK is taken for START too
// early. The reader then looks at other bits than the encoder meant. Every bit on the line is the
// XOR of data bits and a constant (a CRC is linear), and so is every check. Hence the data words
// that pass are an affine subspace: with c independent conditions exactly 2^-c of all words pass,
// or none.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "biss/base/bits.hpp"
#include "biss/crc/engines.hpp"
#include "biss/frame/format.hpp"
#include "lab/affine.hpp"

namespace biss {

/// What the encoder sends and what the reader looks at. Position and counter bits are independent
/// and evenly distributed; padding is 0.
struct SlipModel {
  /// The flags say "no error, no warning", as those of a healthy encoder. false: evenly
  /// distributed, too.
  bool healthy_flags = true;
  /// The CDS bit the encoder sends.
  bool cds = false;
  /// Every further channel's `pos` is the top bits of the first channel's, as that of a safety word
  /// is. false: independent.
  bool aligned_words = false;
  /// Count only frames that pass Frame::trusted(), as for a reader that uses no other.
  bool trusted_only = false;
  /// The reader wants SLO low behind STOP up to the last clock (SpiTail::must_stay_low).
  bool tail_checked = false;

  constexpr bool operator==(const SlipModel&) const = default;
};

/// A START in the wrong place. Places count in clocks from the true START, negative before it.
struct Slip {
  /// Where START is seen; not 0.
  int place = 1;
  /// Zeros the encoder sent as ACK; before them the line was 1.
  std::uint16_t ack_clocks = 1;
  /// Only with place > 0: this many bits behind the true START are 1 and extend the leading ones
  /// (when a lone ACK bit was lost). The bits from there to `place` are the ACK that is seen.
  std::uint16_t ones_clocks = 0;
};

namespace frame_detail {

// Sets the conditions of one slip up.
template <std::size_t Channels>
class SlipCount {
  using Bit = AffineBit<Channels>;

 public:
  constexpr SlipCount(const FrameFormat& format, const Slip& slip, const SlipModel& model)
      : format_(format), slip_(slip), model_(model), payload_bits_(format.payload_bits()) {
    for (std::size_t k = 0; k < format.channel_count; ++k) prepare(k);
  }

  constexpr std::optional<unsigned> halvings() {
    require_levels(false);
    require_levels(true);
    for (std::size_t k = 0; k < format_.channel_count; ++k) require_checksum(k);
    return system_.independent();
  }

 private:
  // What is at a place on the line.
  struct Place {
    enum class Kind : std::uint8_t { constant, data, crc };
    Kind kind = Kind::constant;
    bool level = false;
    std::uint8_t channel = 0;
    std::uint8_t shift = 0;
  };

  constexpr void prepare(std::size_t k) {
    const ChannelFormat& channel = format_.channel_list[k];
    const std::uint64_t flags = channel.error.placed(!channel.error.active_high) |
                                channel.warning.placed(!channel.warning.active_high);
    std::uint64_t random = channel.position.placed(~std::uint64_t{0}) |
                           channel.multiturn.placed(~std::uint64_t{0}) |
                           channel.singleturn.placed(~std::uint64_t{0}) |
                           channel.life_counter.placed(~std::uint64_t{0});
    if (!model_.healthy_flags) random |= flags;
    system_.know(k, ~random, channel.error.placed(true) | channel.warning.placed(true));
    if (!channel.crc.present()) return;
    const CrcBitwise crc(channel.crc);
    constant_[k] = crc(0, channel.data_bits);
    for (unsigned shift = 0; shift < channel.data_bits; ++shift) {
      column_[k][shift] = static_cast<std::uint16_t>(
          crc(std::uint64_t{1} << shift, channel.data_bits) ^ constant_[k]);
    }
  }

  constexpr Place place(int at) const {
    if (at < 0) return {.level = at < -int{slip_.ack_clocks}};
    if (at < 2) return {.level = at == 0 || model_.cds};
    auto behind = static_cast<unsigned>(at) - 2U;
    if (behind >= payload_bits_) return {};
    std::uint8_t k = 0;
    while (behind >= format_.channel_list[k].total_bits()) {
      behind -= format_.channel_list[k++].total_bits();
    }
    const ChannelFormat& channel = format_.channel_list[k];
    if (behind < channel.data_bits) return origin(k, channel.data_bits - 1U - behind);
    return {Place::Kind::crc, false, k,
            static_cast<std::uint8_t>(channel.total_bits() - 1U - behind)};
  }

  // Where a data bit is decided: here, or in the first channel.
  constexpr Place origin(std::uint8_t k, unsigned shift) const {
    const Field& first = format_.channel_list[0].position;
    const Field& field = format_.channel_list[k].position;
    // Both positions as fractions: distance from the top bit.
    const unsigned from_top = unsigned{field.shift} + field.bits - 1U - shift;
    if (model_.aligned_words && shift >= field.shift &&
        from_top < std::min(first.bits, field.bits)) {
      k = 0;
      shift = unsigned{first.shift} + first.bits - 1U - from_top;
    }
    return {Place::Kind::data, false, k, static_cast<std::uint8_t>(shift)};
  }

  constexpr Bit bit_of(const Place& place) const {
    Bit bit;
    if (place.kind == Place::Kind::constant) {
      bit.one = place.level;
    } else if (place.kind == Place::Kind::data) {
      bit.data[place.channel] = std::uint64_t{1} << place.shift;
    } else {
      bit.one = ((constant_[place.channel] >> place.shift) & 1U) != 0;
      for (unsigned i = 0; i < format_.channel_list[place.channel].data_bits; ++i) {
        const Place part = origin(place.channel, i);
        const std::uint64_t used = (std::uint32_t{column_[place.channel][i]} >> place.shift) & 1U;
        bit.data[part.channel] ^= used << part.shift;
      }
    }
    return bit;
  }

  // The levels that the reader must see. First those of data bits, then, because they make rows,
  // those of all others.
  constexpr void require_levels(bool others) {
    for (int at = 1; at <= slip_.place; ++at) {
      require(at, at <= int{slip_.ones_clocks} || at == slip_.place, others);
    }
    const int payload = slip_.place + 2;
    if (format_.cds0) require(slip_.place + 1, false, others);
    int error_at = payload;
    for (const ChannelFormat& channel : format_.channels()) {
      if (model_.trusted_only && channel.error.present) {
        require(error_at + channel.data_bits - 1 - channel.error.shift, !channel.error.active_high,
                others);
      }
      error_at += static_cast<int>(channel.total_bits());
    }
    const int stop = payload + static_cast<int>(payload_bits_);
    require(stop, false, others);
    const int line_end = 2 + static_cast<int>(payload_bits_);
    for (int at = stop + 1; model_.tail_checked && at < line_end; ++at) require(at, false, others);
  }

  constexpr void require(int at, bool level, bool others) {
    const Place where = place(at);
    if ((where.kind != Place::Kind::data) != others) return;
    if (!others) {
      system_.require_data(where.channel, std::uint64_t{1} << where.shift, level);
      return;
    }
    Bit bit = bit_of(where);
    if (level) bit.one = !bit.one;
    system_.require_zero(bit);
  }

  // The CRC of the data that is read equals the CRC that is read.
  constexpr void require_checksum(std::size_t k) {
    const ChannelFormat& channel = format_.channel_list[k];
    if (!channel.crc.present()) return;
    std::array<Bit, max_crc_bits> difference{};
    int at = slip_.place + 2;
    for (std::size_t i = 0; i < k; ++i)
      at += static_cast<int>(format_.channel_list[i].total_bits());
    for (unsigned shift = channel.data_bits; shift-- > 0;) {
      const Bit bit = bit_of(place(at++));
      for (unsigned j = 0; j < channel.crc.width_bits; ++j) {
        if (((column_[k][shift] >> j) & 1U) != 0) difference[j] ^= bit;
      }
    }
    for (unsigned j = channel.crc.width_bits; j-- > 0;) {
      difference[j] ^= bit_of(place(at++));
      if (((constant_[k] >> j) & 1U) != 0) difference[j].one = !difference[j].one;
      system_.require_zero(difference[j]);
    }
  }

  const FrameFormat& format_;
  Slip slip_;
  SlipModel model_;
  unsigned payload_bits_;
  AffineSystem<Channels> system_;
  std::array<std::array<std::uint16_t, max_data_bits>, Channels> column_{};
  std::array<std::uint16_t, Channels> constant_{};
};

}  // namespace frame_detail

/// The share of data words that are accepted with this slip, as the number of halvings: 0 is all of
/// them, 3 is one in 8. Enough clocks are assumed to reach the slipped frame's STOP. A word that
/// passes is counted even if the slipped position happens to be the right one (all bits 1, say).
///
/// `Channels` bounds the working memory, all of it on the stack: 1.1 KiB for 1, 21 KiB for 8.
/// \pre format has 1…Channels channels; ones_clocks is 0 or less than place - 1
/// \return nothing when no word passes
template <std::size_t Channels = max_channels>
constexpr std::optional<unsigned> slip_halvings(const FrameFormat& format, const Slip& slip,
                                                const SlipModel& model = {}) {
  return frame_detail::SlipCount<Channels>(format, slip, model).halvings();
}

/// START is read as 0 and the 1 `distance_clocks` (1…) behind it is taken for START.
/// \return as slip_halvings(): the share of all data words, those whose next 1 is elsewhere
/// included
template <std::size_t Channels = max_channels>
constexpr std::optional<unsigned> lost_start_halvings(const FrameFormat& format,
                                                      unsigned distance_clocks,
                                                      const SlipModel& model = {}) {
  return slip_halvings<Channels>(format, Slip{.place = static_cast<int>(distance_clocks)}, model);
}

/// The ACK bit `early_clocks` (1…) before START is read as 1 and taken for START.
/// \return as slip_halvings()
template <std::size_t Channels = max_channels>
constexpr std::optional<unsigned> early_start_halvings(const FrameFormat& format,
                                                       unsigned early_clocks,
                                                       const SlipModel& model = {}) {
  return slip_halvings<Channels>(format,
                                 Slip{.place = -static_cast<int>(early_clocks),
                                      .ack_clocks = static_cast<std::uint16_t>(early_clocks)},
                                 model);
}

}  // namespace biss
