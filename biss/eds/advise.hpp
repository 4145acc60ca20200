// Advises the frame of a new encoder: data length, CRC and alignment for a resolution, a number of
// turns and a rate, and the BP3 part that describes it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/base/result.hpp"
#include "biss/base/units.hpp"
#include "biss/eds/bank.hpp"
#include "biss/eds/bp3_part.hpp"
#include "biss/eds/profile.hpp"
#include "biss/frame/format.hpp"
#include "biss/timing/cycle.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

/// The requirements on the new encoder.
struct AdviceWish {
  /// Bits of the position within a turn, or along a scale.
  unsigned resolution_bits = 0;
  /// Bits that count turns.
  unsigned turns_bits = 0;
  /// The widths of the fields that the controller expects; 0: as wide as the values. Turns are
  /// right-aligned with leading zeros, the singleturn value is left-aligned with trailing zeros
  /// (BP3, "data alignment").
  unsigned resolution_field_bits = 0;
  unsigned turns_field_bits = 0;
  /// A word of a safety encoder: with C = 1, its CRC counts as data.
  bool in_safety_encoder = false;
  /// Requests per second that are needed; 0 Hz: no requirement.
  Hertz rate{};
  /// The clock to use; 0 Hz: the device's highest.
  Hertz clock{};
  DeviceTiming timing{};
  Picoseconds line_delay{};
};

/// Why nothing can be advised.
enum class AdviceError : std::uint8_t {
  nothing_to_send,  ///< neither resolution nor turns
  field_too_short,  ///< a field that is shorter than its value
  too_long,         ///< position and flags of more than 64 bits, which no data channel carries
  clock_refused,    ///< the device does not accept this clock
};

/// The message for a user, without a full stop.
constexpr std::string_view text_of(AdviceError error) {
  constexpr std::string_view texts[] = {"neither resolution nor turns: there is nothing to send",
                                        "a field is shorter than its value",
                                        "a data channel carries at most 64 bits, two of them flags",
                                        "the device does not accept this clock"};
  return texts[static_cast<std::size_t>(error)];
}

/// The advised frame, and its properties.
struct Advice {
  ChannelFormat channel{};
  /// The profile's identifier, registers 0x42 and 0x43; 0 if the position is too long for BP3.
  std::uint16_t identifier = 0;
  /// The smallest number of wrong bits that the CRC may not detect.
  std::uint8_t hamming_distance = 0;
  /// Zeros before the turns and after the singleturn value.
  std::uint8_t leading_zeros = 0;
  std::uint8_t trailing_zeros = 0;
  /// The cycle at the clock, and whether the rate is feasible.
  CycleBudget budget{};
  bool feasible = true;
  /// The lowest clock that allows the rate; 0 Hz when no clock of the device does, or no rate was
  /// given.
  Hertz clock_needed{};
};

namespace eds_detail {

// Counted over all words of each length; 0x43 has the period 63, 0x190D9 151.
constexpr std::uint8_t hamming_distance(const CrcSpec& crc, unsigned data_bits) {
  if (crc.width_bits == crc6.width_bits) return data_bits <= bp3_max_data_bits ? 3 : 2;
  return data_bits <= 5 ? 8 : data_bits <= 135 ? 6 : 2;
}

// The lowest clock of the device at which the rate is feasible. The cycle grows as the clock falls
// (except for the rounding to whole clocks), so a binary search finds it to the hertz or slightly
// above.
constexpr Hertz lowest_clock(const AdviceWish& wish, const FrameLength& frame) {
  const auto enough = [&](std::uint32_t clock) {
    return is_feasible(cycle_budget(frame, wish.timing, Hertz{clock}, wish.line_delay), wish.rate);
  };
  if (wish.rate.count == 0 || !enough(wish.timing.clock_max.count)) return {};
  std::uint32_t low = wish.timing.clock_min.count;
  std::uint32_t high = wish.timing.clock_max.count;
  if (enough(low)) return Hertz{low};
  while (high - low > 1) {
    const std::uint32_t middle = low + (high - low) / 2;
    (enough(middle) ? high : low) = middle;
  }
  return Hertz{high};
}

// Turns and singleturn without the zeros of their fields.
constexpr void divide(ChannelFormat& channel, const AdviceWish& wish, unsigned resolution) {
  const auto field = [](unsigned shift, unsigned bits) -> Field {
    if (bits == 0) return {};
    return {static_cast<std::uint8_t>(shift), static_cast<std::uint8_t>(bits)};
  };
  const Field low = field(2 + resolution - wish.resolution_bits, wish.resolution_bits);
  channel.position = wish.turns_bits == 0 ? low : Field{};
  channel.singleturn = wish.turns_bits == 0 ? Field{} : low;
  channel.multiturn = field(2 + resolution, wish.turns_bits);
}

}  // namespace eds_detail

