// Reads BiSS frames from the bytes that an SPI peripheral received.
//
// MA is the SPI clock, idle high (CPOL = 1); SLO is its data input, most significant bit first.
// Both clock phases work. T is the period, d the delay from MA at the master to SLO at the master:
//
//          0       1       2       3       4       5      clock
//   MA  ‾‾‾\___/‾‾‾\___/‾‾‾\___/‾‾‾\___/‾‾‾\___/‾‾‾
//              :LAT    :ACK    :START  :CDS           the encoder changes SLO, here d = T / 4
//   SLO ‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾\_______/‾‾‾‾‾‾‾X=======X
//              ^       ^       ^       ^       ^      sample_on_rising  (CPHA = 1, mode 3)
//              1       1       0       1   …
//          ^       ^       ^       ^       ^          sample_on_falling (CPHA = 0, mode 2)
//          1       1       0       1   …
//
// Sample k is taken at rising edge k, or at falling edge k half a period earlier. It shows what the
// encoder sent at rising edge j, the last edge whose change had arrived. Edge 0 is LAT, edge 1 is
// ACK, so the leading ones end with the first sample that shows edge 1:
//
//   rising    ones = 2 + floor(d / T)            2 for any delay below a period
//   falling   ones = 2 + floor(d / T + 1 / 2)    2 below half a period, 3 below one and a half, …
//
// A change that arrives at the moment of sampling may be seen or not; the bounds allow both. An
// encoder with a fixed cycle time (TimeoutRule::cycle) may be requested again as soon as that time
// is over. SLO, a line delay later, is then still low from the previous cycle: the first samples up
// to the one at d are zeros, and ones follow up to the usual sample.
//
// DMA feeds the peripheral, so that the clock runs without a gap from the first to the last bit.
// Without DMA, SpiSetup::max_pause is the longest gap; polled_read.hpp makes the bytes. Then no bit
// may be on its way while MA rests, because the samples after the pause would miss it: the delay is
// less than one period (half a period in mode 2), and the ones are always 2.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include "biss/base/bits.hpp"
#include "biss/base/result.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"
#include "biss/timing/cable.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

// ---- The setup of the peripheral, and the bits that follow from it

/// The edge of MA at which the peripheral samples; MA is high while idle.
enum class SpiPhase : std::uint8_t {
  sample_on_rising,   ///< CPHA = 1, SPI mode 3
  sample_on_falling,  ///< CPHA = 0, SPI mode 2: half a period less for line and encoder
};

/// The meaning of a 1 after STOP. The encoder keeps SLO low until its timeout, which does not
/// expire while MA runs (except with TimeoutRule::cycle, whose end is respected).
enum class SpiTail : std::uint8_t {
  must_stay_low,  ///< stop_bit: START was taken too early, and the 1 belongs to the rest of the
                  ///< frame
  ignored,        ///< for encoders that release SLO early
};

/// The delay from MA to SLO, both at the master: cable in both directions, drivers, the encoder.
struct LineDelayRange {
  Picoseconds min{};
  Picoseconds max = biss_line_delay_max;

  constexpr bool operator==(const LineDelayRange&) const = default;
};

/// The setup of the peripheral. The narrower the line delay's range, the more wrong frames are
/// detected.
struct SpiSetup {
  /// Period of MA; positive.
  Picoseconds period{};
  SpiPhase phase = SpiPhase::sample_on_rising;
  LineDelayRange line_delay{};
  /// Bits in the buffer before the sample of the first clock, for a peripheral that inserts
  /// padding.
  std::uint16_t first_bit = 0;
  SpiTail tail = SpiTail::must_stay_low;
  /// Reads positions without nE too. trusted() is then true for every good frame: this encoder
  /// cannot report that its position is wrong, and a word of zeros is position 0.
  bool no_error_flag = false;
  /// Reads channels without CRC too. A disturbed channel then counts as good.
  bool unchecked = false;
  /// The longest time from one edge of MA to the next, if MA pauses between bytes or is made by
  /// software. Shorter than shortest_timeout() of the encoder. 0: MA never pauses (DMA).
  Picoseconds max_pause{};
  /// Pauses although the encoder's data sheet demands a constant clock
  /// (DeviceTiming::clock_constant). The effect of a pause is then not known.
  bool pause_anyway = false;

