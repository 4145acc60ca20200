// ZIP archives by PKWARE's APPNOTE: the directory (4.3.12 to 4.3.16), and members as streams.
#include <libdeflate.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zip.h>

#include <algorithm>
#include <array>
#include <boost/beast/zlib/inflate_stream.hpp>
#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "wasm/libraries/inflate.hpp"

namespace zlib = boost::beast::zlib;

// A file, or bytes in memory, read at any place.
struct zip_source {
  std::FILE* file = nullptr;
  const std::uint8_t* bytes = nullptr;
  std::uint64_t size_bytes = 0;

  bool read(std::uint64_t place, std::span<std::uint8_t> into) const {
    if (place > size_bytes || into.size() > size_bytes - place) return false;
    if (file == nullptr) {
      std::copy_n(bytes + place, into.size(), into.data());
      return true;
    }
    while (!into.empty()) {
      const ssize_t got =
          ::pread(::fileno(file), into.data(), into.size(), static_cast<off_t>(place));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return false;
      into = into.subspan(static_cast<std::size_t>(got));
      place += static_cast<std::uint64_t>(got);
    }
    return true;
  }
};

namespace {

struct Entry {
  std::string name;
  std::uint64_t size_bytes = 0;
  std::uint64_t compressed_bytes = 0;
  std::uint64_t place = 0;
  std::uint32_t checksum = 0;
  std::uint16_t method = 0;
  bool encrypted = false;
};

constexpr std::string_view entry_magic = "PK\x01\x02";
constexpr std::string_view end_magic = "PK\x05\x06";
constexpr std::string_view end64_magic = "PK\x06\x06";
constexpr std::string_view locator64_magic = "PK\x06\x07";
constexpr std::size_t local_bytes = 30;
constexpr std::size_t entry_bytes = 46;
constexpr std::size_t end_bytes = 22;
constexpr std::size_t end64_bytes = 56;
constexpr std::size_t locator64_bytes = 20;
constexpr std::uint32_t in_extra32 = 0xFFFF'FFFFU;
constexpr std::uint16_t in_extra16 = 0xFFFFU;

// Reads numbers, little end first, from a stretch of the archive.
class Fields {
 public:
  explicit Fields(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::size_t left() const { return bytes_.size(); }
  bool take(std::string_view magic) {
    const bool same = left() >= magic.size() && std::memcmp(bytes_.data(), magic.data(), 4) == 0;
    if (same) skip(magic.size());
    return same;
  }
  void skip(std::size_t count) { bytes_ = bytes_.subspan(count); }
  std::uint64_t number(std::size_t count) {
    std::uint64_t value = 0;
    for (std::size_t i = count; i != 0; --i) value = value << 8U | bytes_[i - 1];
    skip(count);
    return value;
  }
  std::uint16_t two() { return static_cast<std::uint16_t>(number(2)); }
  std::uint32_t four() { return static_cast<std::uint32_t>(number(4)); }
  std::uint64_t eight() { return number(8); }
  Fields part(std::size_t count) {
    const Fields taken(bytes_.first(count));
    skip(count);
    return taken;
  }
  std::string text(std::size_t count) {
    std::string taken(reinterpret_cast<const char*>(bytes_.data()), count);
    skip(count);
    return taken;
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

// Where the directory is, and how much of it.
struct DirectoryPlace {
  std::uint64_t entries = 0;
  std::uint64_t size_bytes = 0;
  std::uint64_t place = 0;
};

// Sizes of a large member are in the extra field 1 (4.5.3). False where they are missing.
bool read_extra64(Fields extra, Entry& entry, bool size, bool compressed, bool place) {
  while (extra.left() >= 4) {
    const std::uint16_t id = extra.two();
    const std::uint16_t bytes = extra.two();
    if (bytes > extra.left()) return false;
    Fields values = extra.part(bytes);
    if (id != 1) continue;
    for (const auto& [wanted, value] :
         {std::pair(size, &entry.size_bytes), std::pair(compressed, &entry.compressed_bytes),
          std::pair(place, &entry.place)}) {
      if (!wanted) continue;
      if (values.left() < 8) return false;
      *value = values.eight();
    }
    return true;
  }
  return false;
}

std::optional<Entry> read_entry(Fields& fields) {
  if (fields.left() < entry_bytes || !fields.take(entry_magic)) return std::nullopt;
  Entry entry;
  fields.skip(4);  // versions
  entry.encrypted = (fields.two() & 1U) != 0;
  entry.method = fields.two();
  fields.skip(4);  // date
  entry.checksum = fields.four();
  entry.compressed_bytes = fields.four();
  entry.size_bytes = fields.four();
  const std::size_t name = fields.two();
  const std::size_t extra = fields.two();
  const std::size_t comment = fields.two();
  fields.skip(8);  // disk, attributes
  entry.place = fields.four();
  if (fields.left() < name + extra + comment) return std::nullopt;
  entry.name = fields.text(name);
  const Fields extra_fields = fields.part(extra);
  fields.skip(comment);
  const bool size = entry.size_bytes == in_extra32;
  const bool compressed = entry.compressed_bytes == in_extra32;
  const bool place = entry.place == in_extra32;
  if ((size || compressed || place) &&
      !read_extra64(extra_fields, entry, size, compressed, place)) {
    return std::nullopt;
  }
  return entry;
}

// The record of a large archive, which a locator before the end record names.
std::optional<DirectoryPlace> read_end64(const zip_source& source, std::uint64_t end_place) {
  std::array<std::uint8_t, locator64_bytes> locator{};
  if (end_place < locator.size() || !source.read(end_place - locator.size(), locator)) {
    return std::nullopt;
  }
  Fields fields(locator);
  if (!fields.take(locator64_magic)) return std::nullopt;
  fields.skip(4);
  std::array<std::uint8_t, end64_bytes> record{};
  if (!source.read(fields.eight(), record)) return std::nullopt;
  Fields values(record);
  if (!values.take(end64_magic)) return std::nullopt;
  values.skip(20);  // size, versions, disks
  const std::uint64_t here = values.eight();
  DirectoryPlace directory;
  directory.entries = values.eight();
  directory.size_bytes = values.eight();
  directory.place = values.eight();
  if (here != directory.entries) return std::nullopt;
  return directory;
}

std::optional<DirectoryPlace> read_end(const zip_source& source, std::span<const std::uint8_t> tail,
                                       std::uint64_t end_place) {
  Fields fields(tail);
  if (fields.left() < end_bytes || !fields.take(end_magic)) return std::nullopt;
  const bool first_disk = fields.four() == 0;
  const std::uint16_t here = fields.two();
  DirectoryPlace directory;
  directory.entries = fields.two();
  directory.size_bytes = fields.four();
  directory.place = fields.four();
  if (fields.left() - 2 < fields.two()) return std::nullopt;  // the comment
  if (!first_disk || here != directory.entries) return std::nullopt;
  const bool large = directory.entries == in_extra16 || directory.size_bytes == in_extra32 ||
                     directory.place == in_extra32;
  if (large) {
    if (const auto found = read_end64(source, end_place)) directory = *found;
  }
  if (directory.place > end_place || directory.size_bytes > end_place - directory.place) {
    return std::nullopt;
  }
  return directory;
}

std::optional<std::vector<Entry>> read_directory(const zip_source& source,
                                                 const DirectoryPlace& directory) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(directory.size_bytes));
  if (!source.read(directory.place, bytes)) return std::nullopt;
  Fields fields(bytes);
  std::vector<Entry> entries;
  while (fields.left() != 0) {
    auto entry = read_entry(fields);
    if (!entry) return std::nullopt;
    entries.push_back(std::move(*entry));
  }
  if (entries.size() != directory.entries) return std::nullopt;
  return entries;
}

// The end record may be followed by a comment of up to 64 KiB.
std::optional<std::vector<Entry>> find_directory(const zip_source& source) {
  constexpr std::uint64_t most = in_extra16 + end_bytes;
  const std::uint64_t count = std::min(most, source.size_bytes);
  const std::uint64_t begin = source.size_bytes - count;
  std::vector<std::uint8_t> tail(static_cast<std::size_t>(count));
  if (!source.read(begin, tail)) return std::nullopt;
  const std::string_view text(reinterpret_cast<const char*>(tail.data()), tail.size());
  for (std::size_t at = text.find(end_magic); at != std::string_view::npos;
       at = text.find(end_magic, at + 1)) {
    const auto directory = read_end(source, std::span(tail).subspan(at), begin + at);
    if (!directory) continue;
    if (auto entries = read_directory(source, *directory)) return entries;
  }
  return std::nullopt;
}

// Where the bytes of a member begin: after its local header, whose names may have another length.
std::optional<std::uint64_t> data_place(const zip_source& source, const Entry& entry) {
  std::array<std::uint8_t, local_bytes> header{};
  if (!source.read(entry.place, header)) return std::nullopt;
  Fields fields(header);
  fields.skip(26);
  const std::uint64_t name = fields.two();
  return entry.place + local_bytes + name + fields.two();
}

}  // namespace

struct zip {
  std::unique_ptr<zip_source> source;
  std::vector<Entry> entries;
};

struct zip_file {
  const zip_source* source = nullptr;
  Entry entry;
  bool raw = false;
  bool failed = false;
  std::uint64_t place = 0;
  std::uint64_t left = 0;
  std::uint64_t made = 0;
  std::uint32_t checksum = 0;
  // Only of deflated data.
  std::unique_ptr<zlib::inflate_stream> inflater;
  std::vector<std::uint8_t> block;
  std::span<const std::uint8_t> input;
  bool ended = false;

