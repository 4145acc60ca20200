#include "capture/sr.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "capture/key_file.hpp"
#include "capture/text_source.hpp"

namespace biss::capture {
namespace {

class Metadata final : public SamplesDescription {
 public:
  Metadata() : SamplesDescription({"metadata", "[section] or key=value", 1, "probe1 to probe64"}) {}

  tl::expected<SrMetadata, CaptureError> parse(std::string_view text) {
    if (const auto error = read(text)) return tl::unexpected(*error);
    return SrMetadata{layout_, capture_file_};
  }

 private:
  bool begin_section(std::string_view row) override {
    if (row == device_ && !capture_file_.empty()) return wrong("each device once");
    if (done_) return true;
    if (in_device_ && !capture_file_.empty()) return done_ = complete();
    in_device_ = row.starts_with("[device ") && row.back() == ']';
    device_ = row;
    layout_.unit_bytes = 0;
    capture_file_.clear();
    rate_ = {};
    probes_.clear();
    return true;
  }

  bool take_key(std::string_view key, std::string_view value) override {
    if (!in_device_) return true;
    if (key != "unitsize") return SamplesDescription::take_key(key, value);
    if (layout_.unit_bytes != 0) return wrong("the unitsize once");
    const auto bytes = whole_number<unsigned>(value);
    if (!bytes || *bytes < 1 || *bytes > max_unit_bytes) return wrong("a unitsize of 1 to 8");
    layout_.unit_bytes = *bytes;
    return true;
  }

  bool complete() override {
    if (capture_file_.empty()) return wrong("a device with a capturefile of logic samples");
    if (rate_.count == 0) return wrong("the samplerate of the device");
    if (layout_.unit_bytes == 0) return wrong("the unitsize of the device");
    layout_.rate = rate_;
    for (const auto& [number, name] : probes_) layout_.lines.push_back({name, number - 1});
    if (layout_.lines.empty()) return wrong("the names of the device's probes");
    return fault_of(layout_) == nullptr || wrong("no more probes than unitsize has bits");
  }

  RawLayout layout_;
  std::string device_;  // its section
  bool in_device_ = false;
};

// Members up to this size are inflated in one piece; PulseView's chunks have 10 MiB. Larger members
// are read in pieces.
constexpr std::uint64_t most_at_once = 32U * 1024U * 1024U;
constexpr std::size_t max_metadata_bytes = 1024U * 1024U;

class SrPieces final : public SamplePieces {
 public:
  SrPieces(std::unique_ptr<ZipArchive> archive, std::string capture_file, bool verify)
      : archive_(std::move(archive)), capture_file_(std::move(capture_file)), verify_(verify) {
    chunks_ = archive_->names(capture_file_ + '-').size();
  }

  Result<bool, CaptureError> fetch(PackedSamples& piece, const FetchWish& wish) override {
    for (;;) {
      if (streaming_) {
        const auto got = fetch_of_stream(piece, wish.piece_bytes);
        if (!got.ok() || *got) return got;
        streaming_ = false;
      }
      const auto member = next_member();
      if (!member) return ended();
      if (member->size_bytes == 0) continue;
      if (member->size_bytes / max_deflate_ratio > member->compressed_bytes) {
        return damaged("a size that the compressed data can have");
      }
      if (member->deflated && member->size_bytes <= most_at_once) {
        const bool as_it_is = wish.at_sample && member->size_bytes % wish.unit_bytes == 0;
        return as_it_is ? fetch_deflated(*member, piece) : fetch_inflated(*member, piece);
      }
      if (!archive_->begin_stream(*member)) return damaged("data that can be read");
      streaming_ = true;
      stream_left_ = member->size_bytes;
    }
  }

 private:
  using Fetched = Result<bool, CaptureError>;

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

  // After the last chunk, or at one that is missing.
  Fetched ended() const {
    if (!whole_ && chunk_ <= chunks_) return damaged("every chunk up to the last");
    return false;
  }

  Failure<CaptureError> damaged(const char* expected) const {
    return failure(CaptureError{.cause = CaptureCause::damaged,
                                .expected = expected,
                                .part = whole_ ? "the samples" : "chunk",
                                .part_number = chunk_});
  }

  Fetched read_compressed(const ZipMember& member, Buffer& into) {
    // Data that does not shrink is a little longer deflated; much longer data is not read as a
    // whole.
    if (member.compressed_bytes > 2 * most_at_once)
      return damaged("data that is smaller after compression");
    const auto compressed = into.take(static_cast<std::size_t>(member.compressed_bytes));
    if (!archive_->read_compressed(member, compressed)) return damaged("data that can be read");
    return true;
  }

  Fetched fetch_deflated(const ZipMember& member, PackedSamples& piece) {
    compressed_ = Buffer();  // for bytes that are inflated here only
    const auto read = read_compressed(member, piece.memory);
    if (!read.ok()) return read;
    piece.bytes = piece.memory.take(static_cast<std::size_t>(member.compressed_bytes));
    piece.deflated = {.size_bytes = member.size_bytes,
                      .checksum = member.checksum,
                      .damaged = damaged(nullptr).error};
    return true;
  }

  Fetched fetch_inflated(const ZipMember& member, PackedSamples& piece) {
    const auto read = read_compressed(member, compressed_);
    if (!read.ok()) return read;
    const auto compressed = compressed_.take(static_cast<std::size_t>(member.compressed_bytes));
    const auto bytes = piece.room(static_cast<std::size_t>(member.size_bytes));
    if (!inflater_.inflate(compressed, bytes)) return damaged("data that inflates to its size");
    if (verify_ && zip_checksum(bytes) != member.checksum) return damaged("data with its checksum");
    piece.bytes = bytes;
    return true;
  }

