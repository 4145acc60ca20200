// What a slave waits for, and what it asks of its owner.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/base/units.hpp"

namespace biss {

/// What a slave waits for.
enum class SlaveState : std::uint8_t {
  idle,           ///< a falling edge of MA; SLO is 1
  requested,      ///< LAT, the first rising edge; SLO is still 1
  latched,        ///< ACK, the second rising edge; SLO is still 1
  ack,            ///< its answer, and the predecessor's START; SLO is 0
  start,          ///< the clock that sends CDS
  data,           ///< the clocks that send its own bits
  stop,           ///< the timeout; SLO is 0, or what a predecessor sends
  early_request,  ///< as `stop`: a request came before the timeout was over, and is not answered
  chain_busy,     ///< SLI = 1: its own timeout is over, a predecessor's is not; SLO is 0
};

inline constexpr std::size_t slave_state_count = 9;

/// The name users see, the same as the enumerator's.
constexpr std::string_view name_of(SlaveState state) {
  constexpr std::array<std::string_view, slave_state_count> names{
      "idle", "requested", "latched",       "ack",       "start",
      "data", "stop",      "early_request", "chain_busy"};
  return names[static_cast<std::size_t>(state)];
}

/// The owner of a slave; see the top of this file.
///
/// `cds(predecessor)` gives the bit to send; `predecessor` is what SLI brought, 0 where the slave
/// is not chained. An owner with nothing of its own to say returns it. `cdm()` is told when the
/// timeout after an ACK is over, also when the clock had stopped early: a frame may end without
/// `cds()`.
template <class Source, class Codec>
concept SlaveSource = requires(Source source, Picoseconds moment) {
  { source.sample(moment) } -> std::convertible_to<typename Codec::Frame>;
  { source.cds(true) } -> std::same_as<bool>;
  source.cdm(true);
};

}  // namespace biss
