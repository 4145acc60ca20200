// The verdicts of the safety monitor, and how each of the eight transmission errors of IEC 61784-3
// shows in them.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "biss/base/units.hpp"

namespace biss {

/// The verdict on one frame. The causes are in the order in which they are checked, so a frame has
/// the first one that applies.
enum class SafetyVerdict : std::uint8_t {
  safe,               ///< everything agrees; the only verdict that comes with a position
  starting,           ///< a good frame, and not yet enough of them in a row
  latched,            ///< an earlier fault is latched until acknowledge()
  self_test,          ///< the power-up test has not run, or has failed
  disagreement,       ///< the two evaluations of the frame differ: a fault of the receiver
  watchdog,           ///< the last good frame is too long ago, or the clock is before it
  early,              ///< sooner after the last good frame than any cycle can be
  no_frame,           ///< no answer, no START, ACK or STOP wrong, cut short, another channel's CRC
  cpw_crc,            ///< the control position word's CRC is wrong
  spw_crc,            ///< the safety position word's CRC is wrong
  cpw_error,          ///< nE of the control position word is 0
  spw_error,          ///< nE of the safety position word is 0
  comparison,         ///< the positions of the two words differ too much
  counter_mode,       ///< the counter has the other range (1…63 or 0…63): wrong setup
  counter_repeated,   ///< the counter stands still
  counter_skipped,    ///< the counter is ahead by a few frames: they are lost
  counter_backwards,  ///< the counter is back by a few frames: wrong order, or late frames
  counter_foreign,    ///< the counter is far off: a frame of another source
};

inline constexpr std::size_t safety_verdict_count = 18;

/// The name users see, the same as the enumerator's.
constexpr std::string_view name_of(SafetyVerdict verdict) {
  constexpr std::array<std::string_view, safety_verdict_count> names{"safe",
                                                                     "starting",
                                                                     "latched",
                                                                     "self_test",
                                                                     "disagreement",
                                                                     "watchdog",
                                                                     "early",
                                                                     "no_frame",
                                                                     "cpw_crc",
                                                                     "spw_crc",
                                                                     "cpw_error",
                                                                     "spw_error",
                                                                     "comparison",
                                                                     "counter_mode",
                                                                     "counter_repeated",
                                                                     "counter_skipped",
                                                                     "counter_backwards",
                                                                     "counter_foreign"};
  return names[static_cast<std::size_t>(verdict)];
}

/// Whether this is a fault, and not only a state of the monitor.
constexpr bool is_fault(SafetyVerdict verdict) { return verdict > SafetyVerdict::latched; }

/// Whether a fault can come from the line, so that a few of them may be tolerated. Faults of the
/// monitor, of its setup, and of a time that has already run out cannot.
constexpr bool is_tolerable(SafetyVerdict verdict) {
  return verdict > SafetyVerdict::watchdog && verdict != SafetyVerdict::counter_mode;
}

/// The eight transmission errors of IEC 61784-3.
enum class TransmissionError : std::uint8_t {
  corruption,  ///< bits of the frame are wrong
  repetition,  ///< unintended repetition: an old frame is received again
  sequence,    ///< incorrect sequence: frames are received in the wrong order
  loss,        ///< a frame is not received
  delay,       ///< unacceptable delay: a frame is received too late
  insertion,   ///< a frame of another source is received in addition
  masquerade,  ///< data that is no safety frame is taken for one
  addressing,  ///< a frame of another encoder is received
};

inline constexpr std::size_t transmission_error_count = 8;

/// The name users see, the same as the enumerator's.
constexpr std::string_view name_of(TransmissionError error) {
  constexpr std::array<std::string_view, transmission_error_count> names{
      "corruption", "repetition", "sequence",   "loss",
      "delay",      "insertion",  "masquerade", "addressing"};
  return names[static_cast<std::size_t>(error)];
}

/// The verdicts of one transmission error.
struct SafetyMeasure {
  TransmissionError error{};
  /// The verdict if nothing else is wrong with the frame.
  SafetyVerdict verdict{};
  /// Other possible verdicts, bit (1 << verdict) each; a frame has the first cause that applies.
  std::uint32_t others = 0;

