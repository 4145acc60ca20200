// The meaning of a fault's random number: how late, how far, which bits.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "biss/base/bits.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/format.hpp"
#include "biss/slave/slave.hpp"
#include "biss/timing/device_timing.hpp"
#include "sim/fault.hpp"
#include "sim/random.hpp"

namespace biss::sim {

/// How much later SLO is by `delay_step`: a quarter of a period to one and a quarter.
constexpr Picoseconds delay_step(std::uint64_t detail, Picoseconds period) {
  const auto parts = static_cast<std::int64_t>(detail % 1024U);
  return period / 4 + period * parts / 1024;
}

/// The timing with `late_start`: START 1 to 8 clocks later than the type's limit.
constexpr SlaveTiming late_timing(SlaveTiming timing, const DeviceTiming& type,
                                  std::uint64_t detail, Picoseconds period) {
  const auto clocks = static_cast<std::int64_t>(1 + detail % 8U);
  timing.ready = type.ack_max + clocks * period;
  if (timing.ack_clocks != 0) {
    timing.ack_clocks = static_cast<std::uint16_t>(timing.ack_clocks + clocks);
  }
  return timing;
}

/// The number of cycles by which the fault `delay` delays the next request.
constexpr std::int64_t late_cycles(std::uint64_t detail) {
  return static_cast<std::int64_t>(1 + detail % 3U);
}

/// Inverted bits of the payload: a 1 inverts a bit; the lowest one is for bit `first`.
struct BitPattern {
  unsigned first = 0;
  std::uint64_t bits = 0;
};

/// The bits of `flip` and `burst`. \param place given by a rule \param payload_bits 2 or more for a
/// burst
constexpr BitPattern pattern_of(FaultKind kind, std::uint64_t detail,
                                const std::optional<FaultPlace>& place, unsigned payload_bits) {
  Random random(detail);
  if (kind == FaultKind::flip) {
    const auto drawn = static_cast<unsigned>(random.below(payload_bits));
    return {place ? static_cast<unsigned>(place->whole()) : drawn, 1};
  }
  constexpr unsigned longest = 16;
  const auto given = static_cast<unsigned>(place ? place->whole() : 0U);
  const unsigned room = std::min(longest, payload_bits - given);
  const auto length = static_cast<unsigned>(2 + random.below(room - 1U));
  const auto drawn = static_cast<unsigned>(random.below(payload_bits - length + 1U));
  const std::uint64_t ends = (std::uint64_t{1} << (length - 1U)) | 1U;
  return {place ? given : drawn, (random.next() & low_mask(length)) | ends};
}

/// The bits of `masquerade`: random bits of the last word and its checksum, at most 64, the first
/// one always inverted.
constexpr BitPattern noise_of(std::uint64_t detail, const FrameFormat& format) {
  const unsigned all = format.payload_bits();
  const unsigned word = format.channel_list[format.channel_count - 1U].total_bits();
  const unsigned bits = std::min({all, word, 64U});
  return {all - bits, (scrambled(detail) & low_mask(bits)) | 1U};
}

/// The place of a fault that begins this long after its cycle. Whole periods are separate, because a
/// cycle may last 1000 s and more.
constexpr FaultPlace place_after(Picoseconds since, Picoseconds period) {
  const std::int64_t part = since.count % period.count * 1000 / period.count;
  return {PlaceUnit::clock, static_cast<std::uint64_t>(since.count / period.count * 1000 + part)};
}

}  // namespace biss::sim