  constexpr bool operator==(const SpiSetup&) const = default;
};

/// Why there is no reader for a setup: the first cause that applies.
enum class SpiSetupError : std::uint8_t {
  period,          ///< it is not positive
  line_delay,      ///< it is negative, or its minimum is above its maximum
  clock,           ///< it is above the encoder's clock_max
  error_flag,      ///< a position has no nE, and the setup does not have no_error_flag
  crc,             ///< a channel has no CRC, and the setup does not have unchecked
  previous,        ///< a channel's CRC belongs to the previous frame: one frame cannot be checked
  pause,           ///< max_pause is below half a period, or not below shortest_timeout()
  pause_delay,     ///< the line delay is too long for pauses: bits would be on their way in a pause
  clock_constant,  ///< the encoder permits no pause, and the setup does not have pause_anyway
  time_step,       ///< of a PolledClock: it is negative, or two of them do not fit in max_pause
};

/// The message for users.
constexpr std::string_view text_of(SpiSetupError error) {
  constexpr std::string_view texts[] = {
      "the period is not positive",
      "the line delay is not 0 <= min <= max",
      "the clock is above the limit of the encoder",
      "a position has no nE: set no_error_flag to read it",
      "a channel has no CRC: set unchecked to read it",
      "a CRC belongs to the previous frame (:previous): one frame cannot be checked",
      "the longest pause of MA is not half a period or more and below the encoder's timeout",
      "the line delay is too long for pauses of MA: use a lower clock",
      "the encoder permits no pause of MA: set pause_anyway to try it",
      "the step of the clock is negative, or too long for the longest pause of MA"};
  return texts[static_cast<std::size_t>(error)];
}

constexpr FrameBounds spi_bounds(const SpiSetup& setup, const DeviceTiming& timing);

/// Returns why MA cannot pause in this setup: period, line_delay or one of the last three causes;
/// nothing if it can, or if it does not.
constexpr std::optional<SpiSetupError> check_pause(const SpiSetup& setup,
                                                   const DeviceTiming& timing) {
  if (setup.period.count <= 0) return SpiSetupError::period;
  if (setup.line_delay.min.count < 0 || setup.line_delay.min > setup.line_delay.max) {
    return SpiSetupError::line_delay;
  }
  if (setup.max_pause.count == 0) return std::nullopt;
  if (setup.max_pause < setup.period / 2 ||
      setup.max_pause >= shortest_timeout(timing.timeout, setup.period)) {
    return SpiSetupError::pause;
  }
  if (spi_bounds(setup, timing).lead_max_clocks != 2) return SpiSetupError::pause_delay;
  if (timing.clock_constant && !setup.pause_anyway) return SpiSetupError::clock_constant;
  return std::nullopt;
}

/// Returns why this setup cannot read this format of this device; nothing if it can.
constexpr std::optional<SpiSetupError> check_spi(const FrameFormat& format, const SpiSetup& setup,
                                                 const DeviceTiming& timing) {
  const auto pause = check_pause(setup, timing);
  if (pause && *pause <= SpiSetupError::line_delay) return pause;
  if (setup.period < period_of(timing.clock_max)) return SpiSetupError::clock;
  for (const ChannelFormat& channel : format.channels()) {
    const bool flagged = channel.position_bits() == 0 || channel.error.present;
    if (!flagged && !setup.no_error_flag) return SpiSetupError::error_flag;
    if (!channel.crc.present() && !setup.unchecked) return SpiSetupError::crc;
    if (channel.crc.of_previous) return SpiSetupError::previous;
  }
  return pause;
}

