#include "capture/zip_writer.hpp"

#include <limits>

namespace biss::capture {
namespace {

constexpr std::uint64_t most_bytes = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t most_members = std::numeric_limits<std::uint16_t>::max();

// Sizes and numbers of PKWARE's APPNOTE, 4.3.7, 4.3.12 and 4.3.16.
constexpr std::size_t directory_entry_bytes = 46;
constexpr std::size_t directory_end_bytes = 22;
constexpr std::uint16_t version_needed = 20;
constexpr std::uint16_t deflated = 8;
constexpr std::uint16_t utf8_names = 0x0800;
constexpr std::uint16_t first_date = 1U << 5U | 1U;

void put16(std::string& out, std::uint64_t value) {
  out += static_cast<char>(value & 0xFFU);
  out += static_cast<char>(value >> 8U & 0xFFU);
}

void put32(std::string& out, std::uint64_t value) {
  put16(out, value & 0xFFFFU);
  put16(out, value >> 16U & 0xFFFFU);
}

}  // namespace

bool ZipWriter::add(std::string_view name, std::span<const std::uint8_t> bytes, std::string& out) {
  std::string data;
  deflater_.deflate(bytes, data);
  std::string header = "PK\x03\x04";
  for (const unsigned field :
       {unsigned{version_needed}, unsigned{utf8_names}, unsigned{deflated}}) {
    put16(header, field);
  }
  put16(header, 0);
  put16(header, first_date);
  const std::uint32_t checksum = zip_checksum(bytes);
  put32(header, checksum);
  put32(header, data.size());
  put32(header, bytes.size());
  put16(header, name.size());
  put16(header, 0);
  header += name;
  const std::uint64_t directory = directory_bytes_ + directory_entry_bytes + name.size();
  const std::uint64_t after = written_bytes_ + header.size() + data.size();
  if (members_.size() == most_members) return false;
  if (after + directory + directory_end_bytes > most_bytes) return false;
  members_.push_back({std::string(name), checksum, static_cast<std::uint32_t>(data.size()),
                      static_cast<std::uint32_t>(bytes.size()),
                      static_cast<std::uint32_t>(written_bytes_)});
  written_bytes_ = after;
  directory_bytes_ = directory;
  out += header;
  out += data;
  return true;
}

bool ZipWriter::add(std::string_view name, std::string_view text, std::string& out) {
  return add(name, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, out);
}

void ZipWriter::finish(std::string& out) {
  constexpr std::uint16_t unix_3 = 3U << 8U;
  constexpr std::uint32_t plain_file_rw = 0100644U << 16U;
  for (const Member& member : members_) {
    out += "PK\x01\x02";
    put16(out, unix_3 | version_needed);
    put16(out, version_needed);
    put16(out, utf8_names);
    put16(out, deflated);
    put16(out, 0);
    put16(out, first_date);
    put32(out, member.checksum);
    put32(out, member.compressed_bytes);
    put32(out, member.size_bytes);
    put16(out, member.name.size());
    for (int i = 0; i < 4; ++i) put16(out, 0);  // no extra field, comment, other disk; binary
    put32(out, plain_file_rw);
    put32(out, member.place);
    out += member.name;
  }
  out += "PK\x05\x06";
  put32(out, 0);  // this disk and the directory's are the first
  put16(out, members_.size());
  put16(out, members_.size());
  put32(out, directory_bytes_);
  put32(out, written_bytes_);
  put16(out, 0);
}

}  // namespace biss::capture
