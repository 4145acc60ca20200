#include "capture/dsl.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "capture/dsl_blocks.hpp"
#include "capture/key_file.hpp"
#include "capture/sr.hpp"

namespace biss::capture {
namespace {

constexpr unsigned newest_version = 3;
constexpr unsigned max_dsl_probes = 8 * max_unit_bytes;
constexpr std::size_t unit_bytes_of_version_1 = 2;
constexpr std::size_t max_header_bytes = 1024U * 1024U;
constexpr std::uint64_t word_bits = 64;

class DslHeaderParser {
 public:
  tl::expected<DslHeader, CaptureError> parse(std::string_view text) {
    while (!text.empty()) {
      ++line_;
      const std::string_view row = take_row(text);
      if (!is_comment_row(row) && !read_row(row)) return tl::unexpected(error_);
    }
    if (!complete()) return tl::unexpected(error_);
    return std::move(found_);
  }

 private:
  bool wrong(const char* expected, CaptureCause cause = CaptureCause::malformed) {
    error_ = {.cause = cause, .line = line_, .column = 1, .expected = expected, .part = "header"};
    return false;
  }

  bool read_row(std::string_view row) {
    if (row.front() == '[') {
      in_version_ = row == "[version]";
      in_header_ = row.starts_with("[header");
      return true;
    }
    const std::size_t equals = row.find('=');
    if (equals == std::string_view::npos) return wrong("[section] or key = value");
    const std::string_view key = trimmed(row.substr(0, equals));
    const std::string_view value = trimmed(row.substr(equals + 1));
    if (in_version_ && key == "version") return take_version(value);
    return !in_header_ || take_key(key, value);
  }

  bool take_version(std::string_view value) {
    const auto version = whole_number<unsigned>(value);
    if (!version || *version == 0 || *version > newest_version) {
      return wrong("version 1, 2 or 3 of DSView's captures");
    }
    found_.version = *version;
    return true;
  }

  bool take_key(std::string_view key, std::string_view value) {
    if (key == "device mode") {
      if (value != "0") return wrong(other_mode, CaptureCause::unknown_format);
    } else if (key == "capturefile") {
      if (!found_.capture_file.empty()) return wrong("the capturefile once");
      found_.capture_file = unescaped(value);
    } else if (key == "samplerate") {
      if (found_.rate.count != 0) return wrong("the samplerate once");
      found_.rate = parse_sample_rate(value);
      if (found_.rate.count == 0) return wrong("a sample rate of 1 Hz to 4.29 GHz");
    } else if (key == "total samples") {
      return take_count(value, found_.total_samples);
    } else if (key == "total blocks") {
      return take_count(value, found_.total_blocks);
    } else if (key.starts_with("probe")) {
      const auto number = whole_number<unsigned>(key.substr(5));
      if (!number || *number >= max_dsl_probes) return wrong("probe0 to probe63");
      if (!probes_.emplace(*number, unescaped(value)).second) return wrong("each probe once");
    }
    return true;
  }

  bool take_count(std::string_view value, std::uint64_t& count) {
    const auto number = whole_number<std::uint64_t>(value);
    if (!number) return wrong("a whole number");
    if (count != 0) return wrong("this number once");
    count = *number;
    return true;
  }

  bool complete() {
    for (const auto& [number, name] : probes_) found_.lines.push_back({name, number});
    if (found_.rate.count == 0) return wrong("the samplerate");
    if (found_.lines.empty()) return wrong("the names of the probes");
    if (found_.version != 1) {
      return found_.total_blocks <= found_.needed_blocks() ||
             wrong("no more total blocks than the total samples fill");
    }
    if (found_.capture_file.empty()) return wrong("the capturefile");
    return probes_.rbegin()->first < 8 * unit_bytes_of_version_1 ||
           wrong("probe0 to probe15 in version 1");
  }

  static constexpr const char* other_mode =
      "a capture of the logic analyser (device mode 0); export it from DSView as CSV";

