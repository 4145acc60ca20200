// The members of a ZIP archive.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "capture/byte_source.hpp"
#include "capture/edge_source.hpp"

struct zip;
struct zip_file;

namespace biss::capture {

/// What the archive's directory says of a member; not yet known to be true.
struct ZipMember {
  std::uint64_t index = 0;
  std::uint64_t size_bytes = 0;
  std::uint64_t compressed_bytes = 0;
  std::uint32_t checksum = 0;
  bool deflated = false;  ///< and not encrypted: read_compressed() gives what an Inflater takes
};

class ZipArchive;

struct OpenedZip {
  std::unique_ptr<ZipArchive> archive;
  CaptureError error;
};

/// Finds members and gives their bytes. One thread at a time; what read_compressed() has given may
/// be inflated by others meanwhile.
class ZipArchive {
 public:
  /// Opens the archive that `bytes` are. A regular file is read where it lies; anything else goes
  /// into memory first, or beyond 16 MiB into a temporary file without a name. Fails with
  /// `read_failed`, or with `damaged` when the directory is missing or its members claim more bytes
  /// than the file has (they overlap: a bomb).
  static OpenedZip open(std::unique_ptr<ByteSource> bytes);

  ~ZipArchive();
  ZipArchive(const ZipArchive&) = delete;
  ZipArchive& operator=(const ZipArchive&) = delete;

  std::optional<ZipMember> find(const std::string& name) const;
  /// Number of members whose names are `name_begins` and a number from 1.
  std::uint64_t count_numbered(std::string_view name_begins) const;

  /// The member's compressed bytes; false when they cannot be read.
  /// \pre into.size() == member.compressed_bytes
  bool read_compressed(const ZipMember& member, std::span<std::uint8_t> into);

  /// A small member as it was before compression; nothing when it cannot be read, is damaged, or
  /// has more than `max_bytes`.
  std::optional<std::string> read_text(const ZipMember& member, std::size_t max_bytes);

  /// Reads a member of any size and compression piece by piece, slower than an Inflater. False when
  /// it cannot be opened.
  bool begin_stream(const ZipMember& member);
  /// The next bytes, 0 at the end; nothing when the data is damaged. \pre begin_stream() gave true
  std::optional<std::size_t> read_stream(std::span<std::uint8_t> into);

 private:
  struct CloseArchive {
    void operator()(zip* archive) const;
  };
  struct CloseFile {
    void operator()(zip_file* file) const;
  };

  ZipArchive() = default;
  std::optional<CaptureError> open_source(std::unique_ptr<ByteSource> bytes);
  bool members_overlap(std::uint64_t file_bytes) const;

  std::string memory_;  // outlives the archive that reads it
  std::unique_ptr<zip, CloseArchive> archive_;
  std::unique_ptr<zip_file, CloseFile> stream_;
};

}  // namespace biss::capture
