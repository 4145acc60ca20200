#include "capture/dsl.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <span>
#include <utility>

#include "capture/buffer.hpp"
#include "capture/decimal.hpp"
#include "capture/key_file.hpp"
#include "capture/sr.hpp"

namespace biss::capture {
namespace {

constexpr unsigned newest_version = 3;
constexpr std::size_t unit_bytes_of_version_1 = 2;
constexpr std::size_t max_header_bytes = 1024U * 1024U;
constexpr std::uint64_t word_bits = 64;

class HeaderParser final : public SamplesDescription {
 public:
  HeaderParser()
      : SamplesDescription({"header", "[section] or key = value", 0, "probe0 to probe63"}) {}

  tl::expected<DslHeader, CaptureError> parse(std::string_view text) {
    if (const auto error = read(text)) return tl::unexpected(*error);
    found_.rate = rate_;
    found_.capture_file = capture_file_;
    return std::move(found_);
  }

 private:
  bool begin_section(std::string_view row) override {
    in_version_ = row == "[version]";
    in_header_ = row.starts_with("[header");
    return true;
  }

  bool take_key(std::string_view key, std::string_view value) override {
    if (in_version_ && key == "version") return take_version(value);
    if (!in_header_) return true;
    if (key == "device mode") {
      return value == "0" || wrong(other_mode, CaptureCause::unknown_format);
    }
    if (key == "total samples") return take_count(value, found_.total_samples);
    if (key == "total blocks") return take_count(value, found_.total_blocks);
    return SamplesDescription::take_key(key, value);
  }

  bool take_version(std::string_view value) {
    const auto version = whole_number<unsigned>(value);
    if (!version || *version == 0 || *version > newest_version) {
      return wrong("version 1, 2 or 3 of DSView's captures");
    }
    found_.version = *version;
    return true;
  }

  bool take_count(std::string_view value, std::uint64_t& count) {
    const auto number = whole_number<std::uint64_t>(value);
    if (!number) return wrong("a whole number");
    if (count != 0) return wrong("this number once");
    count = *number;
    return true;
  }

  bool complete() override {
    for (const auto& [number, name] : probes_) found_.lines.push_back({name, number});
    if (rate_.count == 0) return wrong("the samplerate");
    if (found_.lines.empty()) return wrong("the names of the probes");
    if (found_.version != 1) {
      return found_.total_blocks <= found_.needed_blocks() ||
             wrong("no more total blocks than the total samples fill");
    }
    if (capture_file_.empty()) return wrong("the capturefile");
    return probes_.rbegin()->first < 8 * unit_bytes_of_version_1 ||
           wrong("probe0 to probe15 in version 1");
  }

  static constexpr const char* other_mode =
      "a capture of the logic analyser (device mode 0); export it from DSView as CSV";

  DslHeader found_;
  bool in_version_ = false;
  bool in_header_ = false;
};

// The samples of all probes put together: bit k of a sample is from the k-th probe.
class DslPieces final : public SamplePieces {
 public:
  DslPieces(std::unique_ptr<ZipArchive> archive, const DslHeader& header, bool verify)
      : archive_(std::move(archive)),
        lines_(header.lines),
        verify_(verify),
        last_index_(SampleClock(header.rate).last_index()),
        total_samples_(header.total_samples),
        blocks_(header.total_blocks == 0 ? header.needed_blocks() : header.total_blocks),
        unit_bytes_((lines_.size() + 7) / 8),
        planes_(lines_.size()) {}

  Result<bool, CaptureError> fetch(PackedSamples& piece, const FetchWish&) override {
    do {
      if (at_ == samples_) {
        const auto more = load_block();
        if (!more.ok() || !*more) return more;
      }
      join_planes(piece);
    } while (piece.bytes.empty());
    return true;
  }