/// The frame for a requirement: position, nE and nW with CRC6 up to 57 data bits (the longest word
/// in which it detects every two wrong bits, and BP3's limit), with CRC16 above. The channel
/// describes the line; C = 1, which makes its CRC part of the data, changes only the identifier.
constexpr Result<Advice, AdviceError> advise(const AdviceWish& wish) {
  const unsigned resolution =
      wish.resolution_field_bits != 0 ? wish.resolution_field_bits : wish.resolution_bits;
  const unsigned turns = wish.turns_field_bits != 0 ? wish.turns_field_bits : wish.turns_bits;
  if (wish.resolution_bits == 0 && wish.turns_bits == 0) {
    return failure(AdviceError::nothing_to_send);
  }
  if (resolution < wish.resolution_bits || turns < wish.turns_bits) {
    return failure(AdviceError::field_too_short);
  }
  if (resolution > max_data_bits || turns > max_data_bits ||
      resolution + turns + 2 > max_data_bits) {
    return failure(AdviceError::too_long);
  }
  const Hertz clock = wish.clock.count != 0 ? wish.clock : wish.timing.clock_max;
  if (clock.count == 0 || !accepts_clock(wish.timing, clock)) {
    return failure(AdviceError::clock_refused);
  }
  const bool fits_bp3 = resolution + turns + 2 <= bp3_max_data_bits;
  Advice advice;
  advice.channel = eds_detail::position_channel(turns + resolution, 0, fits_bp3 ? crc6 : crc16);
  const auto identifier = profile_identifier(advice.channel, Profile::bp3, wish.in_safety_encoder);
  if (identifier.ok()) advice.identifier = *identifier;
  eds_detail::divide(advice.channel, wish, resolution);
  advice.hamming_distance =
      eds_detail::hamming_distance(advice.channel.crc, advice.channel.data_bits);
  advice.leading_zeros = static_cast<std::uint8_t>(turns - wish.turns_bits);
  advice.trailing_zeros = static_cast<std::uint8_t>(resolution - wish.resolution_bits);
  const FrameLength frame{.payload_bits = advice.channel.total_bits()};
  advice.budget = cycle_budget(frame, wish.timing, clock, wish.line_delay);
  advice.feasible = is_feasible(advice.budget, wish.rate);
  advice.clock_needed = eds_detail::lowest_clock(wish, frame);
  return advice;
}

/// The BP3 part of an advised frame: identifier, lengths, alignment and counts (the turns if 32
/// bits hold them); all other fields are marked as not given. Rotary; set EN_TYP and the counts for
/// a scale. \pre advice.identifier is not 0
constexpr EdsBank bp3_bank_of(const Advice& advice) {
  const ChannelFormat& channel = advice.channel;
  constexpr unsigned most_bits = 31;  // of one count
  const unsigned turns_bits = channel.multiturn.bits;
  const unsigned resolution_bits = channel.position_bits() - turns_bits;
  Bp3Part part;
  part.bp_id = advice.identifier;
  part.mt_len = static_cast<std::uint8_t>(turns_bits + advice.leading_zeros);
  part.fi_len = static_cast<std::uint8_t>(resolution_bits + advice.trailing_zeros);
  part.fi_fmt = 1;
  if (turns_bits != 0 && turns_bits <= most_bits) part.mt_cnt = std::uint32_t{1} << turns_bits;
  if (resolution_bits != 0) {
    const unsigned fine = resolution_bits < most_bits ? resolution_bits : most_bits;
    part.sip_cnt = std::uint32_t{1} << (resolution_bits - fine);
    part.sip_res = std::uint32_t{1} << fine;
  }
  return sealed(build_bank(part));
}

}  // namespace biss
