// sigrok sessions (`.sr`), as sigrok-cli and PulseView save them.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"
#include "capture/samples.hpp"
#include "capture/zip.hpp"

namespace biss::capture {

struct SrMetadata {
  RawLayout layout;
  std::string capture_file;  ///< member with the samples, or the beginning of its chunks' names
};

/// Reads the first device that has logic samples. Sections and keys that do not concern these
/// samples are skipped; if a key occurs twice, the last one counts. Fails with `malformed`: a line
/// that is no `key=value`, an impossible rate, unit size or probe, or nothing about logic samples.
tl::expected<SrMetadata, CaptureError> parse_sr_metadata(std::string_view text);

/// The metadata that our own files have. \pre fault_of(layout) is null
std::string sr_metadata_text(const RawLayout& layout);

/// Opens a sigrok session of version 1 or 2 and delivers the changes of its logic probes.
///
/// The samples are one member or numbered chunks, which need not hold whole samples. One chunk at a
/// time is inflated, or a part of one that has more than 32 MiB, so that memory does not grow with
/// the capture. Checksums are verified, unless `reading` switches this off and a member has at most
/// 32 MiB. Analog members are skipped.
///
/// Fails with `read_failed`, `unknown_format` (another kind of archive), `damaged` (no directory,
/// members that overlap, data that does not inflate to the size and checksum the directory has, a
/// chunk that is missing between others), `malformed` (metadata; a member that begins with the name
/// of the capture and is not a chunk; two members of one name), `empty`, `truncated` (the last
/// sample is incomplete) and `time_out_of_range`.
Opened open_sr(std::unique_ptr<ZipArchive> archive, const SampleReading& reading);

/// Opens the samples of the member `name`, or of its numbered chunks `name-1`, `name-2`, … Fails as
/// open_samples(), and with `malformed` if the name of another member begins with `name`.
Opened open_zip_samples(const RawLayout& layout, std::unique_ptr<ZipArchive> archive,
                        std::string name, const SampleReading& reading);

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