namespace spi_detail {

// Not constexpr: the compiler prints the name of the function that a constant reader calls.
inline void the_period_is_not_positive() {}
inline void the_line_delay_is_negative_or_its_minimum_above_its_maximum() {}
inline void the_clock_is_above_the_encoders_clock_max() {}
inline void a_position_has_no_nE_and_the_setup_no_word_no_error_flag() {}
inline void a_channel_has_no_crc_and_the_setup_no_word_unchecked() {}
inline void a_crc_is_that_of_the_frame_before() {}
inline void max_pause_is_below_half_a_period_or_not_below_shortest_timeout() {}
inline void the_line_delay_is_too_long_for_pauses() {}
inline void the_encoder_permits_no_pause_and_the_setup_has_no_word_pause_anyway() {}
inline void time_step_is_negative_or_too_long_for_max_pause() {}

constexpr void stop_the_build(SpiSetupError error) {
  switch (error) {
    case SpiSetupError::period:
      return the_period_is_not_positive();
    case SpiSetupError::line_delay:
      return the_line_delay_is_negative_or_its_minimum_above_its_maximum();
    case SpiSetupError::clock:
      return the_clock_is_above_the_encoders_clock_max();
    case SpiSetupError::error_flag:
      return a_position_has_no_nE_and_the_setup_no_word_no_error_flag();
    case SpiSetupError::crc:
      return a_channel_has_no_crc_and_the_setup_no_word_unchecked();
    case SpiSetupError::previous:
      return a_crc_is_that_of_the_frame_before();
    case SpiSetupError::pause:
      return max_pause_is_below_half_a_period_or_not_below_shortest_timeout();
    case SpiSetupError::pause_delay:
      return the_line_delay_is_too_long_for_pauses();
    case SpiSetupError::clock_constant:
      return the_encoder_permits_no_pause_and_the_setup_has_no_word_pause_anyway();
    case SpiSetupError::time_step:
      return time_step_is_negative_or_too_long_for_max_pause();
  }
}

// No frame is within them.
inline constexpr FrameBounds no_bounds{.lead_min_clocks = std::numeric_limits<std::uint16_t>::max(),
                                       .lead_max_clocks = 0};

// The longest clock: MA may pause at both levels.
constexpr Picoseconds longest_clock(const SpiSetup& setup) {
  return std::max(setup.period, 2 * setup.max_pause);
}

}  // namespace spi_detail

/// The bounds of the bits before the data: leading ones for this phase and line delay, ACK for this
/// device, and zeros of the previous cycle if the device is ready after a fixed time. With pauses of
/// MA, ACK may have fewer clocks for the same time.
/// \pre period is positive, line_delay.min <= line_delay.max, neither is negative
constexpr FrameBounds spi_bounds(const SpiSetup& setup, const DeviceTiming& timing) {
  constexpr std::int64_t most = FrameBounds{}.lead_max_clocks;
  const bool falling = setup.phase == SpiPhase::sample_on_falling;
  const Picoseconds early = falling ? setup.period / 2 : Picoseconds{};
  const std::int64_t longest =
      std::min(2 + (setup.line_delay.max + early).count / setup.period.count, most);
  const std::int64_t shortest = std::clamp<std::int64_t>(
      1 + clocks_to_cover(setup.line_delay.min + early, setup.period), 2, longest);
  const AckBounds ack = ack_bounds(timing, setup.period);
  const std::uint16_t ack_min = ack_bounds(timing, spi_detail::longest_clock(setup)).min_clocks;
  return {.lead_min_clocks = static_cast<std::uint16_t>(shortest),
          .lead_max_clocks = static_cast<std::uint16_t>(longest),
          .ack_min_clocks = ack_min,
          .ack_max_clocks = ack.max_clocks,
          .late_max_clocks = late_clocks(timing, setup.period, setup.line_delay.max,
                                         falling ? Picoseconds{} : setup.period / 2,
                                         static_cast<unsigned>(shortest) + ack_min)};
}

/// The clocks of MA up to STOP at the longest line delay and the longest ACK.
constexpr std::size_t spi_clocks(const FrameFormat& format, const SpiSetup& setup,
                                 const DeviceTiming& timing) {
  const FrameBounds bounds = spi_bounds(setup, timing);
  // START, CDS, STOP.
  return std::size_t{bounds.lead_max_clocks} + bounds.ack_max_clocks + 3U + format.payload_bits();
}