  // Bytes as they are in the archive.
  std::optional<std::size_t> read_here(std::span<std::uint8_t> into) {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(left, into.size()));
    if (!source->read(place, into.first(count))) return std::nullopt;
    place += count;
    left -= count;
    return count;
  }

  std::optional<std::size_t> inflate(std::span<std::uint8_t> into) {
    std::size_t count = 0;
    while (count == 0 && !ended) {
      if (input.empty() && left != 0) {
        const auto got = read_here(block);
        if (!got) return std::nullopt;
        input = std::span(block).first(*got);
      }
      zlib::z_params step;
      step.next_in = input.data();
      step.avail_in = input.size();
      step.next_out = into.data();
      step.avail_out = into.size();
      boost::system::error_code result;
      const bool all = input.empty() && left == 0;
      if (all) {
        biss::wasm::inflate_last_code(*inflater, step, result);
      } else {
        inflater->write(step, zlib::Flush::none, result);
      }
      input = input.last(step.avail_in);
      count = into.size() - step.avail_out;
      ended = result == zlib::error::end_of_stream;
      const bool starved = result == zlib::error::need_buffers;
      if (result && !ended && !starved) return std::nullopt;
      if (all && count == 0 && !ended) return std::nullopt;
    }
    return count;
  }

  // At the end the checksum and the size are those of the directory.
  bool whole() const { return raw || (checksum == entry.checksum && made == entry.size_bytes); }
};

