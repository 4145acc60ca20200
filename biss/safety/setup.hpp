// SafetySetup: all that a safety monitor needs in addition to the frame's format. Everything that
// the documents leave open is a field here, with a default; docs/safety.md lists them.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "biss/base/units.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"
#include "biss/safety/rating.hpp"
#include "biss/timing/cable.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

/// The values of the 6-bit sign-of-life counter. Open: Renishaw describes a number that is unique
/// within 63 frames, other sources name 0…63.
enum class CounterMode : std::uint8_t {
  count_1_63,  ///< after 63 comes 1; 0 never
  count_0_63,  ///< after 63 comes 0
  learned,     ///< either; start-up lasts until the counter has shown which one
};

/// The names that users see, in the order of CounterMode.
inline constexpr std::array<std::string_view, 3> counter_mode_names{"count_1_63", "count_0_63",
                                                                    "learned"};

/// Whether the encoder counts a request without a good frame. The documents leave this open; it
/// matters only if faults are tolerated.
enum class MissedFrames : std::uint8_t {
  counted,  ///< every one: a damaged frame had its number
  perhaps,  ///< some or none
};

/// How the turns of the two words are compared. Open: the Safety Concept names singleturn bits
/// only.
enum class MultiturnRule : std::uint8_t {
  with_carry,  ///< turns and singleturn are one number, so a carry is one count
  ignored,     ///< the singleturn value alone
};

/// The permitted difference of the two positions.
struct SafetyComparison {
  /// The number of upper bits of the singleturn value (or of the whole position, if there are no
  /// turns) that are compared: ACC_MIN of the Safety Concept. 0: all bits that both words have.
  std::uint8_t compare_bits = 0;
  /// In counts of the lowest bit compared (Safety Concept A5: 1). The difference is measured in the
  /// shorter direction, across the wrap-around if necessary.
  std::uint8_t tolerance_lsb = 1;
  MultiturnRule multiturn = MultiturnRule::with_carry;

  constexpr bool operator==(const SafetyComparison&) const = default;
};

inline constexpr std::uint8_t any_first_value = 0xFF;

/// The expected sign of life.
struct SafetyCounter {
  CounterMode mode = CounterMode::count_1_63;
  MissedFrames missed = MissedFrames::counted;
  /// Up to this many frames ahead is a loss, up to this many back is a wrong order, anything else
  /// is a foreign frame. It changes names only.
  std::uint8_t near_frames = 8;
  /// Learned mode: how often in a row the counter must roll over in the same way.
  std::uint8_t learn_rollovers = 2;
  /// The counter's value in the answer to the first request after the encoder's power-up;
  /// any_first_value: not checked. Open: no document gives it. It detects answers that are delayed
  /// by a constant number of requests since power-up.
  std::uint8_t first = any_first_value;

  constexpr bool operator==(const SafetyCounter&) const = default;
};

/// Faults that are reported but do not end the safe state: at most `faults` in any span of
/// `window`, whether or not a start-up lies within it.
struct SafetyBudget {
  /// 0 (the default): none. At most max_tolerated_faults.
  std::uint8_t faults = 0;
  /// Not shorter than frame_gap_max.
  Picoseconds window{};

  constexpr bool operator==(const SafetyBudget&) const = default;
};

inline constexpr std::uint8_t max_tolerated_faults = 4;

/// Far above any period of MA, and 2^32 bits of it still fit into Picoseconds.
inline constexpr Picoseconds max_bit_period = milliseconds(1);

