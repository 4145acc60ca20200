// The verdicts of the safety monitor, and how each of the eight transmission errors of IEC 61784-3
// shows in them.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/safety/states.hpp"

namespace biss {

/// The verdict on one frame. The causes are in the order in which they are checked, so a frame has
/// the first cause that applies. The values differ in four bits or more from each other, from 0 and
/// from all ones; index_of() numbers them.
enum class SafetyVerdict : std::uint16_t {
  /// Everything agrees; the only verdict that comes with a position.
  safe = safety_detail::code_word(1),
  /// A good frame, but too few good frames in a row so far.
  starting = safety_detail::code_word(2),
  /// An earlier fault is latched until acknowledge().
  latched = safety_detail::code_word(3),
  /// An earlier fault of the receiver; it holds until the next power-up.
  failed = safety_detail::code_word(4),
  /// The power-up test has not run, or has failed.
  self_test = safety_detail::code_word(5),
  /// The monitor's memory has changed: a fault of the receiver.
  memory = safety_detail::code_word(6),
  /// The two evaluations of the frame differ: a fault of the receiver.
  disagreement = safety_detail::code_word(7),
  /// The two clocks differ, the clock has stopped, or the transfer took too long or too short.
  clock = safety_detail::code_word(8),
  /// The last good frame is too long ago, or the clock is before it.
  watchdog = safety_detail::code_word(9),
  /// Sooner after the last good frame than frame_gap_min.
  early = safety_detail::code_word(10),
  /// No answer, no START, ACK or STOP wrong, cut short, another channel's CRC.
  no_frame = safety_detail::code_word(11),
  /// The control position word's CRC is wrong.
  cpw_crc = safety_detail::code_word(12),
  /// The safety position word's CRC is wrong.
  spw_crc = safety_detail::code_word(13),
  /// nE of the control position word is 0.
  cpw_error = safety_detail::code_word(14),
  /// nE of the safety position word is 0.
  spw_error = safety_detail::code_word(15),
  /// The positions of the two words differ too much.
  comparison = safety_detail::code_word(16),
  /// The counter has the other range (1…63 or 0…63): wrong setup.
  counter_mode = safety_detail::code_word(17),
  /// The counter did not change.
  counter_repeated = safety_detail::code_word(18),
  /// The counter is ahead by a few frames: they are lost.
  counter_skipped = safety_detail::code_word(19),
  /// The counter is back by a few frames: wrong order, or late frames.
  counter_backwards = safety_detail::code_word(20),
  /// The counter is far off: a frame of another source.
  counter_foreign = safety_detail::code_word(21),
  /// The answer to the first request after power-up did not have the counter's first value.
  counter_first = safety_detail::code_word(22),
  /// The position was not in the range of expect_position(): an old frame, or another axis.
  stimulus = safety_detail::code_word(23),
};

inline constexpr std::size_t safety_verdict_count = 23;

/// The number of a verdict, 0 for `safe`; safety_verdict_count for a value that is not a verdict.
constexpr std::size_t index_of(SafetyVerdict verdict) {
  const auto word = static_cast<std::uint16_t>(verdict);
  const unsigned number = word >> 5U;
  const bool valid =
      number >= 1 && number <= safety_verdict_count && word == safety_detail::code_word(number);
  return valid ? number - 1U : safety_verdict_count;
}

/// The verdict of a number. \pre index is less than safety_verdict_count
constexpr SafetyVerdict verdict_of(std::size_t index) {
  return static_cast<SafetyVerdict>(safety_detail::code_word(static_cast<unsigned>(index) + 1U));
}

/// The name that users see: the enumerator's name; "invalid" for a value that is not a verdict.
constexpr std::string_view name_of(SafetyVerdict verdict) {
  constexpr std::array<std::string_view, safety_verdict_count + 1> names{"safe",
                                                                         "starting",
                                                                         "latched",
                                                                         "failed",
                                                                         "self_test",
                                                                         "memory",
                                                                         "disagreement",
                                                                         "clock",
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
                                                                         "counter_foreign",
                                                                         "counter_first",
                                                                         "stimulus",
                                                                         "invalid"};
  return names[index_of(verdict)];
}

/// The place of a fault. It decides whether the fault can be tolerated and how it is cleared.
enum class FaultPlace : std::uint8_t {
  none,      ///< no fault, only a state of the monitor
  line,      ///< cable, driver, bus master: a budget may tolerate a few of them
  encoder,   ///< the encoder reports an error, or its two words differ
  request,   ///< time, setup, or an expectation of the caller
  receiver,  ///< our own processor: final until the next power-up
};

constexpr FaultPlace place_of(SafetyVerdict verdict) {
  using enum SafetyVerdict;
  switch (verdict) {
    case safe:
    case starting:
    case latched:
    case failed:
      return FaultPlace::none;
    case early:
    case no_frame:
    case cpw_crc:
    case spw_crc:
    case counter_repeated:
    case counter_skipped:
    case counter_backwards:
    case counter_foreign:
      return FaultPlace::line;
    case cpw_error:
    case spw_error:
    case comparison:
      return FaultPlace::encoder;
    case clock:
    case watchdog:
    case counter_mode:
    case counter_first:
    case stimulus:
      return FaultPlace::request;
    // `default` covers every value that is not a verdict.
    case self_test:
    case memory:
    case disagreement:
    default:
      return FaultPlace::receiver;
  }
}

/// Whether this is a fault, and not only a state of the monitor.
constexpr bool is_fault(SafetyVerdict verdict) { return place_of(verdict) != FaultPlace::none; }

/// Whether a fault can come from the line, so that a few of them may be tolerated.
constexpr bool is_tolerable(SafetyVerdict verdict) { return place_of(verdict) == FaultPlace::line; }

/// The eight transmission errors of IEC 61784-3.
enum class TransmissionError : std::uint8_t {
  corruption,  ///< bits of the frame are wrong
  repetition,  ///< unintended repetition: an old frame is received again
  sequence,    ///< incorrect sequence: frames are received in the wrong order
  loss,        ///< a frame is not received
  delay,       ///< unacceptable delay: a frame is received too late
  insertion,   ///< a frame of another source is received in addition
  masquerade,  ///< other data is taken as a safety frame
  addressing,  ///< a frame of another encoder is received
};

inline constexpr std::size_t transmission_error_count = 8;

/// The name that users see: the enumerator's name.
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
  /// Other possible verdicts, bit (1 << index) each; a frame has the first cause that applies.
  std::uint32_t others = 0;