  Fetched fetch_of_stream(PackedSamples& piece, std::size_t piece_bytes) {
    // One byte more than the directory states shows whether the member ends there. It is read apart
    // from the bytes before it, which are samples with any size of the pieces.
    const auto room = stream_left_ == 0 ? 1 : std::min<std::uint64_t>(stream_left_, piece_bytes);
    const auto bytes = piece.room(static_cast<std::size_t>(room));
    const auto got = archive_->read_stream(bytes);
    if (!got || *got > stream_left_) return damaged("data that inflates to its size and checksum");
    if (*got == 0 && stream_left_ != 0) return damaged("data that inflates to its size");
    stream_left_ -= *got;
    piece.bytes = bytes.first(*got);
    return *got != 0;
  }

  std::unique_ptr<ZipArchive> archive_;
  std::string capture_file_;
  bool verify_;
  std::uint64_t chunks_ = 0;  // in the archive
  std::uint64_t chunk_ = 0;   // last requested
  bool whole_ = false;
  bool streaming_ = false;
  std::uint64_t stream_left_ = 0;
  Inflater inflater_;
  Buffer compressed_;
};

// Names a member that is not read although its name begins with the name of the capture; also such
// a member in a folder, or in upper or lower case.
std::optional<CaptureError> find_unread(const ZipArchive& archive,
                                        const std::string& capture_file) {
  constexpr std::size_t most_digits = 10;
  const std::vector<std::string> names = archive.names(capture_file);
  for (const std::string& name : archive.names("")) {
    if (name.starts_with(capture_file)) continue;
    if (lower_case(name.substr(name.rfind('/') + 1)).starts_with(lower_case(capture_file))) {
      return unread_member(name, "the samples under the name that the metadata gives");
    }
  }
  for (const std::string& name : names) {
    const std::string_view rest = std::string_view(name).substr(capture_file.size());
    const bool is_chunk = rest.size() > 1 && rest.size() <= 1 + most_digits && rest[0] == '-' &&
                          rest[1] != '0' &&
                          rest.find_first_not_of("0123456789", 1) == std::string_view::npos;
    if (rest.empty() ? names.size() == 1 : is_chunk) continue;
    return unread_member(name, "all samples in one member, or in chunks with numbers from 1");
  }
  return std::nullopt;
}

Opened no_session(const ZipArchive& archive) {
  const char* expected = "a sigrok session or a DSLogic capture; this ZIP archive is neither";
  if (archive.find("meta.json")) {
    expected =
        "an export of Saleae Logic; this is its .sal: in Logic 2, export the raw data as CSV "
        "or binary";
  }
  return tl::unexpected(CaptureError{.cause = CaptureCause::unknown_format, .expected = expected});
}

Opened damaged_part(CaptureCause cause, const char* part, const char* expected) {
  return tl::unexpected(CaptureError{.cause = cause, .expected = expected, .part = part});
}

// The size of sigrok-cli's chunks. Runs of samples divide it, so that chunks hold whole samples.
constexpr std::size_t chunk_bytes = 4U * 1024U * 1024U;

}  // namespace

tl::expected<SrMetadata, CaptureError> parse_sr_metadata(std::string_view text) {
  return Metadata().parse(text);
}

std::string sr_metadata_text(const RawLayout& layout) {
  std::string text = "[global]\nsigrok version=0.5.2\n\n[device 1]\ncapturefile=logic-1\n";
  text += "total probes=" + std::to_string(layout.lines.size()) + '\n';
  text += "samplerate=" + sample_rate_text(layout.rate) + '\n';
  text += "total analog=0\n";
  for (const SampleLine& line : layout.lines) {
    text += "probe" + std::to_string(line.bit + 1) + '=' + escaped(line.name) + '\n';
  }
  return text + "unitsize=" + std::to_string(layout.unit_bytes) + '\n';
}

Opened open_sr(std::unique_ptr<ZipArchive> archive, const SampleReading& reading) {
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
  if (!parsed) return tl::unexpected(parsed.error());
  auto& [layout, capture_file] = *parsed;
  return open_zip_samples(layout, std::move(archive), std::move(capture_file), reading);
}

Opened open_zip_samples(const RawLayout& layout, std::unique_ptr<ZipArchive> archive,
                        std::string name, const SampleReading& reading) {
  if (const auto error = find_unread(*archive, name)) return tl::unexpected(*error);
  return open_samples(
      layout, std::make_unique<SrPieces>(std::move(archive), std::move(name), reading.verify),
      reading);
}

SrWriter::SrWriter(const std::vector<std::string>& lines, Hertz rate, ByteSink& sink)
    : SampledWriter(packed_layout(lines, rate), sink) {
  if (lines.size() > 8 * max_unit_bytes) return;
  archive_.add("version", "2", text());
  archive_.add("metadata", sr_metadata_text(packed_layout(lines, rate)), text());
}

bool SrWriter::put_samples(std::string_view bytes) {
  if (chunk_.size() + bytes.size() > chunk_bytes && !put_chunk()) return false;
  chunk_ += bytes;
  return true;
}

bool SrWriter::put_chunk() {
  if (!archive_.add("logic-1-" + std::to_string(++chunks_), chunk_, text())) {
    refuse(WriteCause::too_large);
  }
  chunk_.clear();
  return flush_full();
}

void SrWriter::put_close() {
  if (put_chunk()) archive_.finish(text());
}

}  // namespace biss::capture
