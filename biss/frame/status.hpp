// The result of a transmission: the causes why there is no frame, and the statuses that only a
// capture shows. device/words.cpp explains them to users.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace biss {

/// Why the bits are not a frame: the first cause that applies, in the order on the line.
enum class FrameError : std::uint8_t {
  no_response,     ///< SLO stayed high: nothing connected, no power, or the encoder did not answer
  not_ready,       ///< SLO was low when the request began: still busy, or the line is stuck low
  response_range,  ///< ACK began earlier or later than the line delay's bounds allow
  no_start,        ///< ACK began, but START did not come
  ack_range,       ///< START came earlier or later than the ACK bounds allow
  truncated,       ///< the clock stopped before the last CRC bit
  cds,             ///< CDS was 1 and must be 0 in this format
  crc,             ///< a channel's checksum is wrong, or belongs to the previous frame
  stop_bit,        ///< the bit after the last CRC bit was not 0
};

/// Result of a request cycle in a capture. Users and scripts see the names.
enum class CycleStatus : std::uint8_t {
  ok,
  // The causes of FrameError, in its order.
  no_response,
  not_ready,
  response_range,
  no_start,
  ack_range,
  truncated,
  cds,
  crc,
  stop_bit,
  // Only in captures.
  cut_start,      ///< the capture begins inside this cycle
  cut_end,        ///< the capture ends inside this cycle
  ma_glitch,      ///< fewer than two rising edges of MA: a pulse, not a request
  ma_clock,       ///< MA has an edge too few or too many: bits cannot be counted
  unknown_level,  ///< MA or SLO was neither 0 nor 1 at an edge or a sample that matters
  unchecked,      ///< the structure is right; without a format nothing else can be checked
};

/// The names of all statuses, in the order of CycleStatus.
inline constexpr auto cycle_status_names = std::to_array<std::string_view>(
    {"ok", "no_response", "not_ready", "response_range", "no_start", "ack_range", "truncated",
     "cds", "crc", "stop_bit", "cut_start", "cut_end", "ma_glitch", "ma_clock", "unknown_level",
     "unchecked"});
inline constexpr std::size_t cycle_status_count = cycle_status_names.size();

constexpr std::string_view name_of(CycleStatus status) {
  return cycle_status_names[static_cast<std::size_t>(status)];
}

/// Nothing is wrong with the transmission, as far as it was checked.
constexpr bool is_good(CycleStatus status) {
  return status == CycleStatus::ok || status == CycleStatus::unchecked;
}

/// An end of the capture cuts the cycle.
constexpr bool is_cut(CycleStatus status) {
  return status == CycleStatus::cut_start || status == CycleStatus::cut_end;
}

/// Something is wrong with the transmission.
constexpr bool is_fault(CycleStatus status) { return !is_good(status) && !is_cut(status); }

constexpr CycleStatus status_of(FrameError error) {
  return static_cast<CycleStatus>(static_cast<unsigned>(error) + 1U);
}
static_assert(status_of(FrameError::stop_bit) == CycleStatus::stop_bit);

inline constexpr std::size_t frame_error_count = static_cast<std::size_t>(CycleStatus::stop_bit);

/// The number of a cause, from 0; frame_error_count for a value that is not a cause.
constexpr std::size_t index_of(FrameError error) {
  const auto index = static_cast<std::size_t>(error);
  return index < frame_error_count ? index : frame_error_count;
}

/// The name that users see: the enumerator's name.
constexpr std::string_view name_of(FrameError error) { return name_of(status_of(error)); }

}  // namespace biss