/// The measures against a wrong time base.
struct SafetyClocks {
  /// How far two clocks may be apart from one good frame to the next, and a transfer's measured
  /// time from its nominal one; from 0 to below frame_gap_max. Open: a 32nd of the cycle, so that a
  /// rate that is more than 3.125 % wrong is a fault.
  Picoseconds tolerance = nanoseconds(31'250) / 32;
  /// How many requests in a row may have the same time as the previous one. The documents leave
  /// this open.
  std::uint8_t still_requests = 0;
  /// The SPI clock's period: a transfer takes this time a bit. 0: the transfer's time is not
  /// checked.
  Picoseconds bit_period{};

  constexpr bool operator==(const SafetyClocks&) const = default;
};

/// Far above any cycle, and small enough for the times of the self test.
inline constexpr Picoseconds max_frame_gap = milliseconds(100'000);

/// The shortest cycle of BiSS Safety: Renishaw's encoders and the fastest types of the Safety
/// Concept. No BiSS Safety encoder with a shorter cycle is known.
inline constexpr Picoseconds safety_cycle = nanoseconds(31'250);

/// The shortest time between two frames whose requests are a cycle apart: a cycle less a 32nd for
/// the clock's error.
constexpr Picoseconds shortest_gap(Picoseconds cycle) { return cycle - cycle / 32; }

struct SafetySetup {
  /// The channels of the two words (Safety Concept A5: CPW first).
  std::uint8_t cpw = 0;
  std::uint8_t spw = 1;
  /// The number of good frames in a row after which a frame is safe; 2 or more, because the counter
  /// is checked from the second frame on. Open.
  std::uint8_t start_frames = 3;
  /// A fault holds until it is acknowledged. Off: good frames alone restore the safe state. Open.
  bool latch = true;
  SafetyComparison comparison{};
  SafetyCounter counter{};
  /// The shortest time from request to request; above 0, at most max_frame_gap.
  Picoseconds cycle_min = safety_cycle;
  /// From one good frame to the next at most; a tolerated fault does not extend it. It must be
  /// shorter than the counter's period times shortest_count(), or the loss of a whole period would
  /// be undetected. Open; see at_cycle().
  Picoseconds frame_gap_max = nanoseconds(46'875);
  /// From one good frame to the next at least. The master must not send requests sooner: frames that
  /// are lost before they reach the monitor have no other measure. 0: not checked, only with an
  /// UnratedSafetySetup. The default is the shortest cycle less the tolerance of the clocks.
  Picoseconds frame_gap_min = shortest_gap(safety_cycle);
  SafetyClocks clocks{};
  SafetyBudget budget{};
  /// The bounds of leading ones and ACK, in clocks. Narrower bounds detect more damaged ACKs.
  FrameBounds bounds{};
  /// For words that safety_ratings does not have.
  SafetyRating rating{};
  /// The most undetected errors an hour, times 1e15, at a bit error rate of 1e-2 and a frame every
  /// frame_gap_min. The default is 1e-9. 1 % of the limit of SIL 2, which Renishaw's encoders are
  /// certified for, is 1e-8 (IEC 61784-3); 1e-9 is 1 % of the limit of SIL 3.
  std::uint64_t residual_max_e15 = 1'000'000;

  constexpr bool operator==(const SafetySetup&) const = default;
};

/// A setup for words that have no rating, or whose rating or comparison is too weak for
/// check_safety(): for experiments, and for encoders that another analysis covers.
struct UnratedSafetySetup : SafetySetup {
  constexpr UnratedSafetySetup() = default;
  constexpr explicit UnratedSafetySetup(const SafetySetup& setup) : SafetySetup(setup) {}

  constexpr bool operator==(const UnratedSafetySetup&) const = default;
};

/// The setup for requests at this interval: the watchdog takes effect after one and a half of them,
/// and a frame is too early by more than a 32nd. From the encoder's shortest cycle to max_frame_gap
/// each interval has a valid setup; a longer one is the mistake `frame_gap`. Call it after
/// with_timing().
constexpr SafetySetup at_cycle(SafetySetup setup, Picoseconds cycle) {
  const Picoseconds possible = std::clamp(cycle, Picoseconds{}, max_frame_gap);
  setup.cycle_min = cycle;
  setup.frame_gap_max = std::min(possible + possible / 2, max_frame_gap);
  setup.frame_gap_min = shortest_gap(cycle);
  setup.clocks.tolerance = possible / 32;
  return setup;
}

/// The setup for an encoder with this timing at this period of MA: the shortest time between
/// requests, and the bounds of leading ones and ACK, in clocks, if SLO is sampled at the rising
/// edges. A clock above the encoder's clock_max is the mistake `bounds`. \pre period is positive
/// \param line_delay_max of the cable and the encoder together, both ways
constexpr SafetySetup with_timing(SafetySetup setup, const DeviceTiming& timing, Picoseconds period,
                                  Picoseconds line_delay_max = biss_line_delay_max) {
  const AckBounds ack = ack_bounds(timing, period);
  setup.bounds.ack_min_clocks = ack.min_clocks;
  setup.bounds.ack_max_clocks = ack.max_clocks;
  // One clock for LAT, one in which SLO falls, and the delay.
  setup.bounds.lead_max_clocks =
      static_cast<std::uint16_t>(2 + clocks_to_cover(line_delay_max, period));
  // No frame is within them.
  if (period < period_of(timing.clock_max)) setup.bounds.lead_max_clocks = 0;
  setup.bounds.late_max_clocks =
      late_clocks(timing, period, line_delay_max, period / 2,
                  unsigned{setup.bounds.lead_min_clocks} + ack.min_clocks);
  if (timing.cycle_min.count != 0) {
    setup.cycle_min = timing.cycle_min;
    setup.frame_gap_min = shortest_gap(timing.cycle_min);
  }
  return setup;
}

/// The frames after which the counter repeats; the smaller number if it is learned.
constexpr unsigned counter_period(CounterMode mode) {
  return mode == CounterMode::count_0_63 ? 64 : 63;
}

/// The shortest time between two counts of the encoder: frame_gap_min, because frames that come
/// sooner are `early`. If an encoder cannot be that fast, it is the encoder's own shortest cycle,
/// less a 32nd: cycle_min, but at most safety_cycle, because no check covers cycle_min.
constexpr Picoseconds shortest_count(const SafetySetup& setup) {
  return std::max(setup.frame_gap_min, shortest_gap(std::min(setup.cycle_min, safety_cycle)));
}

/// Whether a whole period of the counter can be lost within frame_gap_max: the next frame then has
/// the expected value.
constexpr bool may_lose_period(const SafetySetup& setup) {
  // A division, so that any time fits.
  return setup.frame_gap_max / counter_period(setup.counter.mode) >= shortest_count(setup);
}

/// Why frames of a format cannot be monitored with a setup.
enum class SafetySetupError : std::uint8_t {
  channels,      ///< a word is not in the frame, or both are the same channel
  no_crc,        ///< a word has no CRC
  no_error_bit,  ///< a word has no nE
  no_position,   ///< a word has no position
  gray,          ///< a word's position is in Gray code or LSB first: cannot be aligned
  no_counter,    ///< the SPW has no counter of 6 bits
  compare_bits,  ///< more bits to be compared than both words have
  tolerance,     ///< the tolerance accepts every position
  start_frames,  ///< fewer than 2
  counter,       ///< near_frames above 30, no learn_rollovers, or a `first` that cannot occur
  budget,        ///< more than max_tolerated_faults, or too short a window
  frame_gap,     ///< not 0 <= min < max <= max_frame_gap, cycle_min out of range, or
                 ///< may_lose_period()
  clocks,        ///< tolerance not from 0 to below frame_gap_max, or bit_period not from 0 to 1 ms
  bounds,        ///< no frame is within them: a minimum above its maximum or its possible range;
                 ///< a clock above the encoder's limit
  checksum,      ///< the CPW's CRC is not 0x43, or the SPW's is not 0x190D9, or not as in BiSS
  weak_comparison,  ///< fewer than 9 bits compared, or a tolerance above 1
  unrated,          ///< no rating, or one of other words or with a wrong check
  residual,         ///< more undetected errors an hour than residual_max_e15
};

inline constexpr std::size_t safety_setup_error_count = 18;
static_assert(static_cast<std::size_t>(SafetySetupError::residual) + 1U ==
              safety_setup_error_count);

/// The name that users see: the enumerator's name.
constexpr std::string_view name_of(SafetySetupError error) {
  constexpr std::array<std::string_view, safety_setup_error_count> names{
      "channels",     "no_crc",    "no_error_bit", "no_position",     "gray",    "no_counter",
      "compare_bits", "tolerance", "start_frames", "counter",         "budget",  "frame_gap",
      "clocks",       "bounds",    "checksum",     "weak_comparison", "unrated", "residual"};
  return names[static_cast<std::size_t>(error)];
}

namespace safety_detail {

constexpr unsigned singleturn_bits(const ChannelFormat& word) {
  return word.position.present() ? word.position.bits : word.singleturn.bits;
}

/// The alignment of CPW and SPW: singleturn values by their upper bits, turns by their lower ones.
/// Both are numbers of `bits`, whose lower `singleturn_bits` are not turns.
struct Alignment {
  unsigned bits = 0;
  unsigned singleturn_bits = 0;
  unsigned cpw_shift = 0;
  unsigned spw_shift = 0;

  constexpr bool operator==(const Alignment&) const = default;
};

// A distance in counts of the lowest of `bits`, limited to its type.
constexpr std::int32_t held(std::int64_t distance, unsigned bits) {
  constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  if (bits <= 32) return static_cast<std::int32_t>(distance);
  return static_cast<std::int32_t>(std::clamp(distance, -most, most));
}

// \pre compare_bits is at most what both words have
constexpr Alignment alignment_of(const ChannelFormat& cpw, const ChannelFormat& spw,
                                 const SafetyComparison& comparison) {
  const unsigned cpw_bits = singleturn_bits(cpw);
  const unsigned spw_bits = singleturn_bits(spw);
  const unsigned common = std::min(cpw_bits, spw_bits);
  const unsigned compared = comparison.compare_bits == 0 ? common : comparison.compare_bits;
  const unsigned both = std::min(cpw.multiturn.bits, spw.multiturn.bits);
  const unsigned turns = comparison.multiturn == MultiturnRule::ignored ? 0 : both;
  return {turns + compared, compared, cpw_bits - compared, spw_bits - compared};
}

constexpr std::optional<SafetySetupError> check_word(const ChannelFormat& word) {
  if (!word.crc.present()) return SafetySetupError::no_crc;
  if (!word.error.present) return SafetySetupError::no_error_bit;
  if (singleturn_bits(word) == 0) return SafetySetupError::no_position;
  if (word.coded()) return SafetySetupError::gray;
  if (word.crc.deviates()) return SafetySetupError::checksum;
  return std::nullopt;
}

// Whether a number of clocks can be in it: from 1 to `limit`. The monitor takes 0 for 1.
constexpr bool is_range(unsigned least, unsigned most, unsigned limit) {
  return least <= most && most != 0 && least <= limit;
}

constexpr std::optional<SafetySetupError> check_numbers(const SafetySetup& setup) {
  if (setup.start_frames < 2) return SafetySetupError::start_frames;
  const SafetyCounter& counter = setup.counter;
  if (counter.near_frames > 30 || counter.learn_rollovers == 0 ||
      (counter.first != any_first_value && counter.first > 63) ||
      (counter.first == 0 && counter.mode == CounterMode::count_1_63)) {
    return SafetySetupError::counter;
  }
  if (setup.budget.faults > max_tolerated_faults) return SafetySetupError::budget;
  if (setup.budget.faults != 0 && setup.budget.window < setup.frame_gap_max) {
    return SafetySetupError::budget;
  }
  const Picoseconds most = setup.frame_gap_max;
  if (setup.frame_gap_min.count < 0 || setup.frame_gap_min >= most || most > max_frame_gap) {
    return SafetySetupError::frame_gap;
  }
  if (setup.cycle_min.count <= 0 || setup.cycle_min > max_frame_gap || may_lose_period(setup)) {
    return SafetySetupError::frame_gap;
  }
  const SafetyClocks& clocks = setup.clocks;
  if (clocks.tolerance.count < 0 || clocks.tolerance >= most || clocks.bit_period.count < 0 ||
      clocks.bit_period > max_bit_period) {
    return SafetySetupError::clocks;
  }
  const FrameBounds& bounds = setup.bounds;
  constexpr FrameBounds widest;
  if (!is_range(bounds.lead_min_clocks, bounds.lead_max_clocks, widest.lead_max_clocks) ||
      !is_range(bounds.ack_min_clocks, bounds.ack_max_clocks, widest.ack_max_clocks)) {
    return SafetySetupError::bounds;
  }
  return std::nullopt;
}

}  // namespace safety_detail

/// A number that identifies the plan of a monitor: the format, the setup with its rating and limit,
/// and whether it is rated. If one bit of them changes, or several bits of one field, the number
/// changes.
class SafetyFingerprint {
  constexpr void add_word(std::uint64_t word) { sum_.add(word); }
  // At most eight bytes, as they are in memory: a bool may be neither 0 nor 1 after a fault.
  template <class... Bytes>
  constexpr void add(const Bytes&... bytes) {
    std::uint64_t word = 0;
    ((word = (word << 8U) | std::bit_cast<std::uint8_t>(bytes)), ...);
    add_word(word);
  }
  template <class... Bits>
  static constexpr std::uint8_t bits_of(Bits... bits) {
    unsigned sum = 0;
    unsigned next = 1;
    ((sum |= bits ? next : 0U, next <<= 1U), ...);
    return static_cast<std::uint8_t>(sum);
  }
  // The names of all members, here and below, so that a new one does not compile.
  constexpr void add(const ChannelFormat& channel) {
    const auto& [data_bits, position, multiturn, singleturn, pos_gray, mt_gray, gray, pos_lsb,
                 mt_lsb, lsb, error, warning, counter, crc] = channel;
    add(data_bits, position.shift, position.bits, multiturn.shift, multiturn.bits, singleturn.shift,
        singleturn.bits, bits_of(gray, lsb, mt_gray, mt_lsb, pos_gray, pos_lsb));
    add(error.shift, error.present, error.active_high, warning.shift, warning.present,
        warning.active_high, counter.shift, counter.bits);
    add_word(word_of(crc));
  }

  safety_detail::Sum64 sum_;

 public:
  constexpr SafetyFingerprint() = default;
  constexpr SafetyFingerprint(const FrameFormat& format, const SafetySetup& setup)
      : SafetyFingerprint(format, setup, 1) {}
  template <std::derived_from<UnratedSafetySetup> Unrated>
  constexpr SafetyFingerprint(const FrameFormat& format, const Unrated& setup)
      : SafetyFingerprint(format, setup, 0) {}
  /// \param rated as it is in memory: 1, or 0 for an UnratedSafetySetup
  constexpr SafetyFingerprint(const FrameFormat& format, const SafetySetup& setup,
                              std::uint8_t rated) {
    const auto& [channels, channel_count, cds0] = format;
    add(channel_count, cds0);
    // A fault of the memory may have changed the number of channels.
    const std::size_t count = std::min<std::size_t>(channel_count, max_channels);
    for (std::size_t k = 0; k < count; ++k) add(channels[k]);
    const auto& [cpw, spw, start_frames, latch, comparison, counter, cycle_min, frame_gap_max,
                 frame_gap_min, clocks, budget, bounds, rating, residual_max_e15] = setup;
    const auto& [compare_bits, tolerance_lsb, multiturn] = comparison;
    add(cpw, spw, start_frames, latch, compare_bits, tolerance_lsb, multiturn, rated);
    const auto& [mode, missed, near_frames, learn_rollovers, first] = counter;
    const auto& [tolerance, still_requests, bit_period] = clocks;
    const auto& [faults, window] = budget;
    add(mode, missed, near_frames, learn_rollovers, first, still_requests, faults);
    for (const Picoseconds time :
         {cycle_min, frame_gap_max, frame_gap_min, tolerance, bit_period, window}) {
      add_word(static_cast<std::uint64_t>(time.count));
    }
    const auto& [lead_min, lead_max, ack_min, ack_max, late_max] = bounds;
    add_word((std::uint64_t{lead_min} << 48U) | (std::uint64_t{lead_max} << 32U) |
             (std::uint64_t{ack_min} << 16U) | ack_max);
    const auto& [words, residual_e24, check] = rating;
    for (const std::uint64_t word :
         {std::uint64_t{late_max}, words, residual_e24, check, residual_max_e15}) {
      add_word(word);
    }
  }

  /// The fingerprint of two words and of the bits of them that are compared.
  constexpr SafetyFingerprint(const ChannelFormat& cpw, const ChannelFormat& spw,
                              const SafetyComparison& comparison) {
    const auto alignment = safety_detail::alignment_of(cpw, spw, comparison);
    add(cpw);
    add(spw);
    add(static_cast<std::uint8_t>(alignment.bits),
        static_cast<std::uint8_t>(alignment.singleturn_bits), comparison.tolerance_lsb);
  }

  constexpr bool operator==(const SafetyFingerprint&) const = default;
  constexpr std::uint64_t number() const { return sum_.number(); }

  /// All of a checksum's parameters, as they are in memory.
  static constexpr std::uint64_t word_of(const CrcSpec& crc) {
    const auto& [polynomial, start, width_bits, inverted, reversed, no_flags, cds, previous] = crc;
    return (std::uint64_t{polynomial} << 32U) | (std::uint64_t{start} << 16U) |
           (std::uint64_t{width_bits} << 8U) | bits_of(inverted, reversed, no_flags, cds, previous);
  }
};

/// \return the first mistake up to `bounds` in the order of the enumerators; empty if the frames of
///   this format can be monitored
constexpr std::optional<SafetySetupError> check_safety(const FrameFormat& format,
                                                       const UnratedSafetySetup& setup) {
  if (setup.cpw >= format.channel_count || setup.spw >= format.channel_count ||
      setup.cpw == setup.spw) {
    return SafetySetupError::channels;
  }
  const ChannelFormat& cpw = format.channel_list[setup.cpw];
  const ChannelFormat& spw = format.channel_list[setup.spw];
  for (const ChannelFormat* word : {&cpw, &spw}) {
    if (const auto mistake = safety_detail::check_word(*word)) return mistake;
  }
  if (spw.life_counter.bits != safety_counter_bits) return SafetySetupError::no_counter;
  const SafetyComparison& comparison = setup.comparison;
  if (comparison.compare_bits > safety_detail::singleturn_bits(cpw) ||
      comparison.compare_bits > safety_detail::singleturn_bits(spw)) {
    return SafetySetupError::compare_bits;
  }
  const unsigned bits = safety_detail::alignment_of(cpw, spw, comparison).bits;
  if (2U * comparison.tolerance_lsb >= low_mask(bits)) return SafetySetupError::tolerance;
  return safety_detail::check_numbers(setup);
}

/// The words that a rating is for, as a number. \pre both have a position
constexpr std::uint64_t rated_words(const ChannelFormat& cpw, const ChannelFormat& spw,
                                    const SafetyComparison& comparison) {
  return SafetyFingerprint(cpw, spw, comparison).number();
}

namespace safety_detail {

// Safety Concept A5: the CRCs of both words, the smallest ACC_MIN of its types, its tolerance.
inline constexpr std::uint32_t cpw_polynomial = 0x43;
inline constexpr std::uint32_t spw_polynomial = 0x190D9;
inline constexpr unsigned least_compared_bits = 9;
inline constexpr unsigned most_tolerance_lsb = 1;

// The rating of the setup or of the table.
constexpr std::optional<SafetyRating> rating_of(std::uint64_t words, const SafetySetup& setup) {
  const SafetyRating& own = setup.rating;
  if (own.words == words && own.check == rating_check(words, own.residual_e24)) return own;
  for (const SafetyRating& each : safety_ratings) {
    if (each.words == words) return each;
  }
  return std::nullopt;
}

constexpr bool is_within_residual(const SafetyRating& rating, const SafetySetup& setup) {
  constexpr std::int64_t hour = 3'600 * picoseconds_per_second;
  constexpr std::uint64_t e15_to_e24 = 1'000'000'000;
  if (setup.frame_gap_min.count <= 0) return false;
  const auto frames = static_cast<std::uint64_t>(hour / setup.frame_gap_min.count) + 1U;
  constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max() / e15_to_e24;
  const std::uint64_t limit = std::min(setup.residual_max_e15, most) * e15_to_e24;
  return rating.residual_e24 <= limit / frames;
}

}  // namespace safety_detail

/// \return the first mistake in the order of the enumerators; empty if the frames of this format
///   can be monitored, with the CRCs and the comparison that the Safety Concept demands and at most
///   residual_max_e15 undetected errors
constexpr std::optional<SafetySetupError> check_safety(const FrameFormat& format,
                                                       const SafetySetup& setup) {
  if (const auto mistake = check_safety(format, UnratedSafetySetup(setup))) return mistake;
  const ChannelFormat& cpw = format.channel_list[setup.cpw];
  const ChannelFormat& spw = format.channel_list[setup.spw];
  if (cpw.crc.polynomial != safety_detail::cpw_polynomial ||
      spw.crc.polynomial != safety_detail::spw_polynomial) {
    return SafetySetupError::checksum;
  }
  const auto alignment = safety_detail::alignment_of(cpw, spw, setup.comparison);
  if (alignment.singleturn_bits < safety_detail::least_compared_bits ||
      setup.comparison.tolerance_lsb > safety_detail::most_tolerance_lsb) {
    return SafetySetupError::weak_comparison;
  }
  const auto rating = safety_detail::rating_of(rated_words(cpw, spw, setup.comparison), setup);
  if (!rating) return SafetySetupError::unrated;
  if (!safety_detail::is_within_residual(*rating, setup)) return SafetySetupError::residual;
  return std::nullopt;
}

/// The position in the SPW when the CPW has this one: the same place in the SPW's counts. Turns and
/// singleturn bits that the CPW does not have are 0.
constexpr std::uint64_t spw_position(const ChannelFormat& cpw, const ChannelFormat& spw,
                                     std::uint64_t position) {
  const unsigned from = safety_detail::singleturn_bits(cpw);
  const unsigned to = safety_detail::singleturn_bits(spw);
  const std::uint64_t aligned = from >= to ? position >> (from - to) : position << (to - from);
  return aligned & low_mask(spw.position_bits());
}

}  // namespace biss
