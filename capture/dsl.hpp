// DSLogic captures (`.dsl`), as DSView saves them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"
#include "capture/samples.hpp"
#include "capture/zip.hpp"

namespace biss::capture {

/// Samples of one probe in a block of version 2 or 3: one bit each, the first in bit 0.
inline constexpr std::uint64_t dsl_block_samples = std::uint64_t{1} << 24U;

struct DslHeader {
  unsigned version = 1;
  Hertz rate;
  std::uint64_t total_samples = 0;
  /// For each probe; 0 if the header has no count.
  std::uint64_t total_blocks = 0;
  std::string capture_file;       ///< member with the samples of version 1
  std::vector<SampleLine> lines;  ///< probes by their numbers, from 0

  /// The blocks that each probe needs for the total samples.
  std::uint64_t needed_blocks() const {
    return total_samples / dsl_block_samples + (total_samples % dsl_block_samples != 0);
  }
};

/// Reads the member `header`. Keys that do not concern logic samples are skipped. Fails with
/// `malformed`, and with `unknown_format` for captures of DSView's oscilloscope and data logger.
tl::expected<DslHeader, CaptureError> parse_dsl_header(std::string_view text);

/// Opens a ZIP archive: a DSLogic capture of version 1 to 3, or a sigrok session (see open_sr()).
/// Delivers the changes of the probes.
///
/// Version 1 has one member of two-byte samples with probe K at bit K. Versions 2 and 3 have the
/// blocks `L-K/B` of each probe K, of which the last may be shorter. A block of every probe is in
/// memory at a time: up to 2 MiB for each probe, and at most 64 probes. DSView stores whole bytes: up
/// to 63 samples that the header counts may be missing at the end.
///
/// Fails with `read_failed`, `unknown_format`, `damaged` (as open_sr(); a block that is missing or
/// differs in size from the blocks of the other probes), `malformed` (header; a block that the
/// header does not count), `empty`, `truncated` (fewer samples than the header has) and
/// `time_out_of_range`.
/// Source: DSView, storesession.cpp and session_driver.c.
Opened open_zip(std::unique_ptr<ByteSource> bytes, const SampleReading& reading = {});

/// Writes a DSLogic capture of version 3. Line k is probe k; up to 64 lines. It holds back a block of
/// every line, 2 MiB each. Fails with `too_large` when the archive would pass 4 GiB or 65535 members;
/// see SampledWriter for the rest.
class DslWriter final : public SampledWriter {
 public:
  /// \pre rate is not 0 Hz
  DslWriter(const std::vector<std::string>& lines, Hertz rate, ByteSink& sink);

 private:
  bool put_samples(std::string_view bytes) override;
  void put_close() override;
  void put_bits(std::uint64_t samples);
  bool put_block();

  RawLayout layout_;
  ZipWriter archive_;
  std::vector<std::string> planes_;
  std::uint64_t sample_ = 0;         // the last
  std::uint64_t block_samples_ = 0;  // in the planes
  std::uint64_t total_samples_ = 0;
  std::uint64_t blocks_ = 0;
};

}  // namespace biss::capture
