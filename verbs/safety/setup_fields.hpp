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
  const auto field = [&](const char* name, const char* meaning) {
    return SetupField{group, name, meaning};
  };
  auto& [cpw, spw, start_frames, latch, comparison, counter, cycle_min, frame_gap_max,
         frame_gap_min, clocks, budget, bounds, rating, residual_max_e15] = setup;
  visitor.number(field("cpw", "channel of the control word, from 0"), cpw);
  visitor.number(field("spw", "channel of the safety word"), spw);
  visitor.number(
      field("start_frames", "good frames in a row until the last one is `safe`; 2 or more"),
      start_frames);
  visitor.number(field("latch", "a fault holds until `acknowledge()`"), latch);
  visitor.time(field("cycle_min", "shortest time from request to request; above 0"), cycle_min);
  visitor.time(field("frame_gap_max", "watchdog: longest time between two good frames"),
               frame_gap_max);
  visitor.time(
      field("frame_gap_min", "shortest time between two good frames; 0 (unrated): not checked"),
      frame_gap_min);
  visitor.number(
      field("residual_max_e15", "most undetected errors an hour, times 1e15, at a BER of 1e-2"),
      residual_max_e15);
  group = "SafetyComparison";
  auto& [compare_bits, tolerance_lsb, multiturn] = comparison;
  visitor.number(field("compare_bits", "upper singleturn bits that are compared (ACC_MIN); 0: all"),
                 compare_bits);
  visitor.number(field("tolerance_lsb", "allowed difference in counts of the lowest bit compared"),
                 tolerance_lsb);
  visitor.choice(field("multiturn", "whether the turns are compared, as one number"), multiturn,
                 multiturn_names);
  group = "SafetyCounter";
  auto& [mode, missed, near_frames, learn_rollovers, first] = counter;
  visitor.choice(field("mode", "range of the sign of life"), mode, counter_mode_names);
  visitor.choice(field("missed", "whether the encoder counts requests without a good frame"),
                 missed, missed_names);
  visitor.number(field("near_frames", "largest distance of a loss or a wrong order, in frames"),
                 near_frames);
  visitor.number(field("learn_rollovers", "equal roll-overs in a row until a range is learned"),
                 learn_rollovers);
  visitor.number(field("first", "value in the first answer after power-up; 255: not checked"),
                 first);
  group = "SafetyClocks";
  auto& [clock_tolerance, still_requests, bit_period] = clocks;
  visitor.time(
      field("tolerance", "allowed difference of two clocks between good frames; 0 or more"),
      clock_tolerance);
  visitor.number(field("still_requests", "requests in a row with an unchanged time, allowed"),
                 still_requests);
  visitor.time(field("bit_period", "period of the SPI clock; 0: transfers are not timed"),
               bit_period);
  group = "SafetyBudget";
  auto& [faults, window] = budget;
  visitor.number(field("faults", "tolerated faults of the line in a window; at most 4"), faults);
  visitor.time(field("window", "time span of the budget"), window);
  group = "FrameBounds";
  auto& [lead_min_clocks, lead_max_clocks, ack_min_clocks, ack_max_clocks, late_max_clocks] =
      bounds;
  visitor.number(field("lead_min_clocks", "fewest ones before ACK: the LAT clock"),
                 lead_min_clocks);
  visitor.number(field("lead_max_clocks", "most ones before ACK: LAT and 40 us of line delay"),
                 lead_max_clocks);
  visitor.number(field("ack_min_clocks", "fewest zeros of ACK"), ack_min_clocks);
  visitor.number(field("ack_max_clocks", "most zeros of ACK: 40 us of processing time"),
                 ack_max_clocks);
  visitor.number(field("late_max_clocks", "zeros allowed in place of the first ones"),
                 late_max_clocks);
  group = "SafetyRating";
  auto& [words, residual_e24, check] = rating;
  visitor.number(field("words", "words of the rating; 0: the rating in the table"), words);
  visitor.number(field("residual_e24", "undetected errors in 1e24 frames at a BER of 1e-2"),
                 residual_e24);
  visitor.number(field("check", "checksum of the other two"), check);
}

}  // namespace biss::verbs