  /// Returns whether the error can have this verdict.
  constexpr bool may_be(SafetyVerdict seen) const {
    return seen == verdict || ((others >> index_of(seen)) & 1U) != 0;
  }
};

namespace safety_detail {

template <class... Verdicts>
constexpr std::uint32_t set_of(Verdicts... verdicts) {
  return ((std::uint32_t{1} << index_of(verdicts)) | ...);
}

using enum SafetyVerdict;

// All verdicts that a wrong counter can have.
inline constexpr std::uint32_t any_counter =
    set_of(counter_mode, counter_repeated, counter_skipped, counter_backwards, counter_foreign);
// All verdicts that wrong bits can have.
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

// ---- The finding of an evaluation in one frame, and the monitor's judgement

namespace safety_detail {

// A checksum of words in memory. Each step is reversible, so a change within one word always
// changes the checksum; one in 2^32 of all other changes does not. The rotation spreads the
// uppermost bit, too: in a product this bit changes no other bit.
class Check {
 public:
  constexpr void add(std::uint32_t word) { sum_ = std::rotl((sum_ ^ word) * 0x9E37'79B1U, 15); }
  constexpr std::uint32_t sum() const { return sum_; }

 private:
  std::uint32_t sum_ = 0x5A3C'96E1U;
};

}  // namespace safety_detail

/// The result of one evaluation of one frame, without the frames before. The results of two
/// evaluations of the same bits must be equal. It has no padding, so a comparison takes all bytes.
struct SafetyFinding {
  /// The positions of both words. All members up to `cause` are 0 (nW: both bits 1) unless both
  /// CRCs are good.
  std::uint64_t cpw_position = 0;
  std::uint64_t spw_position = 0;
  /// CPW minus SPW in counts of the lowest bit compared, in the shorter direction; limited to its
  /// type.
  std::int32_t difference_lsb = 0;
  std::uint8_t life_counter = 0;
  /// Low-active; bit 1: nW of the CPW, bit 0: nW of the SPW.
  std::uint8_t nW = 3;
  /// no_frame … comparison, or safe.
  SafetyVerdict cause = SafetyVerdict::no_frame;

