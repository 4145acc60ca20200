// Edges as a sigrok session.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "capture/sampled_writer.hpp"
#include "capture/zip_writer.hpp"

namespace biss::capture {

/// Writes a `.sr`: version, metadata, and samples in deflated chunks of 4 MiB. Line k is probe
/// k + 1; up to 64 lines. It holds back one chunk. Fails with `too_large` when the archive would
/// pass 4 GiB or 65535 chunks; see SampledWriter for the rest.
class SrWriter final : public SampledWriter {
 public:
  /// \pre rate is not 0 Hz
  SrWriter(const std::vector<std::string>& lines, Hertz rate, ByteSink& sink);

 private:
  bool put_samples(std::string_view bytes) override;
  void put_close() override;
  bool put_chunk();

  ZipWriter archive_;
  std::string chunk_;
  std::uint64_t chunks_ = 0;
};

}  // namespace biss::capture
