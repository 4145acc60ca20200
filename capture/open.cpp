#include "capture/open.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include "capture/compressed.hpp"
#include "capture/dsl.hpp"
#include "capture/event_csv.hpp"
#include "capture/fst.hpp"
#include "capture/gather.hpp"
#include "capture/saleae_binary.hpp"
#include "capture/sampled_csv.hpp"
#include "capture/text_source.hpp"
#include "capture/vcd.hpp"
#include "capture/zip.hpp"

namespace biss::capture {
namespace {

enum class Format : std::uint8_t {
  vcd,
  event_csv,
  sampled_csv,
  zip,
  fst,
  saleae_binary,
  raw,
  other
};

// Enough for the comments before a header, little enough to keep.
constexpr std::size_t head_bytes = 65'536;

constexpr const char* expected_text =
    "a VCD, FST, a sigrok session, a DSLogic capture, an export of Saleae Logic, the CSV of an "
    "oscilloscope, or a CSV with a header such as time_ns,MA,SLO";
constexpr const char* expected_layout = "the sample rate, unit size and bits";

// Compressions that are not read, by their first bytes.
constexpr std::array<std::pair<std::string_view, const char*>, 4> other_compressions{{
    {{"\xFD\x37zXZ\0", 6}, "gzip or zstd; this is xz"},
    {"\x04\x22M\x18", "gzip or zstd; this is LZ4"},
    {"LZIP\x01", "gzip or zstd; this is lzip"},
    {"7z\xBC\xAF\x27\x1C", "gzip or zstd; this is 7z"},
}};

// Formats of captures that are not read, by their first bytes.
constexpr std::array<std::pair<std::string_view, const char*>, 3> known_others{{
    {"\xFF\xFE", "text in UTF-8; this is UTF-16"},
    {"\xFE\xFF", "text in UTF-8; this is UTF-16"},
    {"GHDLwave", "the VCD or FST that GHDL writes with --vcd or --fst; this is a GHW"},
}};

// A file compressed more often is a mistake or an attack.
constexpr int most_compressions = 3;

// A ZIP archive or an FST is read at any place, so a compressed one is gathered.
constexpr CaptureError archive_too_large{
    .cause = CaptureCause::too_large,
    .expected = "an archive or FST of at most 4 GiB inside a compressed file"};

// The first line that is neither blank nor a comment.
std::string_view first_row(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view row = text.substr(0, end);
    while (!row.empty() && is_space(row.front())) row.remove_prefix(1);
    if (!row.empty() && row.front() != '#') return row;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return {};
}

// `whole`: `head` is the complete file. Else the answer `other` may change once more of the file is
// read.
Format format_of_content(std::string_view head, bool whole) {
  if (looks_like_zip(head)) return Format::zip;
  if (looks_like_fst(head)) return Format::fst;
  if (head.starts_with(saleae_magic)) {
    return whole || head.size() >= saleae_header_bytes ? Format::saleae_binary : Format::other;
  }
  const Likeness sampled = looks_like_sampled_csv(head, whole);
  if (sampled == Likeness::yes) return Format::sampled_csv;
  if (sampled == Likeness::not_yet) return Format::other;
  const std::string_view row = first_row(head);
  if (row.size() > 1 && row[0] == '$' && row[1] >= 'a' && row[1] <= 'z') return Format::vcd;
  if (looks_like_event_csv(row)) return Format::event_csv;
  return Format::other;
}

Format format_of_extension(std::string_view path) {
  const std::string extension = lower_case(path.substr(std::min(path.rfind('.'), path.size())));
  if (extension == ".vcd") return Format::vcd;
  if (extension == ".csv") return Format::event_csv;
  if (extension == ".sr" || extension == ".dsl") return Format::zip;
  if (extension == ".fst") return Format::fst;
  if (extension == ".bin" || extension == ".raw") return Format::raw;
  return Format::other;
}

// Text with LF in place of CR, or of CR and LF.
class LineFeeds final : public ByteSource {
 public:
  explicit LineFeeds(std::unique_ptr<ByteSource> bytes) : bytes_(std::move(bytes)) {}

  Result<std::size_t, CaptureError> read(std::span<char> into) override {
    for (;;) {
      const auto got = bytes_->read(into);
      if (!got.ok() || *got == 0) return got;
      std::size_t made = 0;
      for (const char c : into.first(*got)) {
        if (c != '\n' || !after_cr_) into[made++] = c == '\r' ? '\n' : c;
        after_cr_ = c == '\r';
      }
      if (made != 0) return made;
    }
  }