  DslHeader found_;
  std::map<unsigned, std::string> probes_;
  bool in_version_ = false;
  bool in_header_ = false;
  std::uint64_t line_ = 0;
  CaptureError error_;
};

/// The samples of one probe in the block at hand, and its level before the next of them.
struct Plane {
  std::vector<std::uint64_t> words;
  std::uint64_t last = 0;
};

class DslSource final : public EdgeSource {
 public:
  DslSource(std::unique_ptr<ZipArchive> archive, const DslHeader& header, bool verify)
      : blocks_(std::move(archive), header),
        rate_(header.rate),
        verify_(verify),
        clock_(header.rate),
        last_index_(clock_.last_index()),
        planes_(header.lines.size()) {
    LineNames names;
    for (const SampleLine& line : header.lines) lines_.push_back(names.claim(line.name));
  }

  const std::vector<std::string>& lines() const override { return lines_; }
  Picoseconds end_time() const override { return end_time_; }
  Picoseconds sample_period() const override { return longest_period(rate_); }
  Hertz sample_rate() const override { return rate_; }

  Result<std::span<const wire::Edge>, CaptureError> next_block() override {
    edges_.grow();
    edges_.prepare(lines_.size());
    while (!stopped_ && edges_.empty()) {
      if (at_ == samples_) {
        load_block();
      } else {
        scan();
      }
    }
    if (edges_.empty() && error_) return failure(*error_);
    return edges_.edges();
  }

  std::unique_ptr<PairSource> pairs(wire::LineIndex ma, wire::LineIndex slo) override {
    DslRead read;
    read.first = before_ + at_;
    read.end = before_ + samples_;
    read.end_time = end_time_;
    read.ended = stopped_;
    read.error = error_;
    for (std::size_t i = 0; i < planes_.size(); ++i) {
      read.last_levels |= last_level(planes_[i]) << i;
      read.levels |= level_before_next(planes_[i]) << i;
    }
    if (at_ != samples_) {
      read.ma = rest_of(planes_[ma]);
      read.slo = rest_of(planes_[slo]);
      read.beyond = changes_beyond();
    }
    return dsl_pairs(blocks_, rate_, verify_, ma, slo, std::move(read));
  }

 private:
  void stop(const CaptureError& error) {
    stopped_ = true;
    error_ = error;
  }

  void load_block() {
    before_ += samples_;
    at_ = samples_ = 0;
    const auto got = blocks_.next(packed_);
    if (!got.ok()) return stop(got.error());
    stopped_ = !*got;
    if (stopped_) return;
    for (std::size_t i = 0; i < packed_.planes.size(); ++i) {
      if (!inflate(packed_.planes[i], planes_[i].words)) {
        return stop(packed_.damaged(damaged_plane));
      }
    }
    if (packed_.fault != nullptr) return stop(packed_.damaged(packed_.fault));
    samples_ = packed_.samples;
  }

  bool inflate(const PackedPlane& packed, std::vector<std::uint64_t>& words) {
    words.resize(static_cast<std::size_t>((packed.size_bytes + 7) / 8));
    if (!words.empty()) words.back() = 0;
    const std::span bytes(reinterpret_cast<std::uint8_t*>(words.data()),
                          static_cast<std::size_t>(packed.size_bytes));
    if (!packed.inflate(inflater_, verify_, bytes)) return false;
    if constexpr (std::endian::native == std::endian::big) {
      for (std::uint64_t& word : words) word = __builtin_bswap64(word);
    }
    return true;
  }

  // The samples of the word from at_ on at which a line changes.
  std::uint64_t changes(std::size_t word) const {
    std::uint64_t any = 0;
    for (const Plane& plane : planes_) {
      const std::uint64_t levels = plane.words[word];
      any |= levels ^ ((levels << 1U) | plane.last);
    }
    if (before_ + word == 0) any |= 1;
    return any & (~std::uint64_t{0} << (at_ % word_bits));
  }

  // Edges of the samples up to the end of the block, or until the block of edges is full.
  void scan() {
    while (at_ != samples_) {
      const auto word = static_cast<std::size_t>(at_ / word_bits);
      const std::uint64_t valid = std::min(word_bits, samples_ - word * word_bits);
      const std::uint64_t end = word * word_bits + valid;
      std::uint64_t any = changes(word) & (~std::uint64_t{0} >> (word_bits - valid));
      for (; any != 0; any &= any - 1) {
        at_ = word * word_bits + static_cast<std::uint64_t>(std::countr_zero(any));
        if (edges_.full()) return;
        if (before_ + at_ > last_index_) {
          end_time_ = clock_.time_of(last_index_);
          return stop({.cause = CaptureCause::time_out_of_range});
        }
        push_changes(word, at_ % word_bits);
      }
      at_ = end;
      for (Plane& plane : planes_) plane.last = (plane.words[word] >> (valid - 1)) & 1U;
      end_time_ = clock_.time_of(std::min(before_ + at_ - 1, last_index_));
    }
  }

