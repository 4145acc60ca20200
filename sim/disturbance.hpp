// The effect of faults on the levels of the lines and on the bits of the payload.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "biss/base/bits.hpp"
#include "biss/frame/format.hpp"
#include "sim/fault.hpp"
#include "sim/fault_schedule.hpp"
#include "sim/random.hpp"

namespace biss::sim {

/// The places at which a level can be changed.
enum class Place : std::uint8_t {
  ma_master,   ///< on the line at the master: recorded, and passed on to the encoder
  ma_slave,    ///< only at the input of the encoder
  slo_slave,   ///< at the output of the encoder
  slo_master,  ///< at the input of the master: recorded
};

/// The faults that pull a level low or high, and the faults that invert it.
struct LevelEffects {
  FaultSet low = 0;
  FaultSet high = 0;
  FaultSet inverted = 0;
};

/// In the order of Place. An undriven receiver reads 1. If pairs are exchanged, the drivers are
/// connected to each other, and both inputs are open.
inline constexpr std::array<LevelEffects, 4> level_effects = [] {
  using F = FaultKind;
  return std::array<LevelEffects, 4>{
      {{.low = set_of(F::ma_low),
        .high = set_of(F::ma_high),
        .inverted = set_of(F::glitch_ma, F::glitch_ma_idle)},
       {.high = set_of(F::lost_clock, F::no_answer, F::cut, F::exchange, F::brown_out),
        .inverted = set_of(F::double_clock, F::extra_clock, F::swap_ma)},
       {.high = set_of(F::brown_out)},
       {.low = set_of(F::slo_low),
        .high = set_of(F::slo_high, F::cut, F::exchange),
        .inverted = set_of(F::glitch_slo, F::glitch_slo_idle, F::swap_slo)}}};
}();

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

/// All active faults.
class Disturbance {
 public:
  /// The level that results at a place.
  bool level(Place place, bool level) const {
    if (active_ == 0) return level;
    const auto& [low, high, inverted] = level_effects[static_cast<std::size_t>(place)];
    if ((active_ & low) != 0) return false;
    return (active_ & high) != 0 || level != (std::popcount(active_ & inverted) % 2 != 0);
  }

  /// \param now the place in the cycle, for faults whose place the schedule does not give
  /// \param injected gets the fault, if it has a place
  void begin(FaultKind kind, const FaultSchedule& schedule, const FrameFormat& format,
             FaultPlace now, std::vector<InjectedFault>& injected) {
    active_ |= set_of(kind);
    const std::uint64_t detail = schedule.detail(kind);
    const auto place = schedule.place(kind);
    if (kind == FaultKind::flip || kind == FaultKind::burst) {
      const BitPattern pattern = pattern_of(kind, detail, place, format.payload_bits());
      injected.push_back({kind, {PlaceUnit::bit, std::uint64_t{pattern.first} * 1000U}});
      invert(kind, pattern);
    } else if (has_place(kind)) {
      injected.push_back({kind, place.value_or(now)});
    }
    if (kind == FaultKind::masquerade) invert(kind, noise_of(detail, format));
  }

  void end(FaultKind kind) {
    active_ &= ~set_of(kind);
    invert(kind, {});
  }

  bool active(FaultKind kind) const { return (active_ & set_of(kind)) != 0; }
  FaultSet active() const { return active_; }

  /// Whether bit `index` of the payload is inverted.
  bool inverts(unsigned index) const {
    bool inverted = false;
    for (const BitPattern& pattern : patterns_) {
      const unsigned bit = index - pattern.first;
      inverted ^= bit < 64U && ((pattern.bits >> bit) & 1U) != 0;
    }
    return inverted;
  }

 private:
  static constexpr std::array pattern_kinds{FaultKind::flip, FaultKind::burst,
                                            FaultKind::masquerade};

  void invert(FaultKind kind, const BitPattern& pattern) {
    for (std::size_t k = 0; k < pattern_kinds.size(); ++k) {
      if (pattern_kinds[k] == kind) patterns_[k] = pattern;
    }
  }

  FaultSet active_ = 0;
  // The bits that the pattern_kinds invert.
  std::array<BitPattern, pattern_kinds.size()> patterns_{};
};

}  // namespace biss::sim
