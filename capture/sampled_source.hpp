// What every reader of samples shares: pieces of bytes in, blocks of edges out.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "capture/edge_source.hpp"
#include "capture/sample_layout.hpp"

namespace biss::capture {

/// The bytes of all samples, in order, in pieces of any length.
class SamplePieces {
 public:
  virtual ~SamplePieces() = default;

  /// The next bytes, valid until the next call; empty at the end. Not called again after an error.
  virtual Result<std::span<const std::uint8_t>, CaptureError> next() = 0;
};

/// The samples as edges. A capture without a whole sample is `empty`; one that ends inside a sample
/// is `truncated`, behind its edges; samples beyond 106 days are `time_out_of_range`. Fails at once
/// with `bad_layout`.
Opened open_samples(const RawLayout& layout, std::unique_ptr<SamplePieces> pieces);

}  // namespace biss::capture