zip_source_t* zip_source_filep_create(std::FILE* file, zip_uint64_t /*start*/,
                                      zip_int64_t /*length*/, zip_error_t* /*error*/) {
  struct stat about {};
  if (::fstat(::fileno(file), &about) != 0 || about.st_size < 0) return nullptr;
  return new zip_source{.file = file, .size_bytes = static_cast<std::uint64_t>(about.st_size)};
}

zip_source_t* zip_source_buffer_create(const void* bytes, zip_uint64_t count, int /*free_later*/,
                                       zip_error_t* /*error*/) {
  return new zip_source{.bytes = static_cast<const std::uint8_t*>(bytes), .size_bytes = count};
}

void zip_source_free(zip_source_t* source) {
  if (source != nullptr && source->file != nullptr) std::fclose(source->file);
  delete source;
}

int zip_source_stat(zip_source_t* source, zip_stat_t* about) {
  about->size = source->size_bytes;
  about->valid = ZIP_STAT_SIZE;
  return 0;
}

zip_t* zip_open_from_source(zip_source_t* source, int /*flags*/, zip_error_t* /*error*/) {
  auto entries = find_directory(*source);
  if (!entries) return nullptr;
  return new zip{.source = std::unique_ptr<zip_source>(source), .entries = std::move(*entries)};
}

