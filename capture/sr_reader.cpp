#include "capture/sr_reader.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <variant>

#include "capture/inflate.hpp"
#include "capture/sampled_source.hpp"
#include "capture/sr_metadata.hpp"
#include "capture/zip_archive.hpp"

namespace biss::capture {
namespace {

// Inflated at once; PulseView's chunks have 10 MiB. Larger members are read in pieces.
constexpr std::uint64_t most_at_once = 32U * 1024U * 1024U;
constexpr std::size_t stream_piece_bytes = 1024U * 1024U;
constexpr std::size_t max_metadata_bytes = 1024U * 1024U;

// Memory that grows and is not filled with zeros first.
class Buffer {
 public:
  std::span<std::uint8_t> take(std::size_t bytes) {
    if (bytes > capacity_) {
      bytes_ = std::make_unique_for_overwrite<std::uint8_t[]>(bytes);
      capacity_ = bytes;
    }
    return {bytes_.get(), bytes};
  }

 private:
  std::unique_ptr<std::uint8_t[]> bytes_;
  std::size_t capacity_ = 0;
};

class SrPieces final : public SamplePieces {
 public:
  SrPieces(std::unique_ptr<ZipArchive> archive, std::string capture_file)
      : archive_(std::move(archive)), capture_file_(std::move(capture_file)) {
    chunks_ = archive_->count_numbered(capture_file_ + '-');
  }

  Result<std::span<const std::uint8_t>, CaptureError> next() override {
    for (;;) {
      if (streaming_) {
        const auto piece = next_of_stream();
        if (!piece.ok() || !piece->empty()) return piece;
        streaming_ = false;
      }
      const auto member = next_member();
      if (!member) return ended();
      if (member->size_bytes == 0) continue;
      if (member->size_bytes / max_deflate_ratio > member->compressed_bytes) {
        return damaged("a size that the compressed data can have");
      }
      if (member->deflated && member->size_bytes <= most_at_once) return inflate(*member);
      if (!archive_->begin_stream(*member)) return damaged("data that can be read");
      streaming_ = true;
      stream_left_ = member->size_bytes;
    }
  }

 private:
  using Piece = Result<std::span<const std::uint8_t>, CaptureError>;

  // A session has one member with all the samples, or chunks.
  std::optional<ZipMember> next_member() {
    if (whole_) return std::nullopt;
    if (chunk_ == 0) {
      if (const auto member = archive_->find(capture_file_)) {
        whole_ = true;
        return member;
      }
    }
    return archive_->find(capture_file_ + '-' + std::to_string(++chunk_));
  }

  // Behind the last chunk, or at one that is missing.
  Piece ended() const {
    if (!whole_ && chunk_ <= chunks_) return damaged("every chunk up to the last");
    return std::span<const std::uint8_t>{};
  }

  Failure<CaptureError> damaged(const char* expected) const {
    return failure(CaptureError{.cause = CaptureCause::damaged,
                                .expected = expected,
                                .part = whole_ ? "the samples" : "chunk",
                                .part_number = chunk_});
  }

  Piece inflate(const ZipMember& member) {
    const auto bytes = samples_.take(static_cast<std::size_t>(member.size_bytes));
    // Data that does not shrink is a little longer deflated; what is much longer is not read whole.
    if (member.compressed_bytes > 2 * most_at_once) return damaged("data that compression shrank");
    const auto compressed = compressed_.take(static_cast<std::size_t>(member.compressed_bytes));
    if (!archive_->read_compressed(member, compressed)) return damaged("data that can be read");
    if (!inflater_.inflate(compressed, bytes)) return damaged("data that inflates to its size");
    if (zip_checksum(bytes) != member.checksum) return damaged("data with its checksum");
    return std::span<const std::uint8_t>(bytes);
  }

  Piece next_of_stream() {
    // One byte more than is left shows whether the member ends there.
    const auto room = std::min<std::uint64_t>(stream_left_ + 1, stream_piece_bytes);
    const auto bytes = samples_.take(static_cast<std::size_t>(room));
    const auto got = archive_->read_stream(bytes);
    if (!got || *got > stream_left_) return damaged("data that inflates to its size and checksum");
    if (*got == 0 && stream_left_ != 0) return damaged("data that inflates to its size");
    stream_left_ -= *got;
    return std::span<const std::uint8_t>(bytes.first(*got));
  }

  std::unique_ptr<ZipArchive> archive_;
  std::string capture_file_;
  std::uint64_t chunks_ = 0;  // in the archive
  std::uint64_t chunk_ = 0;   // last asked for
  bool whole_ = false;
  bool streaming_ = false;
  std::uint64_t stream_left_ = 0;
  Inflater inflater_;
  Buffer samples_;
  Buffer compressed_;
};

Opened no_session(const ZipArchive& archive) {
  const char* expected = "a sigrok session; this ZIP archive is something else";
  if (archive.find("header")) expected = "a sigrok session; this is a DSLogic capture";
  if (archive.find("meta.json")) expected = "a sigrok session; this is a .sal of Saleae Logic";
  return {nullptr, {.cause = CaptureCause::unknown_format, .expected = expected}};
}

Opened damaged_part(CaptureCause cause, const char* part, const char* expected) {
  return {nullptr, {.cause = cause, .expected = expected, .part = part}};
}

}  // namespace

bool looks_like_zip(std::string_view head) {
  return head.starts_with("PK\x03\x04") || head.starts_with("PK\x05\x06");
}

Opened open_sr(std::unique_ptr<ByteSource> bytes) {
  auto [archive, error] = ZipArchive::open(std::move(bytes));
  if (!archive) return {nullptr, error};
  const auto version = archive->find("version");
  const auto metadata = archive->find("metadata");
  if (!version || !metadata) return no_session(*archive);
  const auto version_text = archive->read_text(*version, max_metadata_bytes);
  const auto metadata_text = archive->read_text(*metadata, max_metadata_bytes);
  if (!version_text) return damaged_part(CaptureCause::damaged, "version", "1 or 2");
  if (!version_text->starts_with('1') && !version_text->starts_with('2')) {
    return damaged_part(CaptureCause::malformed, "version", "1 or 2");
  }
  if (!metadata_text) return damaged_part(CaptureCause::damaged, "metadata", "text of up to 1 MiB");
  auto parsed = parse_sr_metadata(*metadata_text);
  if (const auto* fault = std::get_if<CaptureError>(&parsed)) return {nullptr, *fault};
  auto& [layout, capture_file] = std::get<SrMetadata>(parsed);
  return open_samples(layout,
                      std::make_unique<SrPieces>(std::move(archive), std::move(capture_file)));
}

}  // namespace biss::capture