  /// Returns whether the error can have this verdict.
  constexpr bool may_be(SafetyVerdict seen) const {
    return seen == verdict || ((others >> static_cast<unsigned>(seen)) & 1U) != 0;
  }
};

namespace safety_detail {

template <class... Verdicts>
constexpr std::uint32_t set_of(Verdicts... verdicts) {
  return ((std::uint32_t{1} << static_cast<unsigned>(verdicts)) | ...);
}

using enum SafetyVerdict;

// Whatever a wrong counter can be called.
inline constexpr std::uint32_t any_counter =
    set_of(counter_mode, counter_repeated, counter_skipped, counter_backwards, counter_foreign);
// Whatever wrong bits can be called.
inline constexpr std::uint32_t any_content =
    set_of(no_frame, cpw_crc, spw_crc, cpw_error, spw_error, comparison) | any_counter;

}  // namespace safety_detail

/// The measure against each transmission error, in the order of the enumerators. By PROTOCOL 5.5
/// (BiSS Safety Concept A5), the counter detects repetition, incorrect sequence, loss and
/// insertion, the watchdog detects delay and loss, the second word detects corruption and
/// masquerade. The counter detects a frame of another encoder; so do the CRCs if the encoders have
/// different start values. The counter's verdict depends on the distance of its value: a frame
/// older than the last one, or more than near_frames lost frames, can have any of the verdicts.
inline constexpr std::array<SafetyMeasure, transmission_error_count> safety_measures{{
    {TransmissionError::corruption, SafetyVerdict::spw_crc, safety_detail::any_content},
    {TransmissionError::repetition, SafetyVerdict::counter_repeated, safety_detail::any_counter},
    {TransmissionError::sequence, SafetyVerdict::counter_backwards, safety_detail::any_counter},
    {TransmissionError::loss, SafetyVerdict::counter_skipped,
     safety_detail::set_of(SafetyVerdict::no_frame, SafetyVerdict::watchdog) |
         safety_detail::any_counter},
    {TransmissionError::delay, SafetyVerdict::watchdog,
     safety_detail::set_of(SafetyVerdict::no_frame) | safety_detail::any_counter},
    {TransmissionError::insertion, SafetyVerdict::counter_foreign,
     safety_detail::set_of(SafetyVerdict::early) | safety_detail::any_counter},
    {TransmissionError::masquerade, SafetyVerdict::spw_crc, safety_detail::any_content},
    {TransmissionError::addressing, SafetyVerdict::counter_foreign, safety_detail::any_content},
}};

// ---- What an evaluation finds in one frame, and the monitor's judgement

namespace safety_detail {

// The difference on a clock that wraps around.
constexpr Picoseconds elapsed(Picoseconds from, Picoseconds to) {
  const auto apart = static_cast<std::uint64_t>(to.count) - static_cast<std::uint64_t>(from.count);
  return {static_cast<std::int64_t>(apart)};
}
constexpr Picoseconds later(Picoseconds from, Picoseconds by) {
  const auto sum = static_cast<std::uint64_t>(from.count) + static_cast<std::uint64_t>(by.count);
  return {static_cast<std::int64_t>(sum)};
}

}  // namespace safety_detail

/// The result of one evaluation of one frame, without the frames before. The results of two
/// evaluations of the same bits must be equal. It has no padding, so a comparison takes all bytes.
struct SafetyFinding {
  /// The CPW's position. This and the members up to `cause` are 0 (nW: true) unless both CRCs are
  /// good.
  std::uint64_t position = 0;
  /// CPW minus SPW in counts of the lowest bit compared, in the shorter direction; limited to its
  /// type.
  std::int32_t difference_lsb = 0;
  std::uint8_t life_counter = 0;
  bool cpw_nW = true;
  bool spw_nW = true;
  /// no_frame … comparison, or safe.
  SafetyVerdict cause = SafetyVerdict::no_frame;

  constexpr bool operator==(const SafetyFinding& other) const {
    using Words = std::array<std::uint64_t, 2>;
    return std::bit_cast<Words>(*this) == std::bit_cast<Words>(other);
  }
};

enum class SafetyState : std::uint8_t {
  untested,  ///< self_test() has not run or has failed
  starting,  ///< fewer good frames in a row than are asked for
  safe,
  latched,  ///< after a fault, until acknowledge()
};

/// The monitor's judgement of one frame.
struct SafetyJudgement {
  SafetyVerdict verdict = SafetyVerdict::self_test;
  /// After this frame.
  SafetyState state = SafetyState::untested;
  /// The fault is within the budget: this frame has no position, and the state is still safe.
  bool tolerated = false;
  /// Low-active and no fault: the scale or the window needs cleaning. True where the frame gave no
  /// good words.
  bool cpw_nW = true;
  bool spw_nW = true;
  /// The counter of a frame with good CRCs, else 0.
  std::uint8_t life_counter = 0;
  /// CPW minus SPW in counts of the lowest bit compared; the margin is the tolerance less its
  /// magnitude. 0 without good CRCs.
  std::int32_t difference_lsb = 0;
  /// The CPW's position where the verdict is safe and belongs to a frame; none otherwise.
  std::optional<std::uint64_t> position{};
};

}  // namespace biss