  constexpr bool cpw_nW() const { return (nW & 2U) != 0; }
  constexpr bool spw_nW() const { return (nW & 1U) != 0; }

  constexpr bool operator==(const SafetyFinding& other) const {
    using Words = std::array<std::uint64_t, 3>;
    const auto a = std::bit_cast<Words>(*this);
    const auto b = std::bit_cast<Words>(other);
    return ((a[0] ^ b[0]) | (a[1] ^ b[1]) | (a[2] ^ b[2])) == 0;
  }
};

/// The position that CPW and SPW agree on. It has the SPW's resolution and the compared turns.
/// Further bits of the CPW are protected by its CRC of 6 bits only.
struct SafePosition {
  /// The SPW's position in counts of the SPW, turns above singleturn.
  std::uint64_t value = 0;
  /// The least and the largest position in counts of the SPW if only one of the two words is right,
  /// whichever it is: `value` with the tolerance and the bits that are not compared. They wrap
  /// around with the range, so `low` may be above `high`.
  std::uint64_t low = 0;
  std::uint64_t high = 0;
  /// The CPW's position minus `value`, in counts of the CPW, from the CPW alone. A safety function
  /// must not use it.
  std::int64_t cpw_only_offset = 0;
  /// The turns above the compared ones, from the CPW alone. A safety function must not use them.
  std::uint64_t cpw_only_turns = 0;

  // All bytes at once: there is no padding.
  constexpr bool operator==(const SafePosition& other) const {
    return ((value ^ other.value) | (low ^ other.low) | (high ^ other.high) |
            static_cast<std::uint64_t>(cpw_only_offset ^ other.cpw_only_offset) |
            (cpw_only_turns ^ other.cpw_only_turns)) == 0;
  }
};

/// A SafePosition or none, like an optional. It has a checksum, so that there is no position if one
/// bit of it has changed in memory, or two bits of one word.
class GuardedPosition {
 public:
  constexpr GuardedPosition() = default;
  constexpr GuardedPosition(const SafePosition& position)
      : position_(position), check_(check_of(position)) {}

  constexpr bool has_value() const { return check_ == check_of(position_); }
  constexpr explicit operator bool() const { return has_value(); }
  /// \pre has_value()
  constexpr const SafePosition& operator*() const { return position_; }
  constexpr const SafePosition* operator->() const { return &position_; }

 private:
  // Not 0 for a position of zeros, so that a memory of zeros is not a position.
  static constexpr std::uint32_t check_of(const SafePosition& position) {
    safety_detail::Check check;
    for (const std::uint64_t word :
         {position.value, position.low, position.high,
          static_cast<std::uint64_t>(position.cpw_only_offset), position.cpw_only_turns}) {
      check.add(static_cast<std::uint32_t>(word));
      check.add(static_cast<std::uint32_t>(word >> 32U));
    }
    return check.sum();
  }

  SafePosition position_{};
  std::uint32_t check_ = 0;
};

/// The monitor's judgement of one frame.
struct SafetyJudgement {
  SafetyVerdict verdict = SafetyVerdict::self_test;
  /// After this frame.
  SafetyState state = SafetyState::untested;
  /// The fault is within the budget: this frame has no position, and the state is still safe.
  bool tolerated = false;
  /// Low-active and no fault: the scale or the window needs cleaning. True if the frame gave no
  /// good words.
  bool cpw_nW = true;
  bool spw_nW = true;
  /// The counter of a frame with good CRCs, else 0.
  std::uint8_t life_counter = 0;
  /// CPW minus SPW in counts of the lowest bit compared; the margin is the tolerance less its
  /// magnitude. 0 without good CRCs.
  std::int32_t difference_lsb = 0;
  /// Present only if the verdict is safe and belongs to a frame.
  GuardedPosition position{};
};

}  // namespace biss
