// ZIP archives: deflated data, reading at any place, and writing from front to back.
#pragma once

#include <libdeflate.h>
#include <zip.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"

namespace biss::capture {

/// A byte of deflated data makes at most this many bytes.
inline constexpr std::uint64_t max_deflate_ratio = 1'032;

/// The frame around deflated data: nothing, or header and checksum of RFC 1950 or RFC 1952.
enum class DeflateFrame : std::uint8_t { none, zlib, gzip };

class Inflater {
 public:
  Inflater();

  /// Whether `deflated` is complete and makes exactly `into.size()` bytes, which are then in
  /// `into`.
  bool inflate(std::span<const std::uint8_t> deflated, std::span<std::uint8_t> into,
               DeflateFrame frame = DeflateFrame::none);

 private:
  std::unique_ptr<libdeflate_decompressor, Released<libdeflate_free_decompressor>> decompressor_;
};

class Deflater {
 public:
  Deflater();

  /// Appends `bytes` deflated to `out`.
  void deflate(std::span<const std::uint8_t> bytes, std::string& out);
  /// `bytes` as a gzip file without a name and a time.
  std::string gzip(std::string_view bytes);

 private:
  std::unique_ptr<libdeflate_compressor, Released<libdeflate_free_compressor>> compressor_;
};

/// The CRC-32 of ZIP.
std::uint32_t zip_checksum(std::span<const std::uint8_t> bytes);
/// Continues a CRC-32. `before` is the CRC-32 of all earlier bytes; 0 if there are none.
std::uint32_t zip_checksum_after(std::uint32_t before, std::span<const std::uint8_t> bytes);

/// Whether a file that begins in this way may be a ZIP archive.
bool looks_like_zip(std::string_view head);

/// The entry of a member in the archive's directory. It is not verified yet.
struct ZipMember {
  std::uint64_t index = 0;
  std::uint64_t size_bytes = 0;
  std::uint64_t compressed_bytes = 0;
  std::uint32_t checksum = 0;
  bool deflated = false;  ///< and not encrypted: read_compressed() returns data for an Inflater
};

/// Refuses the member of that name, which would not be read.
CaptureError unread_member(std::string_view name, const char* expected);

class ZipArchive;

using OpenedZip = tl::expected<std::unique_ptr<ZipArchive>, CaptureError>;

/// Finds members and gives their bytes. One thread at a time; the data from read_compressed() may
/// be inflated by other threads meanwhile.
class ZipArchive {
 public:
  /// Opens the archive in `bytes`. A regular file is read directly; anything else goes into memory
  /// first, or beyond 16 MiB into a temporary file without a name. Fails with `read_failed`, with
  /// `damaged` when the directory is missing or its members claim more bytes than the file has
  /// (they overlap: a bomb), or with `malformed` when two members have one name.
  static OpenedZip open(std::unique_ptr<ByteSource> bytes);

  std::optional<ZipMember> find(const std::string& name) const;
  /// The names of all members that begin in this way.
  std::vector<std::string> names(std::string_view begin) const;

  /// The member's compressed bytes; false when they cannot be read.
  /// \pre into.size() == member.compressed_bytes
  bool read_compressed(const ZipMember& member, std::span<std::uint8_t> into);

  /// A small member as it was before compression; nothing when it cannot be read, is damaged, or
  /// has more than `max_bytes`.
  std::optional<std::string> read_text(const ZipMember& member, std::size_t max_bytes);

  /// Reads a member of any compression. False when it is damaged or has another size.
  bool read_whole(const ZipMember& member, std::span<std::uint8_t> into);

  /// Reads a member of any size and compression piece by piece, slower than an Inflater. False when
  /// it cannot be opened.
  bool begin_stream(const ZipMember& member);
  /// The next bytes, 0 at the end; nothing when the data is damaged. \pre begin_stream() returned
  /// true
  std::optional<std::size_t> read_stream(std::span<std::uint8_t> into);

 private:
  using File = std::unique_ptr<zip_file_t, Released<zip_fclose>>;

  ZipArchive() = default;
  bool members_overlap(std::uint64_t file_bytes) const;

  std::string memory_;  // outlives the archive that reads it
  std::unique_ptr<zip_t, Released<zip_discard>> archive_;
  File stream_;
};

/// Appends members to a string, which the owner passes on at any time. Dates are 1 January 1980, so
/// that equal captures make equal files.
class ZipWriter {
 public:
  /// Appends a member, deflated. False when the archive would pass 4 GiB or 65535 members; then
  /// nothing is appended. \pre the text has fewer than 4 GiB
  bool add(std::string_view name, std::string_view text, std::string& out);

  /// Appends the directory.
  void finish(std::string& out);

 private:
  struct Member {
    std::string name;
    std::uint32_t checksum;
    std::uint32_t compressed_bytes;
    std::uint32_t size_bytes;
    std::uint32_t place;
  };

  static void put_fields(std::string& out, const Member& member);

  Deflater deflater_;
  std::vector<Member> members_;
  std::uint64_t written_bytes_ = 0;
  std::uint64_t directory_bytes_ = 0;
};

}  // namespace biss::capture
