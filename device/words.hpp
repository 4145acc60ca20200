// The words of every status of a cycle, and of every cause why a link does not work. The only place
// of these words: the command, the page and Python print them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/frame/status.hpp"

namespace biss {

/// Why a link does not work. Users and scripts see the names; docs/explain.md explains each.
enum class Cause : std::uint8_t {
  healthy,
  wrong_format,
  wrong_checksum,
  format_changes,
  ma_slo_swapped,
  slo_inverted,
  ma_inverted,
  clock_too_fast_for_cable,
  ack_longer_than_master_waits,
  master_stops_early,
  master_pauses_clock,
  requested_too_soon,
  noise_on_slo,
  noise_on_ma,
  supply_or_intermittent,
  no_encoder,
  stuck_low,
  encoder_error,
  frames_lost_or_repeated,
  position_implausible,
  limits_exceeded,
  sampling_too_slow,
  not_biss,
};

inline constexpr std::size_t cause_count = 23;

/// The name that users see: the enumerator's name.
std::string_view name_of(Cause cause);

/// The remedy, in one or two sentences of plain text.
std::string_view remedy_of(Cause cause);

/// The words of a status; empty if a program never prints them.
struct StatusWords {
  /// The observation, as in docs/status.md.
  std::string_view seen;
  /// The fault, written next to the place in a drawing at which the cycle fails.
  std::string_view failure = {};
  /// The likely reason, if nothing but the bits of one frame is known.
  std::string_view reason = {};
  /// The first remedy to try: one for when other cycles are good, one for when none is.
  std::string_view remedy_of_some = {};
  std::string_view remedy_of_all = {};
};

const StatusWords& words_of(CycleStatus status);

}  // namespace biss
