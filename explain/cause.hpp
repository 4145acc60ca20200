// Why a link does not work: the causes, and what to do about each.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace biss::explain {

/// Users and scripts see the names; docs/explain.md explains each.
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

/// The name that users see, the same as the enumerator's.
std::string_view name_of(Cause cause);

/// What to do, in one or two sentences of plain text. The only place of these words: `explain` and
/// the line `try` of `decode` print them.
std::string_view remedy_of(Cause cause);

}  // namespace biss::explain
