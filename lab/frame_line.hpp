// The bits of a frame on the line as XORs of its data bits, and the checks of a reader.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "biss/frame/format.hpp"
#include "lab/equations.hpp"
#include "lab/pair.hpp"

namespace biss::lab {

/// Unknown bit k * max_data_bits + shift is a data bit of channel k.
inline constexpr std::size_t line_unknowns = max_channels * max_data_bits;
using LineBit = LinearBit<line_unknowns>;
using LineEquations = Equations<line_unknowns>;
using LinearBits = std::vector<LineBit>;

inline LineBit level_bit(bool level) { return LineBit().set(line_unknowns, level); }

inline std::uint64_t position_mask(const ChannelFormat& channel) {
  return channel.position.placed(~std::uint64_t{0}) | channel.multiturn.placed(~std::uint64_t{0}) |
         channel.singleturn.placed(~std::uint64_t{0});
}

/// The checksum of data bits, the first bit first.
inline LinearBits checksum_of(const CrcSpec& spec, const LineBit* data, unsigned data_bits) {
  LinearBits reg(spec.width_bits);  // [i] is the bit of x^i
  for (unsigned i = 0; i < spec.width_bits; ++i) reg[i] = level_bit(((spec.start >> i) & 1U) != 0);
  for (unsigned k = 0; k < data_bits; ++k) {
    const LineBit feedback = reg.back() ^ data[k];
    for (std::size_t i = reg.size(); i-- > 1;) reg[i] = reg[i - 1];
    reg[0].reset();
    for (unsigned i = 0; i < spec.width_bits; ++i) {
      if (((spec.polynomial >> i) & 1U) != 0) reg[i] ^= feedback;
    }
  }
  std::reverse(reg.begin(), reg.end());
  for (LineBit& bit : reg) bit ^= level_bit(spec.inverted);
  return reg;
}

/// How the encoder sends a frame.
struct Sending {
  bool cds = false;
  bool healthy_flags = true;
  /// The first channels: their positions are the upper bits of the first channel's position.
  std::size_t aligned_channels = 1;
  /// Bits of their positions that the first channel's position does not have: evenly distributed,
  /// or 0.
  bool extra_bits = true;
};

/// The bits of a frame, and the checks of a reader that reads some other bits.
class FrameLine {
 public:
  FrameLine(const FrameFormat& format, const Sending& sending)
      : format_(format), sending_(sending), frame_bits_(format.payload_bits() + 3) {
    sent_.push_back(level_bit(true));
    sent_.push_back(level_bit(sending.cds));
    for (std::size_t k = 0; k < format.channel_count; ++k) send(k);
  }

  /// START, CDS, payload, STOP.
  unsigned frame_bits() const { return frame_bits_; }

  /// The line is low before START and after STOP.
  LineBit sent(int place) const {
    if (place < 0) return level_bit(false);
    const auto at = static_cast<std::size_t>(place);
    return at < sent_.size() ? sent_[at] : level_bit(false);
  }

  void require_structure(LineEquations& equations, const LinearBits& seen) const {
    if (format_.cds0) equations.require(seen[1], false);
    equations.require(seen.back(), false);
  }

  void require_checksum(LineEquations& equations, const LinearBits& seen, std::size_t k) const {
    const ChannelFormat& channel = format_.channel_list[k];
    if (!channel.crc.present()) return;
    std::size_t at = starts_[k] + channel.data_bits;
    for (const LineBit& bit : checksum_of(channel.crc, &seen[starts_[k]], channel.data_bits)) {
      equations.require_zero(bit ^ seen[at++]);
    }
  }

  void require_word_as_sent(LineEquations& equations, const LinearBits& seen, std::size_t k) const {
    for (unsigned bit = 0; bit < format_.channel_list[k].total_bits(); ++bit) {
      equations.require_zero(seen[starts_[k] + bit] ^ sent_[starts_[k] + bit]);
    }
  }

  void require_no_error(LineEquations& equations, const LinearBits& seen) const {
    for (std::size_t k = 0; k < format_.channel_count; ++k) {
      const FlagField& error = format_.channel_list[k].error;
      if (error.present) equations.require(seen[place_of(k, error.shift)], !error.active_high);
    }
  }

  void require_as_sent(LineEquations& equations, const LinearBits& seen, std::size_t k,
                       std::uint64_t mask) const {
    for (unsigned shift = 0; shift < max_data_bits; ++shift) {
      if (((mask >> shift) & 1U) == 0) continue;
      const std::size_t at = place_of(k, shift);
      equations.require_zero(seen[at] ^ sent_[at]);
    }
  }

  /// The place of a data bit in the frame.
  std::size_t place_of(std::size_t k, unsigned shift) const {
    return starts_[k] + format_.channel_list[k].data_bits - 1U - shift;
  }

 private:
  void send(std::size_t k) {
    const ChannelFormat& channel = format_.channel_list[k];
    const std::size_t first = sent_.size();
    starts_[k] = first;
    std::vector<ComparedBit> aligned;
    std::uint64_t random = position_mask(channel) | channel.life_counter.placed(~std::uint64_t{0});
    if (k != 0 && k < sending_.aligned_channels) {
      aligned = compared_bits(format_.channel_list[0], channel);
      if (!sending_.extra_bits) random &= ~position_mask(channel);
      for (const ComparedBit& bit : aligned) random |= std::uint64_t{1} << bit.safety_shift;
    }
    if (!sending_.healthy_flags) {
      random |= channel.error.placed(!channel.error.active_high) |
                channel.warning.placed(!channel.warning.active_high);
    }
    const std::uint64_t flags = channel.error.placed(true) | channel.warning.placed(true);
    for (unsigned shift = channel.data_bits; shift-- > 0;) {
      const bool is_random = ((random >> shift) & 1U) != 0;
      LineBit bit = level_bit(!is_random && ((flags >> shift) & 1U) != 0);
      if (is_random) bit[unknown(k, shift, aligned)] = true;
      sent_.push_back(bit);
    }
    if (!channel.crc.present()) return;
    for (const LineBit& bit : checksum_of(channel.crc, &sent_[first], channel.data_bits)) {
      sent_.push_back(bit);
    }
  }

  static std::size_t unknown(std::size_t k, unsigned shift,
                             const std::vector<ComparedBit>& aligned) {
    for (const ComparedBit& bit : aligned) {
      if (bit.safety_shift == shift) return bit.control_shift;
    }
    return k * max_data_bits + shift;
  }

  const FrameFormat& format_;
  Sending sending_;
  unsigned frame_bits_;
  std::array<std::size_t, max_channels> starts_{};
  LinearBits sent_;
};

}  // namespace biss::lab
