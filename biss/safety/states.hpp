// The states of the safety monitor, and the table of its transitions. docs/safety.md shows the same
// table; a test prints it from here.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace biss {

namespace safety_detail {

/// The code words of verdicts and states: `number` (11 bits) in the upper bits and five check bits
/// below. Any two differ in four bits or more (Hsiao code: the columns of the check bits are
/// different and have an odd number of ones), so no three wrong bits of memory make one of another.
constexpr std::uint16_t code_word(unsigned number) {
  constexpr std::array<std::uint8_t, 11> columns{7, 11, 13, 14, 19, 21, 22, 25, 26, 28, 31};
  unsigned check = 0;
  for (unsigned bit = 0; bit < columns.size(); ++bit) {
    if (((number >> bit) & 1U) != 0) check ^= columns[bit];
  }
  return static_cast<std::uint16_t>((number << 5U) | check);
}

}  // namespace safety_detail

enum class SafetyState : std::uint16_t {
  /// self_test() has not passed.
  untested = safety_detail::code_word(65),
  /// Fewer good frames in a row than required.
  starting = safety_detail::code_word(66),
  safe = safety_detail::code_word(67),
  /// After a fault, until acknowledge().
  latched = safety_detail::code_word(68),
  /// After a fault of the receiver, until the next power-up: a new monitor and its self test.
  failed = safety_detail::code_word(69),
};

inline constexpr std::size_t safety_state_count = 5;

/// The events of a monitor.
enum class SafetyEvent : std::uint8_t {
  self_test_passed,
  self_test_failed,
  good_frame,         ///< too few of them in a row so far, or the counter is being learned
  last_start_frame,   ///< the good frame that completes the start
  tolerated_fault,    ///< of the line, within the budget
  fault,              ///< of line, encoder, time or setup
  unlatched_fault,    ///< the same with `latch` off
  receiver_fault,     ///< `memory`, `disagreement`
  acknowledged,       ///< acknowledge() with the latched cause
  encoder_restarted,  ///< encoder_restarted()
};

inline constexpr std::size_t safety_event_count = 10;

namespace safety_detail {

constexpr std::size_t index_of(SafetyState state) {
  switch (state) {
    case SafetyState::untested:
      return 0;
    case SafetyState::starting:
      return 1;
    case SafetyState::safe:
      return 2;
    case SafetyState::latched:
      return 3;
    case SafetyState::failed:
      return 4;
  }
  return safety_state_count;
}

constexpr auto make_transitions() {
  using enum SafetyState;
  using Row = std::array<SafetyState, safety_event_count>;
  return std::array<Row, safety_state_count>{
      // The columns are the events in their order.
      Row{starting, untested, untested, untested, untested, untested, untested, failed, untested,
          untested},
      Row{starting, failed, starting, safe, starting, starting, starting, failed, starting,
          starting},
      Row{safe, failed, safe, safe, safe, latched, starting, failed, safe, starting},
      Row{latched, failed, latched, latched, latched, latched, latched, failed, starting, latched},
      Row{failed, failed, failed, failed, failed, failed, failed, failed, failed, failed},
  };
}
inline constexpr auto transitions = make_transitions();

}  // namespace safety_detail

/// The names users see, in the order of the events.
inline constexpr std::array<std::string_view, safety_event_count> safety_event_names{
    "self_test_passed", "self_test_failed", "good_frame",
    "last_start_frame", "tolerated_fault",  "fault",
    "unlatched_fault",  "receiver_fault",   "acknowledged",
    "encoder_restarted"};

/// The name that users see: the enumerator's name; "invalid" for a value that is not a state.
constexpr std::string_view name_of(SafetyState state) {
  constexpr std::array<std::string_view, safety_state_count + 1> names{
      "untested", "starting", "safe", "latched", "failed", "invalid"};
  return names[safety_detail::index_of(state)];
}

/// The states in the order of the table. \pre index is less than safety_state_count
constexpr SafetyState state_of(std::size_t index) {
  return static_cast<SafetyState>(safety_detail::code_word(static_cast<unsigned>(index) + 65U));
}

/// The state after an event. A value that is not a state leads to `failed`.
constexpr SafetyState next_state(SafetyState state, SafetyEvent event) {
  const std::size_t row = safety_detail::index_of(state);
  if (row == safety_state_count) return SafetyState::failed;
  return safety_detail::transitions[row][static_cast<std::size_t>(event)];
}

}  // namespace biss