/// The bytes to transfer for spi_clocks(), padding included.
constexpr std::size_t spi_bytes(const FrameFormat& format, const SpiSetup& setup,
                                const DeviceTiming& timing) {
  return (setup.first_bit + spi_clocks(format, setup, timing) + 7U) / 8U;
}

/// From the request (the first falling edge of MA) to the moment whose position is sent. The
/// device's time is measured from the first rising edge.
constexpr Picoseconds sampling_delay(const SpiSetup& setup, const DeviceTiming& timing) {
  return setup.period / 2 + timing.sampling_typical;
}

/// The whole clocks of line delay in a good frame.
/// \pre the frame came from a SpiReader
template <std::size_t Channels>
constexpr std::uint16_t line_delay_clocks(const BasicFrame<Channels>& frame) {
  return static_cast<std::uint16_t>(frame.lead_clocks - 2U);
}

/// The range of line delays that fit a good frame, from `min` to `max`. Its width is one period
/// (half a period if the delay cannot be negative).
/// \pre the frame came from a SpiReader of this setup
template <std::size_t Channels>
constexpr LineDelayRange observed_line_delay(const BasicFrame<Channels>& frame,
                                             const SpiSetup& setup) {
  Picoseconds min = setup.period * line_delay_clocks(frame);
  if (setup.phase == SpiPhase::sample_on_falling) min -= setup.period / 2;
  return {std::max(min, Picoseconds{}), min + setup.period};
}

/// Reads the frames of one encoder on one SPI peripheral. Everything is computed in the
/// constructor, so the object may be constexpr and in flash; reading needs no heap.
///
/// If check_spi() refuses the setup, a constant reader does not compile. At run time error() has
/// the cause; the reader then returns no frame, and its clocks() and bytes() are 0.
///
/// `Codec` is a FrameCodec or FixedCodec; it is kept by value.
template <class Codec>
class SpiReader {
 public:
  using Frame = typename Codec::Frame;

  constexpr SpiReader(const Codec& codec, const SpiSetup& spi, const DeviceTiming& device)
      : codec_(codec),
        error_(check_spi(codec.format(), spi, device)),
        bounds_(error_ ? spi_detail::no_bounds : spi_bounds(spi, device)),
        quick_bounds_(bounds_),
        low_until_(error_ ? std::uint16_t{0} : low_until(spi, device)),
        first_bit_(error_ ? std::uint16_t{0} : spi.first_bit),
        clocks_(error_ ? std::uint16_t{0}
                       : static_cast<std::uint16_t>(spi_clocks(codec.format(), spi, device))),
        bytes_(static_cast<std::uint16_t>((first_bit_ + clocks_ + 7U) / 8U)) {
    if (std::is_constant_evaluated() && error_) spi_detail::stop_the_build(*error_);
  }

  /// The result of check_spi(): nothing if the reader can be used.
  constexpr const std::optional<SpiSetupError>& error() const { return error_; }
  constexpr const Codec& codec() const { return codec_; }
  constexpr const FrameBounds& bounds() const { return bounds_; }
  /// The same as spi_clocks().
  constexpr std::size_t clocks() const { return clocks_; }
  /// The same as spi_bytes().
  constexpr std::size_t bytes() const { return bytes_; }

