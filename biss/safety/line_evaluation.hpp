// The second of a frame's two evaluations: straight off the line, by other means than the first
// wherever there are any.
#pragma once

#include <cstddef>
#include <cstdint>

#include "biss/base/bits.hpp"
#include "biss/safety/judgement.hpp"
#include "biss/safety/line_reader.hpp"
#include "biss/safety/plan.hpp"

namespace biss {

/// Fields by their places from the front, CRCs bit by bit as a long division, the comparison with
/// both positions moved to the top of a word, the counter stepped on from a copy of its own.
template <class Plan>
class LineEvaluation {
 public:
  constexpr explicit LineEvaluation(const SafetySetup&) {}

  /// \param bits SLO once a MA clock, as for find_start()
  static constexpr SafetyFinding find(const Plan& plan, const BitView& bits) {
    SafetyFinding finding;
    safety_detail::LineReader line(bits);
    if (!is_at_payload(line, plan.setup().bounds)) return finding;
    const FrameFormat& format = plan.format();
    if (line.left() < format.payload_bits() + 1U) return finding;
    if ((line.take(1) != 0) && format.cds0) return finding;
    const SafetySetup& setup = plan.setup();
    std::uint64_t cpw = 0;
    std::uint64_t spw = 0;
    for (unsigned k = 0; k < format.channel_count; ++k) {
      std::uint64_t data = 0;
      if (!take_channel(line, format.channel_list[k], data)) {
        if (k == setup.cpw) finding.cause = SafetyVerdict::cpw_crc;
        if (k == setup.spw) finding.cause = SafetyVerdict::spw_crc;
        return finding;
      }
      if (k == setup.cpw) cpw = data;
      if (k == setup.spw) spw = data;
    }
    if (line.left() != 0 && line.take(1) != 0) return finding;
    fill(finding, plan, cpw, spw);
    return finding;
  }

  /// Whether the counter may have this value. \param mode none while it is being learned
  constexpr bool counter_follows(std::uint8_t value, unsigned missed,
                                 std::optional<CounterMode> mode, MissedFrames rule) const {
    const bool without_zero = mode == CounterMode::count_1_63;
    if (!begun_) return !(without_zero && value == 0);
    auto next = static_cast<std::uint8_t>(~complement_);
    bool follows = false;
    for (unsigned step = 0; step <= missed; ++step) {
      const bool wraps = next == 63;
      next = wraps ? (without_zero ? 1 : 0) : static_cast<std::uint8_t>(next + 1U);
      const bool counts = step == missed || rule == MissedFrames::perhaps;
      if (counts && (value == next || (wraps && !mode && value == 1))) follows = true;
    }
    return follows;
  }
  constexpr void accept_counter(std::uint8_t value) {
    complement_ = static_cast<std::uint8_t>(~value);
    begun_ = true;
  }
  constexpr void lose_place() { begun_ = false; }

 private:
  // Zeros that are late, ones, the zeros of ACK, START.
  static constexpr bool is_at_payload(safety_detail::LineReader& line, const FrameBounds& bounds) {
    if (!line.skip_to(true) || line.at() > bounds.late_max_clocks) return false;
    if (!line.skip_to(false)) return false;
    const std::size_t ack = line.at();
    if (ack < bounds.lead_min_clocks || ack > bounds.lead_max_clocks) return false;
    if (!line.skip_to(true)) return false;
    const std::size_t zeros = line.at() - ack;
    line.take(1);
    return zeros >= bounds.ack_min_clocks && zeros <= bounds.ack_max_clocks;
  }

  // The remainder of register and data, which lie at the top of the word, after `count` bits.
  static constexpr std::uint32_t divided(std::uint32_t word, unsigned count,
                                         std::uint32_t polynomial) {
    const auto step = [&] { word = (word << 1U) ^ (polynomial & (0U - (word >> 31U))); };
    for (; count >= 4; count -= 4) {
      step();
      step();
      step();
      step();
    }
    for (; count != 0; --count) step();
    return word;
  }

