// The results of the cycles of an axis, its states, and the steps between them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/base/language.hpp"
#include "biss/frame/status.hpp"

namespace biss {

/// The result of one cycle of an axis: each cycle has exactly one, the first that applies.
enum class AxisCause : std::uint8_t {
  ok,  ///< the position was measured in this cycle
  // The causes of FrameError, in its order: there is no frame.
  no_response,
  not_ready,
  response_range,
  no_start,
  ack_range,
  truncated,
  cds,
  crc,
  stop_bit,
  error_bit,   ///< nE is 0: the encoder says that its position is wrong
  turns,       ///< since the last measured position, the axis may have moved by half a turn
  step,        ///< the position is farther away than max_step allows
  warning,     ///< nW is 0; measured, unless the setup has another rule
  early,       ///< measured, but requested within an eighth of `cycle` after the position before
  first,       ///< the first good frame: its position counts when the next frame confirms it
  late,        ///< no request was made: the transfer before has not ended
  unanswered,  ///< the end of the transfer was never reported
  failed,      ///< the transfer ended with an error of the DMA
  tripped,     ///< a good frame after a trip, or trip() was called
  unexpected,  ///< not a cycle: an end of a transfer that no request waits for
};

namespace axis_detail {

// Those after the causes of FrameError.
inline constexpr auto cause_names =
    std::to_array<std::string_view>({"error_bit", "turns", "step", "warning", "early", "first",
                                     "late", "unanswered", "failed", "tripped", "unexpected"});

}  // namespace axis_detail

constexpr AxisCause cause_of(FrameError error) { return static_cast<AxisCause>(status_of(error)); }
static_assert(cause_of(FrameError::stop_bit) == AxisCause::stop_bit);

inline constexpr std::size_t axis_cause_count =
    1 + frame_error_count + axis_detail::cause_names.size();
static_assert(axis_cause_count == static_cast<std::size_t>(AxisCause::unexpected) + 1);

/// The number of a cause, from 0; axis_cause_count for a value that is not a cause.
constexpr std::size_t index_of(AxisCause cause) {
  const auto index = static_cast<std::size_t>(cause);
  return index < axis_cause_count ? index : axis_cause_count;
}

/// The enumerator's name. \pre it is a cause
constexpr std::string_view name_of(AxisCause cause) {
  const auto index = static_cast<std::size_t>(cause);
  return index <= frame_error_count ? name_of(static_cast<CycleStatus>(index))
                                    : axis_detail::cause_names[index - frame_error_count - 1];
}

/// The quality of an axis' position.
enum class AxisState : std::uint8_t {
  no_position,   ///< none was measured yet
  measured,      ///< the position of this cycle
  held,          ///< the last measured position
  extrapolated,  ///< the last measured position, moved on at the last measured speed
  tripped,       ///< stop the drive; the position is the last measured one
};
inline constexpr auto axis_state_names =
    std::to_array<std::string_view>({"no_position", "measured", "held", "extrapolated", "tripped"});

constexpr std::string_view name_of(AxisState state) {
  return axis_state_names[static_cast<std::size_t>(state)];
}

/// The events that change the state of an axis.
enum class AxisEvent : std::uint8_t {
  good,     ///< a good frame, confirmed and within its limits
  wait,     ///< a frame without position while there is none: it powers up, or is the first one
  hold,     ///< a bad cycle: the rule is to hold, or there is nothing to extrapolate
  proceed,  ///< a bad cycle: the rule is to extrapolate
  trip,     ///< the last bad cycle that is allowed, a rule that trips, or trip()
  reset,    ///< reset()
};
inline constexpr auto axis_event_names =
    std::to_array<std::string_view>({"good", "wait", "hold", "proceed", "trip", "reset"});

/// The next state, by state and event. The axis takes each of its steps from this table.
inline constexpr auto axis_states = [] {
  using enum AxisState;
  std::array<std::array<AxisState, axis_event_names.size()>, axis_state_names.size()> next{{
      // good   wait         hold         proceed       trip     reset
      {measured, no_position, no_position, no_position, tripped, no_position},  // no_position
      {measured, held, held, extrapolated, tripped, no_position},               // measured
      {measured, held, held, extrapolated, tripped, no_position},               // held
      {measured, held, held, extrapolated, tripped, no_position},               // extrapolated
      {tripped, tripped, tripped, tripped, tripped, no_position},               // tripped
  }};
  return next;
}();

}  // namespace biss