  /// Finds and decodes the frame.
  /// \param bytes the bytes that the peripheral received
  /// \param clocks how many clocks were sent. Later bits are ignored; clocks without bits in the
  ///   buffer count as not sent.
  /// \return the frame, or any FrameError: `not_ready` if SLO was low at first for longer than
  ///   late_max_clocks of bounds(), `truncated` if the clocks end before the last CRC bit,
  ///   `stop_bit` for a 1 at STOP, or after it while SLO must be low.
  [[nodiscard, gnu::always_inline]] constexpr Result<Frame, FrameFault> read(
      std::span<const std::uint8_t> bytes, std::size_t clocks) const {
    frame_detail::Outcome<Codec> result = frame_detail::empty_frame<Frame>;
    if constexpr (!frame_detail::selects) {
      const BitView bits(bytes, first_bit_, clocks);
      const auto fault = frame_detail::decode_in_steps(bits, codec_, bounds_, result.value());
      if (fault) result = failure(*fault);
      check_tail(bits, result);
    } else if (!read_here(bytes, clocks, result.value())) [[unlikely]] {
      // By parts, so that the compiler can keep `result` in registers.
      const frame_detail::Outcome<Codec> apart = read_apart(bytes, clocks);
      if (apart.ok()) {
        frame_detail::copy_parts(apart.value(), result.value());
      } else {
        result = failure(apart.error());
      }
    }
    return result;
  }

  /// The same, with a clock for every bit of the buffer from first_bit on.
  [[nodiscard, gnu::always_inline]] constexpr Result<Frame, FrameFault> read(
      std::span<const std::uint8_t> bytes) const {
    return read(bytes, std::numeric_limits<std::size_t>::max());
  }

 private:
  static constexpr std::uint16_t low_until(const SpiSetup& setup, const DeviceTiming& timing) {
    constexpr std::int64_t forever = std::numeric_limits<std::uint16_t>::max();
    if (setup.tail == SpiTail::ignored) return 0;
    if (timing.timeout.rule != TimeoutRule::cycle) return forever;
    return static_cast<std::uint16_t>(std::clamp<std::int64_t>(
        timing.timeout.time.count / spi_detail::longest_clock(setup).count, 0, forever));
  }

  // Bits from START to STOP.
  constexpr std::size_t clocks_from_start() const { return codec_.clocks(); }

  // The bits after the payload in the word from CDS on; the payload is shorter than the word.
  constexpr std::uint64_t rest(std::uint64_t word) const {
    if constexpr (Codec::may_be_one_word) {
      return codec_.plan(0).rest(word);
    } else {
      return word << std::min(1U + codec_.payload_bits(), 63U);
    }
  }

  // A good frame without padding; false for all others.
  [[gnu::always_inline]] constexpr bool read_here(std::span<const std::uint8_t> bytes,
                                                  std::size_t clocks, Frame& frame) const {
    const BitView bits(bytes, 0, clocks);
    if (first_bit_ != 0) return false;
    const auto is_tail_low = [&](const frame_detail::QuickStart& found) {
      if (found.is_in_head && bits.size_bits() == bytes.size() * 8U &&
          bits.size_bits() <= low_until_) [[likely]] {
        return (rest(found.word) | bits.ones_after_8_bytes()) == 0;
      }
      return bits.first(low_until_).is_low_from(found.start_bit + codec_.clocks());
    };
    return frame_detail::decode_here(bits, codec_, bounds_, quick_bounds_, frame, is_tail_low);
  }

  // Not inlined, so that the caller keeps its registers.
  [[gnu::noinline]] constexpr frame_detail::Outcome<Codec> read_apart(
      std::span<const std::uint8_t> bytes, std::size_t clocks) const {
    const BitView bits(bytes, first_bit_, clocks);
    frame_detail::Outcome<Codec> result = decode_frame(bits, codec_, bounds_);
    check_tail(bits, result);
    return result;
  }

  // A 1 in the tail is the cause unless an earlier one on the line applies.
  constexpr void check_tail(const BitView& bits, frame_detail::Outcome<Codec>& result) const {
    if (!result.ok()) return;
    const std::size_t start = std::size_t{result->lead_clocks} + result->ack_clocks;
    if (bits.first(low_until_).is_low_from(start + clocks_from_start())) return;
    result = failure(FrameFault{FrameError::stop_bit});
  }

  Codec codec_;
  std::optional<SpiSetupError> error_;
  FrameBounds bounds_;
  frame_detail::QuickBounds quick_bounds_;
  std::uint16_t low_until_;
  std::uint16_t first_bit_;
  std::uint16_t clocks_;
  std::uint16_t bytes_;
};

}  // namespace biss
