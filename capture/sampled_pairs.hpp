// Samples of several bytes as changes of two lines, piece by piece.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "capture/pair_source.hpp"
#include "capture/samples.hpp"

namespace biss::capture {

/// The samples of a capture, and the bits of the two lines in them.
struct PairLayout {
  SampleClock clock;
  std::size_t unit_bytes = 1;
  unsigned ma_bit = 0;
  unsigned slo_bit = 0;
  wire::LineIndex ma = 0;
  wire::LineIndex slo = 0;
};

/// How far the samples have been read as edges.
struct SamplesRead {
  std::uint64_t samples = 0;
  std::uint64_t last_sample = 0;
  /// Bytes that were read but are not in these samples. They begin at a sample.
  std::vector<std::uint8_t> bytes;
  bool ended = false;
  std::optional<CaptureError> error;  ///< why they have ended
};

/// Samples that are scanned at once.
inline constexpr std::size_t scan_samples = 4'096;

/// A piece with more changes of both lines does not become arrays: each of them takes 8 bytes, a
/// sample perhaps one. Its samples are scanned again when it is settled, and become edges.
inline constexpr std::size_t most_changes = std::size_t{1} << 22U;

/// The rest of the samples. `pieces` outlives it. An error of a piece that is not deflated is found
/// by fetch() already; then a piece without samples brings it to settle(), after the whole samples
/// before the error.
std::unique_ptr<PairSource> sampled_pairs(SamplePieces& pieces, const PairLayout& layout,
                                          const SampleReading& reading, SamplesRead read);

}  // namespace biss::capture