void zip_discard(zip_t* archive) {
  if (archive == nullptr) return;
  zip_source_free(archive->source.release());
  delete archive;
}

zip_int64_t zip_get_num_entries(zip_t* archive, zip_flags_t /*flags*/) {
  return static_cast<zip_int64_t>(archive->entries.size());
}

int zip_stat_index(zip_t* archive, zip_uint64_t index, zip_flags_t /*flags*/, zip_stat_t* about) {
  if (index >= archive->entries.size()) return -1;
  const Entry& entry = archive->entries[static_cast<std::size_t>(index)];
  *about = {.valid = ZIP_STAT_INDEX | ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_CRC |
                     ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD,
            .index = index,
            .size = entry.size_bytes,
            .comp_size = entry.compressed_bytes,
            .crc = entry.checksum,
            .comp_method = entry.method,
            .encryption_method = entry.encrypted ? ZIP_EM_TRAD_PKWARE : ZIP_EM_NONE};
  return 0;
}

zip_int64_t zip_name_locate(zip_t* archive, const char* name, zip_flags_t /*flags*/) {
  const auto found = std::find_if(archive->entries.begin(), archive->entries.end(),
                                  [name](const Entry& entry) { return entry.name == name; });
  return found == archive->entries.end() ? -1 : found - archive->entries.begin();
}

const char* zip_get_name(zip_t* archive, zip_uint64_t index, zip_flags_t /*flags*/) {
  if (index >= archive->entries.size()) return nullptr;
  return archive->entries[static_cast<std::size_t>(index)].name.c_str();
}

zip_file_t* zip_fopen_index(zip_t* archive, zip_uint64_t index, zip_flags_t flags) {
  constexpr std::size_t block_bytes = 65'536;
  if (index >= archive->entries.size()) return nullptr;
  const Entry& entry = archive->entries[static_cast<std::size_t>(index)];
  const auto place = data_place(*archive->source, entry);
  if (!place) return nullptr;
  auto file = std::make_unique<zip_file>();
  file->source = archive->source.get();
  file->entry = entry;
  file->raw = (flags & ZIP_FL_COMPRESSED) != 0;
  file->place = *place;
  file->left = entry.compressed_bytes;
  if (!file->raw) {
    if (entry.encrypted) return nullptr;
    if (entry.method == ZIP_CM_DEFLATE) {
      file->inflater = std::make_unique<zlib::inflate_stream>();
      file->block.resize(block_bytes);
    } else if (entry.method != ZIP_CM_STORE) {
      return nullptr;
    }
  }
  return file.release();
}

zip_int64_t zip_fread(zip_file_t* file, void* into, zip_uint64_t count) {
  if (file->failed) return -1;
  if (count == 0) return 0;
  const std::span<std::uint8_t> bytes(static_cast<std::uint8_t*>(into),
                                      static_cast<std::size_t>(count));
  const auto got = file->inflater ? file->inflate(bytes) : file->read_here(bytes);
  if (got && *got != 0) {
    file->made += *got;
    if (!file->raw) file->checksum = libdeflate_crc32(file->checksum, into, *got);
    return static_cast<zip_int64_t>(*got);
  }
  file->failed = !got || !file->whole();
  return file->failed ? -1 : 0;
}

int zip_fclose(zip_file_t* file) {
  delete file;
  return 0;
}