  void push_changes(std::size_t word, std::uint64_t bit) {
    end_time_ = clock_.time_of(before_ + at_);
    for (std::size_t line = 0; line < planes_.size(); ++line) {
      const Plane& plane = planes_[line];
      const std::uint64_t level = (plane.words[word] >> bit) & 1U;
      const std::uint64_t before = bit == 0 ? plane.last : (plane.words[word] >> (bit - 1)) & 1U;
      if (level == before && before_ + at_ != 0) continue;
      edges_.push({end_time_, static_cast<wire::LineIndex>(line),
                   level == 1 ? wire::Level::high : wire::Level::low});
    }
  }

  std::uint64_t last_level(const Plane& plane) const {
    if (at_ == samples_) return plane.last;
    const std::uint64_t last = samples_ - 1;
    return plane.words[static_cast<std::size_t>(last / word_bits)] >> last % word_bits & 1U;
  }

  // The level before the sample at hand.
  std::uint64_t level_before_next(const Plane& plane) const {
    if (at_ % word_bits == 0 || at_ == samples_) return plane.last;
    return plane.words[static_cast<std::size_t>(at_ / word_bits)] >> (at_ - 1) % word_bits & 1U;
  }

  // The words from the sample at hand on, their bytes as in the file. Samples before it show its
  // level.
  std::vector<std::uint64_t> rest_of(const Plane& plane) const {
    std::vector<std::uint64_t> words(
        plane.words.begin() + static_cast<std::ptrdiff_t>(at_ / word_bits), plane.words.end());
    const std::uint64_t before = (std::uint64_t{1} << at_ % word_bits) - 1;
    const bool high = (words.front() >> at_ % word_bits & 1U) != 0;
    words.front() = high ? words.front() & ~before : words.front() | before;
    if constexpr (std::endian::native == std::endian::big) {
      for (std::uint64_t& word : words) word = __builtin_bswap64(word);
    }
    return words;
  }

  // Whether a line changes in the rest of the block where no time can be represented.
  bool changes_beyond() const {
    const auto level = [](const Plane& plane, std::uint64_t sample) {
      return plane.words[static_cast<std::size_t>(sample / word_bits)] >> sample % word_bits & 1U;
    };
    const std::uint64_t first = last_index_ < before_ ? 0 : last_index_ + 1 - before_;
    for (std::uint64_t at = std::max(first, at_); at < samples_; ++at) {
      for (const Plane& plane : planes_) {
        if (level(plane, at) != (at == 0 ? plane.last : level(plane, at - 1))) return true;
      }
    }
    return false;
  }

  DslBlocks blocks_;
  Hertz rate_;
  bool verify_;
  SampleClock clock_;
  std::uint64_t last_index_;
  std::vector<std::string> lines_;
  PackedBlock packed_;
  Inflater inflater_;
  std::vector<Plane> planes_;
  std::uint64_t before_ = 0;   // samples of the blocks before the one at hand
  std::uint64_t samples_ = 0;  // of the block at hand
  std::uint64_t at_ = 0;       // the next of these
  Picoseconds end_time_;
  EdgeBlock edges_;
  bool stopped_ = false;
  std::optional<CaptureError> error_;
};

// Every block in the archive is one that the header counts, of a probe that it names.
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

}  // namespace

tl::expected<DslHeader, CaptureError> parse_dsl_header(std::string_view text) {
  return DslHeaderParser().parse(text);
}

Opened open_dsl(std::unique_ptr<ByteSource> bytes, const SampleReading& reading) {
  auto opened = ZipArchive::open(std::move(bytes));
  if (!opened) return tl::unexpected(opened.error());
  return open_dsl(std::move(*opened), reading);
}

Opened open_dsl(std::unique_ptr<ZipArchive> archive, const SampleReading& reading) {
  const auto member = archive->find("header");
  const auto text = member ? archive->read_text(*member, max_header_bytes) : std::nullopt;
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
  return std::make_unique<DslSource>(std::move(archive), *header, reading.verify);
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
    // Bits of bytes that are only partly these samples.
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
