// How an access to registers or a command ended.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace biss {

/// The one cause why an access did not do all it was asked. Where the protocol cannot tell two
/// causes apart the name says so.
enum class ControlError : std::uint8_t {
  bad_request,         ///< asked for what no control frame can say; nothing was sent
  no_answer,           ///< IDL0 stayed 0: no slave took an ID
  no_such_slave,       ///< fewer slaves took an ID than the one addressed
  id_pattern,          ///< IDL has a gap, or a 1 behind it where 0 is due
  refused,             ///< read: protected or not there (these two look the same)
  unheard,             ///< read: the slave is there but behaves as not addressed (header damaged)
  refused_or_unheard,  ///< write: refused, or the header was damaged: both look the same
  rw_pattern,          ///< R and W as no slave sends them
  busy_too_long,     ///< no start bit in time; an old device without W inversion refuses like this
  start_missing,     ///< write: S of the first byte was not echoed, which may not be delayed
  data_crc,          ///< read: the byte and its CRC do not fit
  echo,              ///< write: what came back is not what was sent; what was written is unknown
  next_unavailable,  ///< sequential: P = 1 before the last byte; those before are done
  not_accepted,      ///< command: too few of the addressed slaves said that they would, or none
                     ///< heard it (header damaged); dropped by EX = 0
  ida_pattern,       ///< command: a slave that is not addressed accepts; dropped by EX = 0
  frame_lost,        ///< a frame of the access brought no CDS
  cancelled,         ///< by the master itself
};

inline constexpr std::size_t control_error_count = 17;

/// The name users and scripts see, the same as the enumerator's.
constexpr std::string_view name_of(ControlError error) {
  constexpr std::array<std::string_view, control_error_count> names{
      "bad_request",        "no_answer",    "no_such_slave", "id_pattern",    "refused",  "unheard",
      "refused_or_unheard", "rw_pattern",   "busy_too_long", "start_missing", "data_crc", "echo",
      "next_unavailable",   "not_accepted", "ida_pattern",   "frame_lost",    "cancelled"};
  return names[static_cast<std::size_t>(error)];
}

/// Whether damage on the line can be the cause, so that the same access may succeed when it is
/// tried again. A clear no (refused, next_unavailable) is not asked twice, and what the master did
/// itself not done again.
constexpr bool worth_retrying(ControlError error) {
  switch (error) {
    case ControlError::bad_request:
    case ControlError::refused:
    case ControlError::next_unavailable:
    case ControlError::cancelled:
      return false;
    default:
      return true;
  }
}

}  // namespace biss