  // The data at the top of a word; false: its CRC is wrong.
  static constexpr bool take_channel(safety_detail::LineReader& line, const ChannelFormat& channel,
                                     std::uint64_t& data) {
    const unsigned upper = channel.data_bits < 32 ? channel.data_bits : 32;
    const std::uint32_t high = line.take(upper);
    const std::uint32_t low = channel.data_bits > 32 ? line.take(channel.data_bits - 32U) : 0;
    data = (std::uint64_t{high} << 32U) | low;
    const CrcSpec& crc = channel.crc;
    if (!crc.present()) return true;
    const unsigned unused = 32U - crc.width_bits;
    const std::uint32_t polynomial = crc.polynomial << unused;
    std::uint32_t rest = divided(high ^ (std::uint32_t{crc.start} << unused), upper, polynomial);
    if (channel.data_bits > 32) rest = divided(rest ^ low, channel.data_bits - 32U, polynomial);
    const std::uint32_t sent = line.take(crc.width_bits);
    return (rest ^ sent) == (crc.inverted ? ~0U << unused : 0U);
  }

  static constexpr std::uint64_t value(const ChannelFormat& channel, const Field& field,
                                       std::uint64_t data) {
    const unsigned front = unsigned{channel.data_bits} - field.shift - field.bits;
    return field.present() ? data << front >> (64U - field.bits) : 0;
  }
  static constexpr bool level(const ChannelFormat& channel, const FlagField& flag,
                              std::uint64_t data) {
    if (!flag.present) return true;
    const std::uint64_t at = std::uint64_t{1} << 63U >> (channel.data_bits - 1U - flag.shift);
    return ((data & at) != 0) == !flag.active_high;
  }

  // Turns, and below them the upper singleturn bits, at the top of a word.
  static constexpr std::uint64_t key(const ChannelFormat& word, std::uint64_t data,
                                     const safety_detail::Alignment& alignment) {
    const Field& field = word.position.present() ? word.position : word.singleturn;
    const unsigned turns = alignment.bits - alignment.singleturn_bits;
    std::uint64_t top = data << (unsigned{word.data_bits} - field.shift - field.bits);
    top = top >> (64U - alignment.singleturn_bits) << (64U - alignment.singleturn_bits) >> turns;
    if (turns != 0) top |= value(word, word.multiturn, data) << (64U - turns);
    return top;
  }

  static constexpr std::uint64_t position(const ChannelFormat& word, std::uint64_t data) {
    if (word.position.present()) return value(word, word.position, data);
    const std::uint64_t turns = value(word, word.multiturn, data);
    return turns << word.singleturn.bits | value(word, word.singleturn, data);
  }

  static constexpr void fill(SafetyFinding& finding, const Plan& plan, std::uint64_t cpw_data,
                             std::uint64_t spw_data) {
    const SafetySetup& setup = plan.setup();
    const ChannelFormat& cpw = plan.format().channel_list[setup.cpw];
    const ChannelFormat& spw = plan.format().channel_list[setup.spw];
    const safety_detail::Alignment& alignment = plan.alignment();
    finding.position = position(cpw, cpw_data);
    finding.life_counter = static_cast<std::uint8_t>(value(spw, spw.life_counter, spw_data));
    finding.cpw_nW = level(cpw, cpw.warning, cpw_data);
    finding.spw_nW = level(spw, spw.warning, spw_data);
    const unsigned unused = 64U - alignment.bits;
    const auto apart =
        static_cast<std::int64_t>(key(cpw, cpw_data, alignment) - key(spw, spw_data, alignment));
    finding.difference_lsb = apart >> unused;
    const std::int64_t limit = std::int64_t{setup.comparison.tolerance_lsb} << unused;
    const bool near = apart <= limit && apart >= -limit;
    finding.cause = near ? SafetyVerdict::safe : SafetyVerdict::comparison;
    if (!level(spw, spw.error, spw_data)) finding.cause = SafetyVerdict::spw_error;
    if (!level(cpw, cpw.error, cpw_data)) finding.cause = SafetyVerdict::cpw_error;
  }

  std::uint8_t complement_ = 0;
  bool begun_ = false;
};

}  // namespace biss