 private:
  static constexpr std::uint64_t plane_bytes = dsl_block_samples / 8;
  // A block that is deflated to more than this does not come from DSView; it is inflated as it is
  // read.
  static constexpr std::uint64_t most_compressed = 2 * plane_bytes;
  // A multiple of 64, so that every piece begins with a whole word of each plane.
  static constexpr std::uint64_t samples_of_piece = std::uint64_t{1} << 17U;

  Failure<CaptureError> damaged(const char* expected) const {
    return failure(CaptureError{.cause = CaptureCause::damaged,
                                .expected = expected,
                                .part = "block",
                                .part_number = block_});
  }

  // False at the end.
  Result<bool, CaptureError> load_block() {
    before_ += samples_;
    at_ = samples_ = 0;
    if (block_ == blocks_) {
      if (before_ == 0) return failure(CaptureError{.cause = CaptureCause::empty});
      // DSView stores whole bytes of whole words.
      if (total_samples_ - before_ < word_bits) return false;
      return failure(CaptureError{.cause = CaptureCause::truncated,
                                  .expected = "as many samples as the header gives"});
    }
    ++block_;
    const char* const fault = find_planes();
    for (std::size_t i = 0; i < members_.size(); ++i) {
      if (!read_plane(members_[i], planes_[i])) {
        return damaged("data that inflates to its size and checksum");
      }
    }
    if (fault != nullptr) return damaged(fault);
    const std::uint64_t held = 8 * members_.front().size_bytes;
    samples_ = std::min({total_samples_ - before_, dsl_block_samples, held});
    if (block_ != blocks_ && samples_ != dsl_block_samples) {
      return damaged("2 MiB in every block but the last");
    }
    if (held - samples_ >= word_bits) return damaged("no more samples than the header gives");
    return true;
  }

  // Returns the first fault that the directory shows.
  const char* find_planes() {
    members_.clear();
    for (const SampleLine& line : lines_) {
      const auto member =
          archive_->find("L-" + std::to_string(line.bit) + '/' + std::to_string(block_ - 1));
      if (!member) return "this block of every probe";
      if (member->size_bytes > plane_bytes) return "at most 2 MiB";
      if (member->size_bytes / max_deflate_ratio > member->compressed_bytes) {
        return "a size that the compressed data can have";
      }
      members_.push_back(*member);
      if (member->size_bytes != members_.front().size_bytes) {
        return "blocks of the same size for all probes";
      }
    }
    return nullptr;
  }

  // The bits between the last sample and the end of its word are 0.
  bool read_plane(const ZipMember& member, std::string& words) {
    const auto bytes = static_cast<std::size_t>(member.size_bytes);
    words.assign((bytes + 7) / 8 * 8, '\0');
    const std::span plane(reinterpret_cast<std::uint8_t*>(words.data()), bytes);
    if (!member.deflated || member.compressed_bytes > most_compressed) {
      return archive_->read_whole(member, plane);
    }
    const auto packed = packed_.take(static_cast<std::size_t>(member.compressed_bytes));
    return archive_->read_compressed(member, packed) && inflater_.inflate(packed, plane) &&
           (!verify_ || zip_checksum(plane) == member.checksum);
  }

  // The next samples of the block. Samples beyond the last time that can be represented are left
  // out if they are all like the one before.
  void join_planes(PackedSamples& piece) {
    const std::uint64_t first = before_ + at_;
    const std::size_t count = static_cast<std::size_t>(std::min(samples_ - at_, samples_of_piece));
    const std::size_t words = (count + word_bits - 1) / word_bits;
    const auto room = piece.room(words * word_bits * unit_bytes_ + max_unit_bytes);
    for (std::size_t i = 0; i < words; ++i) {
      join_word(static_cast<std::size_t>(at_ / word_bits) + i,
                room.data() + i * word_bits * unit_bytes_);
    }
    at_ += count;
    const auto sample = [&](std::size_t number) {
      std::uint64_t value = 0;
      std::memcpy(&value, room.data() + number * unit_bytes_, unit_bytes_);
      return value;
    };
    const std::uint64_t timed = first > last_index_ ? 0 : last_index_ + 1 - first;
    const auto usable = static_cast<std::size_t>(std::min<std::uint64_t>(count, timed));
    if (usable != 0) last_sample_ = sample(usable - 1);
    std::size_t end = usable;
    while (end < count && sample(end) == last_sample_) ++end;
    piece.bytes = room.first((end == count ? usable : count) * unit_bytes_);
  }

