#include "capture/zip_archive.hpp"

#include <fcntl.h>
#include <unistd.h>
#include <zip.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

namespace biss::capture {
namespace {

constexpr std::size_t most_in_memory = 16U * 1024U * 1024U;

struct CloseStdio {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using Stdio = std::unique_ptr<std::FILE, CloseStdio>;

struct FreeSource {
  void operator()(zip_source_t* source) const { zip_source_free(source); }
};
using Source = std::unique_ptr<zip_source_t, FreeSource>;

constexpr CaptureError read_failed{.cause = CaptureCause::read_failed};

// A stream of its own on the same file.
Stdio reopened(int descriptor) {
  const int copy = ::dup(descriptor);
  if (copy < 0) return nullptr;
  Stdio file(::fdopen(copy, "rb"));
  if (!file) ::close(copy);
  return file;
}

Source source_of_file(Stdio file) {
  if (!file) return nullptr;
  Source source(zip_source_filep_create(file.get(), 0, -1, nullptr));
  if (source) static_cast<void>(file.release());  // the source closes it
  return source;
}

// A file without a name in TMPDIR, /tmp by default. Null on failure.
Stdio temporary_file() {
  std::error_code none;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(none);
  if (none) return nullptr;
  int descriptor = ::open(folder.c_str(), O_RDWR | O_TMPFILE | O_CLOEXEC, 0600);
  if (descriptor < 0) {
    std::string path = (folder / "biss-XXXXXX").string();
    descriptor = ::mkostemp(path.data(), O_CLOEXEC);
    if (descriptor >= 0) ::unlink(path.c_str());
  }
  if (descriptor < 0) return nullptr;
  Stdio file(::fdopen(descriptor, "w+b"));
  if (!file) ::close(descriptor);
  return file;
}

struct Gathered {
  Stdio file;  // null when everything is in memory
  bool ok = false;
};

bool write_all(std::string_view bytes, std::FILE* file) {
  return std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
}

// What cannot be read at any place is copied to where it can be. Small files do not pay for the
// room that large ones want.
Gathered gather(ByteSource& bytes, std::string& memory) {
  constexpr std::size_t least_room = 4'096;
  constexpr std::size_t most_room = 1'048'576;
  Gathered gathered;
  std::size_t filled = 0;
  for (;;) {
    if (filled == memory.size()) memory.resize(filled + std::clamp(filled, least_room, most_room));
    const auto got = bytes.read(std::span(memory).subspan(filled));
    if (!got.ok()) return gathered;
    if (*got == 0) break;
    filled += *got;
    if (filled < most_in_memory) continue;
    if (!gathered.file) gathered.file = temporary_file();
    if (!gathered.file || !write_all({memory.data(), filled}, gathered.file.get())) return gathered;
    filled = 0;
  }
  memory.resize(filled);
  gathered.ok = true;
  if (!gathered.file) return gathered;
  gathered.ok = write_all(memory, gathered.file.get()) && std::fflush(gathered.file.get()) == 0;
  memory = {};
  return gathered;
}

std::optional<ZipMember> member_at(zip_t* archive, zip_uint64_t index) {
  zip_stat_t about{};
  constexpr zip_uint64_t needed = ZIP_STAT_INDEX | ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE |
                                  ZIP_STAT_CRC | ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD;
  if (zip_stat_index(archive, index, 0, &about) != 0) return std::nullopt;
  if ((about.valid & needed) != needed) return std::nullopt;
  return ZipMember{
      .index = index,
      .size_bytes = about.size,
      .compressed_bytes = about.comp_size,
      .checksum = about.crc,
      .deflated = about.comp_method == ZIP_CM_DEFLATE && about.encryption_method == ZIP_EM_NONE};
}

bool is_numbered(std::string_view name, std::string_view begins) {
  if (!name.starts_with(begins)) return false;
  name.remove_prefix(begins.size());
  return !name.empty() && name.front() != '0' &&
         name.find_first_not_of("0123456789") == std::string_view::npos;
}

// All of `into`, from a file that may give less at a time.
bool read_whole(zip_file_t* file, std::span<std::uint8_t> into) {
  while (!into.empty()) {
    const zip_int64_t got = zip_fread(file, into.data(), into.size());
    if (got <= 0) return false;
    into = into.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

}  // namespace

void ZipArchive::CloseArchive::operator()(zip* archive) const { zip_discard(archive); }

void ZipArchive::CloseFile::operator()(zip_file* file) const { zip_fclose(file); }

ZipArchive::~ZipArchive() = default;

OpenedZip ZipArchive::open(std::unique_ptr<ByteSource> bytes) {
  std::unique_ptr<ZipArchive> archive(new ZipArchive);
  if (const auto error = archive->open_source(std::move(bytes))) return {nullptr, *error};
  return {std::move(archive), {}};
}

std::optional<CaptureError> ZipArchive::open_source(std::unique_ptr<ByteSource> bytes) {
  Source source;
  if (const int descriptor = bytes->regular_file(); descriptor >= 0) {
    source = source_of_file(reopened(descriptor));
  } else {
    Gathered gathered = gather(*bytes, memory_);
    if (!gathered.ok) return read_failed;
    source = gathered.file
                 ? source_of_file(std::move(gathered.file))
                 : Source(zip_source_buffer_create(memory_.data(), memory_.size(), 0, nullptr));
  }
  zip_stat_t about{};
  if (!source || zip_source_stat(source.get(), &about) != 0) return read_failed;
  archive_.reset(zip_open_from_source(source.get(), ZIP_RDONLY, nullptr));
  if (!archive_) {
    return CaptureError{.cause = CaptureCause::damaged,
                        .expected = "a ZIP archive with its directory at the end"};
  }
  static_cast<void>(source.release());  // the archive frees it
  if (members_overlap(about.size)) {
    return CaptureError{.cause = CaptureCause::damaged,
                        .expected = "members that fit into the file, each in a place of its own"};
  }
  return std::nullopt;
}

// Members that share their compressed bytes would make a file of any size out of a small one.
bool ZipArchive::members_overlap(std::uint64_t file_bytes) const {
  const zip_int64_t entries = zip_get_num_entries(archive_.get(), 0);
  std::uint64_t left = file_bytes;
  for (zip_int64_t i = 0; i < entries; ++i) {
    zip_stat_t about{};
    if (zip_stat_index(archive_.get(), static_cast<zip_uint64_t>(i), 0, &about) != 0) return true;
    if ((about.valid & ZIP_STAT_COMP_SIZE) == 0 || about.comp_size > left) return true;
    left -= about.comp_size;
  }
  return false;
}

std::optional<ZipMember> ZipArchive::find(const std::string& name) const {
  const zip_int64_t index = zip_name_locate(archive_.get(), name.c_str(), 0);
  if (index < 0) return std::nullopt;
  return member_at(archive_.get(), static_cast<zip_uint64_t>(index));
}

std::uint64_t ZipArchive::count_numbered(std::string_view name_begins) const {
  const zip_int64_t entries = zip_get_num_entries(archive_.get(), 0);
  std::uint64_t found = 0;
  for (zip_int64_t i = 0; i < entries; ++i) {
    const char* const name =
        zip_get_name(archive_.get(), static_cast<zip_uint64_t>(i), ZIP_FL_ENC_RAW);
    if (name != nullptr && is_numbered(name, name_begins)) ++found;
  }
  return found;
}

bool ZipArchive::read_compressed(const ZipMember& member, std::span<std::uint8_t> into) {
  const std::unique_ptr<zip_file, CloseFile> file(
      zip_fopen_index(archive_.get(), member.index, ZIP_FL_COMPRESSED));
  return file && read_whole(file.get(), into);
}

std::optional<std::string> ZipArchive::read_text(const ZipMember& member, std::size_t max_bytes) {
  if (member.size_bytes > max_bytes || !begin_stream(member)) return std::nullopt;
  std::string text;
  std::array<std::uint8_t, 4'096> block{};
  for (;;) {
    const auto got = read_stream(block);
    if (!got || text.size() + *got > max_bytes) return std::nullopt;
    if (*got == 0) return text;
    text.append(block.begin(), block.begin() + *got);
  }
}

bool ZipArchive::begin_stream(const ZipMember& member) {
  stream_.reset(zip_fopen_index(archive_.get(), member.index, 0));
  return stream_ != nullptr;
}

std::optional<std::size_t> ZipArchive::read_stream(std::span<std::uint8_t> into) {
  const zip_int64_t got = zip_fread(stream_.get(), into.data(), into.size());
  if (got < 0) return std::nullopt;
  return static_cast<std::size_t>(got);
}

}  // namespace biss::capture
