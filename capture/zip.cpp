#include "capture/zip.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <new>
#include <utility>

#include "capture/gather.hpp"
#include "capture/little_endian.hpp"

namespace biss::capture {
namespace {

// Captures repeat themselves: beyond this level the files do not get smaller, and take longer.
constexpr int compression_level = 6;

template <class T>
T* or_throw(T* allocated) {
  if (allocated == nullptr) throw std::bad_alloc();
  return allocated;
}

using Source = std::unique_ptr<zip_source_t, Released<zip_source_free>>;

Source source_of_file(Stdio file) {
  if (!file) return nullptr;
  Source source(zip_source_filep_create(file.get(), 0, -1, nullptr));
  if (source) static_cast<void>(file.release());  // the source closes it
  return source;
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

// Fills `into` from a file whose reads may be shorter.
bool fill(zip_file_t* file, std::span<std::uint8_t> into) {
  while (!into.empty()) {
    const zip_int64_t got = zip_fread(file, into.data(), into.size());
    if (got <= 0) return false;
    into = into.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

constexpr std::uint64_t most_bytes = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t most_members = std::numeric_limits<std::uint16_t>::max();

// Sizes and numbers of PKWARE's APPNOTE, 4.3.7, 4.3.12 and 4.3.16.
constexpr std::size_t directory_entry_bytes = 46;
constexpr std::size_t directory_end_bytes = 22;
constexpr std::uint16_t version_needed = 20;
constexpr std::uint16_t deflated = 8;
constexpr std::uint16_t utf8_names = 0x0800;
constexpr std::uint16_t first_date = 1U << 5U | 1U;

}  // namespace

Inflater::Inflater() : decompressor_(or_throw(libdeflate_alloc_decompressor())) {}

Deflater::Deflater() : compressor_(or_throw(libdeflate_alloc_compressor(compression_level))) {}

bool Inflater::inflate(std::span<const std::uint8_t> compressed, std::span<std::uint8_t> into,
                       DeflateFrame frame) {
  std::size_t used = 0;
  std::size_t made = 0;
  const auto decompress = frame == DeflateFrame::none   ? libdeflate_deflate_decompress_ex
                          : frame == DeflateFrame::zlib ? libdeflate_zlib_decompress_ex
                                                        : libdeflate_gzip_decompress_ex;
  const auto result = decompress(decompressor_.get(), compressed.data(), compressed.size(),
                                 into.data(), into.size(), &used, &made);
  return result == LIBDEFLATE_SUCCESS && used == compressed.size() && made == into.size();
}

void Deflater::deflate(std::span<const std::uint8_t> bytes, std::string& out) {
  const std::size_t before = out.size();
  out.resize(before + libdeflate_deflate_compress_bound(compressor_.get(), bytes.size()));
  const std::size_t made = libdeflate_deflate_compress(
      compressor_.get(), bytes.data(), bytes.size(), out.data() + before, out.size() - before);
  out.resize(before + made);
}

std::string Deflater::gzip(std::string_view bytes) {
  std::string out(libdeflate_gzip_compress_bound(compressor_.get(), bytes.size()), '\0');
  out.resize(libdeflate_gzip_compress(compressor_.get(), bytes.data(), bytes.size(), out.data(),
                                      out.size()));
  return out;
}

std::uint32_t zip_checksum(std::span<const std::uint8_t> bytes) {
  return zip_checksum_after(0, bytes);
}

CaptureError unread_member(std::string_view name, const char* expected) {
  CaptureError error{.cause = CaptureCause::malformed, .expected = expected};
  name = name.substr(0, error.member.size() - 1);
  std::transform(name.begin(), name.end(), error.member.begin(),
                 [](char c) { return c < ' ' || c > '~' ? '?' : c; });
  return error;
}

bool looks_like_zip(std::string_view head) {
  return head.starts_with("PK\x03\x04") || head.starts_with("PK\x05\x06");
}

OpenedZip ZipArchive::open(std::unique_ptr<ByteSource> bytes) {
  auto gathered = gather(std::move(bytes));
  if (!gathered) return tl::unexpected(gathered.error());
  std::unique_ptr<ZipArchive> archive(new ZipArchive);
  std::string& memory = archive->memory_ = std::move(gathered->memory);
  Source source = gathered->file
                      ? source_of_file(std::move(gathered->file))
                      : Source(zip_source_buffer_create(memory.data(), memory.size(), 0, nullptr));
  zip_stat_t about{};
  if (!source || zip_source_stat(source.get(), &about) != 0) {
    return tl::unexpected(CaptureError{.cause = CaptureCause::read_failed});
  }
  const auto damaged = [](const char* expected) {
    return tl::unexpected(CaptureError{.cause = CaptureCause::damaged, .expected = expected});
  };
  archive->archive_.reset(zip_open_from_source(source.get(), ZIP_RDONLY, nullptr));
  if (!archive->archive_) return damaged("a ZIP archive with its directory at the end");
  static_cast<void>(source.release());  // the archive frees it
  if (archive->members_overlap(about.size)) {
    return damaged("members that fit into the file, each in a place of its own");
  }
  std::vector<std::string> all = archive->names("");
  std::sort(all.begin(), all.end());
  const auto twice = std::adjacent_find(all.begin(), all.end());
  if (twice != all.end()) {
    return tl::unexpected(unread_member(*twice, "one member of this name"));
  }
  return archive;
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

std::vector<std::string> ZipArchive::names(std::string_view begin) const {
  const zip_int64_t entries = zip_get_num_entries(archive_.get(), 0);
  std::vector<std::string> found;
  for (zip_int64_t i = 0; i < entries; ++i) {
    const char* const name =
        zip_get_name(archive_.get(), static_cast<zip_uint64_t>(i), ZIP_FL_ENC_RAW);
    if (name != nullptr && std::string_view(name).starts_with(begin)) found.emplace_back(name);
  }
  return found;
}

bool ZipArchive::read_compressed(const ZipMember& member, std::span<std::uint8_t> into) {
  const File file(zip_fopen_index(archive_.get(), member.index, ZIP_FL_COMPRESSED));
  return file && fill(file.get(), into);
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

bool ZipArchive::read_whole(const ZipMember& member, std::span<std::uint8_t> into) {
  if (!begin_stream(member) || !fill(stream_.get(), into)) return false;
  // The checksum is verified at the end.
  std::uint8_t more = 0;
  return read_stream({&more, 1}) == std::size_t{0};
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

bool ZipWriter::add(std::string_view name, std::string_view text, std::string& out) {
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  std::string data;
  deflater_.deflate(bytes, data);
  const Member member{
      std::string(name), zip_checksum(bytes), static_cast<std::uint32_t>(data.size()),
      static_cast<std::uint32_t>(text.size()), static_cast<std::uint32_t>(written_bytes_)};
  std::string header = "PK\x03\x04";
  put_fields(header, member);
  put_number(header, 0, 2);
  header += name;
  const std::uint64_t directory = directory_bytes_ + directory_entry_bytes + name.size();
  const std::uint64_t after = written_bytes_ + header.size() + data.size();
  if (members_.size() == most_members) return false;
  if (after + directory + directory_end_bytes > most_bytes) return false;
  members_.push_back(member);
  written_bytes_ = after;
  directory_bytes_ = directory;
  out += header;
  out += data;
  return true;
}

// The fields that the header of a member and its entry in the directory have in common.
void ZipWriter::put_fields(std::string& out, const Member& member) {
  put_numbers(out, 2, {version_needed, utf8_names, deflated, 0, first_date});
  put_numbers(out, 4, {member.checksum, member.compressed_bytes, member.size_bytes});
  put_number(out, member.name.size(), 2);
}

void ZipWriter::finish(std::string& out) {
  constexpr std::uint16_t unix_3 = 3U << 8U;
  constexpr std::uint32_t plain_file_rw = 0100644U << 16U;
  for (const Member& member : members_) {
    out += "PK\x01\x02";
    put_number(out, unix_3 | version_needed, 2);
    put_fields(out, member);
    put_numbers(out, 2, {0, 0, 0, 0});  // no extra field, comment, other disk; binary
    put_numbers(out, 4, {plain_file_rw, member.place});
    out += member.name;
  }
  out += "PK\x05\x06";
  // This disk and the directory's are the first.
  put_numbers(out, 2, {0, 0, members_.size(), members_.size()});
  put_numbers(out, 4, {directory_bytes_, written_bytes_});
  put_number(out, 0, 2);
}

}  // namespace biss::capture