 private:
  std::unique_ptr<ByteSource> bytes_;
  bool after_cr_ = false;
};

// The first line ends in CR alone. It is seen whole before the format of a CSV is known.
bool ends_lines_with_cr(std::string_view text) {
  return has_cr_inside(text.substr(0, text.find('\n')));
}

// The advice for a known format or compression that is not supported.
template <std::size_t Count>
const char* other_of(std::string_view head,
                     const std::array<std::pair<std::string_view, const char*>, Count>& others) {
  for (const auto& [magic, expected] : others) {
    if (head.starts_with(magic)) return expected;
  }
  return nullptr;
}

// The size of a block stands between the name and the block or the end.
bool is_bzip2(std::string_view head) {
  if (!head.starts_with("BZh") || head.size() < 4) return false;
  const std::string_view block = head.substr(4);
  return block.starts_with("1AY&SY") || block.starts_with("\x17rE8P\x90");
}

// Raw samples have no signature: if a layout is given, the file name alone selects them.
Format format_of(std::string_view head, std::string_view path, bool raw_given) {
  if (head.starts_with(saleae_magic)) return format_of_content(head, true);
  const Format by_name = format_of_extension(path);
  if (raw_given && by_name == Format::raw) return Format::raw;
  if (const Format by_content = format_of_content(head, true); by_content != Format::other) {
    return by_content;
  }
  if (by_name == Format::other && raw_given) return Format::raw;
  return other_of(head, known_others) != nullptr ? Format::other : by_name;
}

// The name of the file without folder and extension: the name of a line without a name of its own.
std::string stem_of(std::string_view path) {
  if (path == "-") return {};
  path.remove_prefix(std::min(path.rfind('/') + 1, path.size()));
  std::string_view stem = path.substr(0, path.rfind('.'));
  if (stem.ends_with(".saleae")) stem.remove_suffix(std::string_view(".saleae").size());
  return std::string(stem);
}

Opened open_as(Format format, std::unique_ptr<ByteSource> bytes, std::string_view path,
               const OpenOptions& options, const EventCsvRows& rows) {
  const SampleReading reading{options.piece_bytes, !options.no_verify};
  switch (format) {
    case Format::vcd:
      return open_vcd(std::move(bytes), options.piece_bytes);
    case Format::event_csv:
      return open_event_csv(std::move(bytes), options.piece_bytes, rows);
    case Format::sampled_csv:
      return open_sampled_csv(std::move(bytes), options.analog);
    case Format::zip:
      return open_zip(std::move(bytes), reading);
    case Format::saleae_binary:
      return open_saleae_binary(std::move(bytes), stem_of(path), options.analog);
    case Format::fst:
      return open_fst(std::move(bytes));
    case Format::raw:
    case Format::other:
      break;
  }
  if (options.raw) return open_raw(std::move(bytes), *options.raw, reading);
  if (format == Format::raw) {
    return tl::unexpected(
        CaptureError{.cause = CaptureCause::layout_missing, .expected = expected_layout});
  }
  return tl::unexpected(CaptureError{CaptureCause::unknown_format, 1, 1, expected_text});
}

bool is_blank(std::string_view text) { return std::all_of(text.begin(), text.end(), is_space); }

std::string place_of(const CaptureError& error, std::string_view path) {
  std::string place = path == "-" ? "standard input" : std::string(path);
  for (char& c : place) {
    if (static_cast<unsigned char>(c) < ' ') c = '?';
  }
  if (error.part != nullptr) place += std::string(": ") + error.part;
  if (error.part_number != 0) place += ' ' + std::to_string(error.part_number);
  if (error.member[0] != 0) place += std::string(": member '") + error.member.data() + '\'';
  if (error.line == 0) return place;
  return place + ':' + std::to_string(error.line) + ':' + std::to_string(error.column);
}

constexpr const char* export_again = "export the capture again";

// By CaptureCause: its name, what is wrong, and what to do.
struct CauseWords {
  std::string_view name;
  const char* what;
  const char* advice;
};
constexpr auto causes = std::to_array<CauseWords>({
    {"cannot_open", "cannot be opened", "check that it exists and may be read"},
    {"is_directory", "is a folder", "name a capture file in it"},
    {"read_failed", "cannot be read further", "check the disk or the device and try again"},
    {"empty", "is empty", export_again},
    {"unknown_format", "is not a capture of a known format", "export it as VCD, .sr or event CSV"},
    {"compression", "has a compression that is not supported", "decompress it first"},
    {"malformed", "does not follow the format", "correct this place or export the capture again"},
    {"token_too_long", "a word or a row of more than 64 KiB", export_again},
    {"too_many_lines", "more signals than a capture may have (65536 of one bit)",
     "export fewer signals"},
    {"block_too_large", "a part of it needs more than 256 MiB of memory",
     "record fewer signals or less time"},
    {"time_backwards", "time runs backwards", "sort by time or export the capture again"},
    {"time_out_of_range", "a time beyond 106 days", "check the unit of time"},
    {"damaged", "is damaged", "copy or save the capture again"},
    {"too_large", "is too large", "decompress it to a file first"},
    {"layout_missing", "the layout of raw samples is not known", "give their layout"},
    {"bad_layout", "has an impossible layout", "correct the layout given"},
    {"no_two_levels", "no signal with two levels", "give the threshold, as in --threshold 1.5V"},
    {"no_such_channel", "--differential does not name two of its analog channels",
     "give the names of its header, as in CH1-CH2=MA"},
    {"truncated", "the file ends in the middle", "the part before was read; export the rest again"},
});
static_assert(causes.size() == static_cast<std::size_t>(CaptureCause::truncated) + 1);

struct Head {
  std::string text;
  std::optional<CaptureError> error;  // why the text ended
};

// The part of the beginning that shows the format of the file.
Head read_head(ByteSource& bytes) {
  Head head;
  std::array<char, 4'096> block{};
  std::size_t judged = 0;
  while (head.text.size() < head_bytes) {
    const auto got = bytes.read(block);
    if (!got.ok()) {
      head.error = got.error();
      break;
    }
    if (*got == 0) break;
    head.text.append(block.data(), *got);
    // Judged when it has doubled: sources may deliver single bytes.
    if (head.text.size() < 2 * judged) continue;
    judged = head.text.size();
    if (format_of_content(head.text, false) != Format::other) break;
    if (compression_of(head.text) != Compression::none) break;
  }
  return head;
}

// `compressions` is how often these bytes were compressed.
Opened open_bytes_of(std::unique_ptr<ByteSource> bytes, std::string_view path,
                     const OpenOptions& options, int compressions) {
  Head head = read_head(*bytes);
  if (head.error && head.text.empty()) return tl::unexpected(*head.error);
  const bool raw_by_name = options.raw && format_of_extension(path) == Format::raw;
  const Compression compression = raw_by_name ? Compression::none : compression_of(head.text);
  const Format format = format_of(head.text, path, options.raw.has_value());
  const bool blank = is_blank(head.text) && head.text.size() < head_bytes;
  const bool is_csv = format == Format::event_csv || format == Format::sampled_csv ||
                      (format == Format::other && !options.raw);
  const bool wrong_lines =
      is_csv && compression == Compression::none && ends_lines_with_cr(head.text);
  const EventCsvRows rows =
      format == Format::event_csv ? event_csv_rows(head.text) : EventCsvRows();
  const char* const other = other_of(head.text, known_others);
  const char* const compressed =
      is_bzip2(head.text) ? "gzip or zstd; this is bzip2" : other_of(head.text, other_compressions);
  // The bytes before an error are delivered before it.
  if (head.error) bytes = failed_bytes(*head.error);
  bytes = prefixed_bytes(std::move(head.text), std::move(bytes));
  if (compression != Compression::none) {
    if (compressions == most_compressions) {
      return tl::unexpected(CaptureError{.cause = CaptureCause::unknown_format,
                                         .expected = "a file that is compressed at most 3 times"});
    }
    return open_bytes_of(decompressed(std::move(bytes), compression), without_compression(path),
                         options, compressions + 1);
  }
  if (compressed != nullptr && !raw_by_name) {
    return tl::unexpected(CaptureError{.cause = CaptureCause::compression, .expected = compressed});
  }
  if (wrong_lines) {
    bytes = std::make_unique<LineFeeds>(std::move(bytes));
    return open_bytes_of(std::move(bytes), path, options, compressions);
  }
  if (format == Format::other && other != nullptr) {
    return tl::unexpected(CaptureError{CaptureCause::unknown_format, 1, 1, other});
  }
  if (format == Format::other && blank) {
    return tl::unexpected(head.error.value_or(CaptureError{.cause = CaptureCause::empty}));
  }
  if ((format == Format::zip || format == Format::fst) && compressions != 0) {
    bytes = limited_bytes(std::move(bytes), most_gathered_bytes, archive_too_large);
  }
  return open_as(format, std::move(bytes), path, options, rows);
}

}  // namespace

Opened open_capture(std::unique_ptr<ByteSource> bytes, std::string_view path,
                    const OpenOptions& options) {
  return open_bytes_of(std::move(bytes), path, options, 0);
}

Opened open_capture(const std::string& path, const OpenOptions& options) {
  OpenedBytes opened = open_bytes(path);
  if (!opened) return tl::unexpected(opened.error());
  return open_capture(std::move(*opened), path, options);
}

std::string_view name_of(CaptureCause cause) {
  return causes[static_cast<std::size_t>(cause)].name;
}

std::string capture_error_text(const CaptureError& error, std::string_view path) {
  const auto& [name, what, advice] = causes[static_cast<std::size_t>(error.cause)];
  std::string text = place_of(error, path) + ": " + what;
  if (error.expected != nullptr) text += std::string(", expected ") + error.expected;
  return text + "; " + advice;
}

}  // namespace biss::capture