  // The samples of a word of each plane: runs of equal ones.
  void join_word(std::size_t word, std::uint8_t* into) {
    std::uint64_t starts = 1;
    for (std::size_t i = 0; i < planes_.size(); ++i) {
      levels_[i] = load_eight(planes_[i].data() + 8 * word);
      starts |= levels_[i] ^ levels_[i] << 1U;
    }
    while (starts != 0) {
      const auto begin = static_cast<unsigned>(std::countr_zero(starts));
      starts &= starts - 1;
      const auto end = static_cast<unsigned>(std::countr_zero(starts));  // 64 if there is no other
      std::uint64_t sample = 0;
      for (std::size_t i = 0; i < planes_.size(); ++i) sample |= (levels_[i] >> begin & 1U) << i;
      if (unit_bytes_ == 1) {
        std::memset(into + begin, static_cast<int>(sample), end - begin);
        continue;
      }
      // The bytes after the sample belong to the next one.
      for (std::size_t i = begin; i < end; ++i) {
        std::memcpy(into + i * unit_bytes_, &sample, sizeof sample);
      }
    }
  }

  std::unique_ptr<ZipArchive> archive_;
  std::vector<SampleLine> lines_;
  bool verify_;
  std::uint64_t last_index_;  // of a sample that has a time
  std::uint64_t total_samples_;
  std::uint64_t blocks_;  // of each probe
  std::size_t unit_bytes_;
  std::vector<ZipMember> members_;
  std::vector<std::string> planes_;
  std::array<std::uint64_t, 8 * max_unit_bytes> levels_{};  // of a word
  Inflater inflater_;
  Buffer packed_;
  std::uint64_t last_sample_ = 0;  // that has a time
  std::uint64_t block_ = 0;        // the one at hand, from 1
  std::uint64_t before_ = 0;       // samples of the blocks before it
  std::uint64_t samples_ = 0;      // of it
  std::uint64_t at_ = 0;           // the next of these
};

// The header counts every block in the archive and names its probe.
std::optional<CaptureError> find_unread_block(const ZipArchive& archive, const DslHeader& header) {
  for (const std::string& name : archive.names("L-")) {
    const std::size_t slash = std::min(name.find('/'), name.size() - 1);
    const auto block = whole_number<std::uint64_t>(std::string_view(name).substr(slash + 1));
    const bool is_read =
        block && *block < header.needed_blocks() &&
        std::any_of(header.lines.begin(), header.lines.end(), [&](const SampleLine& line) {
          return name == "L-" + std::to_string(line.bit) + '/' + std::to_string(*block);
        });
    if (!is_read) return unread_member(name, "blocks that the header counts, of its probes");
  }
  return std::nullopt;
}

Opened open_dsl(std::unique_ptr<ZipArchive> archive, const ZipMember& member,
                const SampleReading& reading) {
  const auto text = archive->read_text(member, max_header_bytes);
  if (!text) {
    return tl::unexpected(CaptureError{
        .cause = CaptureCause::damaged, .expected = "text of up to 1 MiB", .part = "header"});
  }
  auto header = parse_dsl_header(*text);
  if (!header) return tl::unexpected(header.error());
  if (header->version == 1) {
    const RawLayout layout{header->rate, unit_bytes_of_version_1, std::move(header->lines)};
    return open_zip_samples(layout, std::move(archive), std::move(header->capture_file), reading);
  }
  if (const auto error = find_unread_block(*archive, *header)) return tl::unexpected(*error);
  return open_samples(packed_layout(names_of(header->lines), header->rate),
                      std::make_unique<DslPieces>(std::move(archive), *header, reading.verify),
                      reading);
}

}  // namespace

tl::expected<DslHeader, CaptureError> parse_dsl_header(std::string_view text) {
  return HeaderParser().parse(text);
}

Opened open_zip(std::unique_ptr<ByteSource> bytes, const SampleReading& reading) {
  auto archive = ZipArchive::open(std::move(bytes));
  if (!archive) return tl::unexpected(archive.error());
  const auto header = (*archive)->find("header");
  const bool is_dsl = header && !(*archive)->find("metadata");
  return is_dsl ? open_dsl(std::move(*archive), *header, reading)
                : open_sr(std::move(*archive), reading);
}

DslWriter::DslWriter(const std::vector<std::string>& lines, Hertz rate, ByteSink& sink)
    : SampledWriter(packed_layout(lines, rate), sink),
      layout_(packed_layout(lines, rate)),
      planes_(lines.size()) {}

bool DslWriter::put_samples(std::string_view bytes) {
  sample_ = 0;
  for (std::size_t i = layout_.unit_bytes; i-- > 0;) {
    sample_ = sample_ << 8U | static_cast<unsigned char>(bytes[i]);
  }
  std::uint64_t left = bytes.size() / layout_.unit_bytes;
  total_samples_ += left;
  while (left != 0) {
    const std::uint64_t some = std::min(left, dsl_block_samples - block_samples_);
    put_bits(some);
    left -= some;
    if (block_samples_ == dsl_block_samples && !put_block()) return false;
  }
  return true;
}

// Appends the last sample to the planes that many times.
void DslWriter::put_bits(std::uint64_t samples) {
  const auto first = static_cast<std::size_t>(block_samples_);
  const auto end = first + static_cast<std::size_t>(samples);
  for (std::size_t line = 0; line < planes_.size(); ++line) {
    std::string& plane = planes_[line];
    const bool high = (sample_ >> line & 1U) != 0;
    const std::size_t began = plane.size();
    plane.resize((end + 7) / 8, high ? '\xFF' : '\0');
    if (!high) continue;
    // The bits of a byte that belongs only partly to these samples.
    if (first % 8 != 0) {
      plane[began - 1] = static_cast<char>(plane[began - 1] | (0xFF << first % 8));
    }
    if (end % 8 != 0) plane.back() = static_cast<char>(plane.back() & (0xFF >> (8 - end % 8)));
  }
  block_samples_ = end;
}

bool DslWriter::put_block() {
  for (std::size_t line = 0; line < planes_.size(); ++line) {
    const std::string name = "L-" + std::to_string(line) + '/' + std::to_string(blocks_);
    if (!archive_.add(name, planes_[line], text())) refuse(WriteCause::too_large);
    planes_[line].clear();
    if (!flush_full()) return false;
  }
  block_samples_ = 0;
  ++blocks_;
  return true;
}

void DslWriter::put_close() {
  // DSView reads samples by 64; those beyond the number in the header are not shown.
  if (block_samples_ % word_bits != 0) put_bits(word_bits - block_samples_ % word_bits);
  if (block_samples_ != 0 && !put_block()) return;
  std::string header = "[version]\nversion = " + std::to_string(newest_version) +
                       "\n[header]\ndriver = biss\ndevice mode = 0\ncapturefile = data\n";
  header += "total samples = " + std::to_string(total_samples_) + '\n';
  header += "total probes = " + std::to_string(planes_.size()) + '\n';
  header += "total blocks = " + std::to_string(blocks_) + '\n';
  header += "samplerate = " + sample_rate_text(layout_.rate) + '\n';
  header += "trigger time = 0\ntrigger pos = 0\n";
  for (const SampleLine& line : layout_.lines) {
    header += "probe" + std::to_string(line.bit) + " = " + escaped(line.name) + '\n';
  }
  if (!archive_.add("header", header, text())) return refuse(WriteCause::too_large);
  archive_.finish(text());
}

}  // namespace biss::capture
