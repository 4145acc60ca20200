// Every parameter of the safety monitor by name: for configuration.json and docs/safety.md. A field
// that is added to one of the structs does not compile until it is listed here. And the names of the
// mistakes that check_safety() finds.
#pragma once

#include <array>
#include <string_view>

#include "biss/safety/setup.hpp"
#include "verbs/decode/safety.hpp"

namespace biss::verbs {

/// In the order of MissedFrames.
inline constexpr std::array<std::string_view, 2> missed_names{"counted", "perhaps"};
/// In the order of MultiturnRule.
inline constexpr std::array<std::string_view, 2> multiturn_names{"with_carry", "ignored"};

/// A parameter. The meaning is for docs/safety.md.
struct SetupField {
  const char* group;  ///< the struct
  const char* name;
  const char* meaning;
};

/// Calls `visitor` for every parameter: number(field, value) for counts and flags, time(field,
/// value), choice(field, value, names).
template <class Visitor>
void for_each_field(SafetySetup& setup, const Visitor& visitor) {
  const char* group = "SafetySetup";
  const auto number = [&](const char* name, auto& value, const char* meaning) {
    visitor.number(SetupField{group, name, meaning}, value);
  };
  const auto time = [&](const char* name, Picoseconds& value, const char* meaning) {
    visitor.time(SetupField{group, name, meaning}, value);
  };
  const auto choice = [&](const char* name, auto& value, const auto& names, const char* meaning) {
    visitor.choice(SetupField{group, name, meaning}, value, names);
  };
  auto& [cpw, spw, start_frames, latch, comparison, counter, cycle_min, frame_gap_max,
         frame_gap_min, clocks, budget, bounds, rating, residual_max_e15] = setup;
  number("cpw", cpw, "channel of the control word, from 0");
  number("spw", spw, "channel of the safety word");
  number("start_frames", start_frames,
         "good frames in a row until the last one is `safe`; 2 or more");
  number("latch", latch, "a fault holds until `acknowledge()`");
  time("cycle_min", cycle_min, "shortest time from request to request; above 0");
  time("frame_gap_max", frame_gap_max, "watchdog: longest time between two good frames");
  time("frame_gap_min", frame_gap_min,
       "shortest time between two good frames; 0 (unrated): not checked");
  number("residual_max_e15", residual_max_e15,
         "most undetected errors an hour, times 1e15, at a BER of 1e-2");
  group = "SafetyComparison";
  auto& [compare_bits, tolerance_lsb, multiturn] = comparison;
  number("compare_bits", compare_bits, "upper singleturn bits that are compared (ACC_MIN); 0: all");
  number("tolerance_lsb", tolerance_lsb, "allowed difference in counts of the lowest bit compared");
  choice("multiturn", multiturn, multiturn_names, "whether the turns are compared, as one number");
  group = "SafetyCounter";
  auto& [mode, missed, near_frames, learn_rollovers, first] = counter;
  choice("mode", mode, counter_mode_names, "range of the sign of life");
  choice("missed", missed, missed_names,
         "whether the encoder counts requests without a good frame");
  number("near_frames", near_frames, "largest distance of a loss or a wrong order, in frames");
  number("learn_rollovers", learn_rollovers, "equal roll-overs in a row until a range is learned");
  number("first", first, "value in the first answer after power-up; 255: not checked");
  group = "SafetyClocks";
  auto& [clock_tolerance, still_requests, bit_period] = clocks;
  time("tolerance", clock_tolerance,
       "allowed difference of two clocks between good frames; 0 or more");
  number("still_requests", still_requests, "requests in a row with an unchanged time, allowed");
  time("bit_period", bit_period, "period of the SPI clock; 0: transfers are not timed");
  group = "SafetyBudget";
  auto& [faults, window] = budget;
  number("faults", faults, "tolerated faults of the line in a window; at most 4");
  time("window", window, "time span of the budget");
  group = "FrameBounds";
  auto& [lead_min_clocks, lead_max_clocks, ack_min_clocks, ack_max_clocks, late_max_clocks] =
      bounds;
  number("lead_min_clocks", lead_min_clocks, "fewest ones before ACK: the LAT clock");
  number("lead_max_clocks", lead_max_clocks, "most ones before ACK: LAT and 40 us of line delay");
  number("ack_min_clocks", ack_min_clocks, "fewest zeros of ACK");
  number("ack_max_clocks", ack_max_clocks, "most zeros of ACK: 40 us of processing time");
  number("late_max_clocks", late_max_clocks, "zeros allowed in place of the first ones");
  group = "SafetyRating";
  auto& [words, residual_e24, check] = rating;
  number("words", words, "words of the rating; 0: the rating in the table");
  number("residual_e24", residual_e24, "undetected errors in 1e24 frames at a BER of 1e-2");
  number("check", check, "checksum of the other two");
}

}  // namespace biss::verbs
