// The measurements of one request cycle that is clean, on many edges at once, at the best SIMD level
// of the processor. They are the same numbers that CycleReader finds edge by edge.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/base/bits.hpp"

namespace biss::decode {

/// The changes of both lines from a falling edge of MA on, in picoseconds. Each change inverts the
/// level before it.
struct CleanLines {
  std::span<const std::int64_t> ma;
  /// After the first edge of MA; SLO was high there.
  std::span<const std::int64_t> slo;
};

/// Times in picoseconds after the first edge of MA, all of them below 2^31.
struct CleanMeasure {
  static constexpr std::size_t bit_words = 8;

  /// Edges of MA, and rising edges.
  std::uint32_t edges = 0;
  std::uint32_t rises = 0;
  /// Index of the falling edge of MA that begins the next request.
  std::uint32_t next_fall = 0;
  /// Changes of SLO before that edge.
  std::uint32_t changes = 0;
  std::int32_t last_edge = 0;
  std::int32_t second_rise = 0;
  /// SLO belongs to the request up to here.
  std::int32_t limit = 0;

  std::int32_t period = 0;
  std::int32_t jitter = 0;
  /// All highs of MA that end in the cycle, and their number.
  std::int32_t high = 0;
  std::int32_t highs = 0;
  /// The largest difference between two times of 1, 2, 4 or 8 periods; only if it is requested.
  std::int32_t clock_change = 0;

  /// SLO falls for ACK.
  std::int32_t fall = 0;
  /// From a rising edge of MA to the change of SLO that it makes.
  std::int32_t delay = 0;
  /// SLO at each rising edge of MA plus `delay` and half a period. The first two are LAT and ACK.
  std::array<std::uint8_t, 8 * bit_words> bytes{};
  /// The first sample that is within `margin` of a change of SLO; 2^31 - 1 if there is none.
  std::int32_t first_marginal = 0;

  BitView bits() const { return BitView(bytes, 0, rises); }
};

/// Options of the measurement.
struct CleanSetup {
  /// Taken off the margin of `marginal`, in picoseconds; see margin_doubt().
  std::int64_t margin_doubt = 0;
  bool clock_change = false;
};

/// The arrays that measure_clean() works with: one object for each thread, so that its memory stays
/// in the cache.
class CleanScratch {
 public:
  static constexpr std::size_t max_edges = 1024;
  /// Room for whole vectors past the last element.
  static constexpr std::size_t padding = 64;
  using Times = std::array<std::int32_t, max_edges + padding>;

  alignas(64) Times edges{};
  alignas(64) Times changes{};
  /// For each change the first sample that is not before it, the sample's edge of MA, and the edge
  /// before that.
  alignas(64) Times samples{};
  alignas(64) Times found{};
  alignas(64) Times found_before{};
};

/// False if the cycle is not clean: MA is uneven, a gap may be a pause, SLO changes at a wrong
/// time, or the end of the cycle is not in these arrays. The cycle must then be read edge by edge. A
/// clean cycle has the same values as from CycleReader and Decoder;
/// docs/decisions/house-0019-flow.md explains why.
bool measure_clean(const CleanLines& lines, const CleanSetup& setup, CleanScratch& scratch,
                   CleanMeasure& found);

}  // namespace biss::decode
