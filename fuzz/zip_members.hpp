// Splits ZIP archives into members and joins members into archives, for mutations of the members
// without the cost of compression. It does not read archives of other programs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "capture/zip.hpp"
#include "fuzz/capture_seeds.hpp"

namespace biss::fuzz {

struct ZipText {
  std::string name;
  std::string text;
};

// Fields of PKWARE's APPNOTE, 4.3.7 and 4.3.12; a block of stored bytes is RFC 1951, 3.2.4.
inline constexpr std::string_view zip_local = "PK\x03\x04";
inline constexpr std::size_t zip_local_bytes = 30;
inline constexpr std::size_t stored_block_bytes = 5;

inline std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

inline std::size_t get_little(std::string_view text, std::size_t at, std::size_t bytes) {
  std::size_t value = 0;
  while (bytes-- > 0) value = value << 8U | static_cast<unsigned char>(text[at + bytes]);
  return value;
}

inline void put_little(std::string& out, std::uint64_t value, std::size_t bytes) {
  for (; bytes-- > 0; value >>= 8U) out += static_cast<char>(value & 0xFFU);
}

/// Inflates a text of `size` bytes; nothing if it is damaged.
inline std::optional<std::string> inflated(std::string_view data, std::size_t size) {
  if (data.size() == stored_block_bytes + size && data[0] == 1) {
    return std::string(data.substr(stored_block_bytes));
  }
  static capture::Inflater inflater;
  std::string text(size, '\0');
  const std::span<std::uint8_t> into(reinterpret_cast<std::uint8_t*>(text.data()), size);
  if (!inflater.inflate(bytes_of(data), into)) return std::nullopt;
  return text;
}

/// The members up to the first damaged one, without those of more than `most_bytes`.
inline std::vector<ZipText> unpack_zip(std::string_view archive, std::size_t most_bytes) {
  std::vector<ZipText> members;
  while (archive.size() >= zip_local_bytes && archive.starts_with(zip_local)) {
    const std::size_t method = get_little(archive, 8, 2);
    const std::size_t packed = get_little(archive, 18, 4);
    const std::size_t size = get_little(archive, 22, 4);
    const std::size_t name_bytes = get_little(archive, 26, 2);
    const std::size_t head = zip_local_bytes + name_bytes + get_little(archive, 28, 2);
    if (archive.size() < head + packed) break;
    const std::string_view data = archive.substr(head, packed);
    std::optional<std::string> text;
    if (method == 0) text = std::string(data);
    if (method == 8 && size <= most_bytes) text = inflated(data, size);
    if (!text) break;
    if (text->size() <= most_bytes) {
      members.push_back({std::string(archive.substr(zip_local_bytes, name_bytes)), *text});
    }
    archive.remove_prefix(head + packed);
  }
  return members;
}

/// An archive of these members: some stored, most deflated into a block without compression, a few
/// compressed, at random.
class ZipPacker {
 public:
  explicit ZipPacker(SplitMix& random) : random_(random) {}

  std::string pack(const std::vector<ZipText>& members) {
    const bool compressed = random_() % 16 == 0;
    for (const ZipText& member : members) add(member, compressed);
    const std::size_t directory = out_.size();
    out_ += directory_;
    out_ += "PK\x05\x06";
    put_little(out_, 0, 4);
    put_little(out_, members.size(), 2);
    put_little(out_, members.size(), 2);
    put_little(out_, directory_.size(), 4);
    put_little(out_, directory, 4);
    put_little(out_, 0, 2);
    return std::move(out_);
  }

 private:
  void add(const ZipText& member, bool compressed) {
    const bool too_long = member.text.size() > 0xFFFF;
    const bool deflated = compressed || too_long || random_() % 4 != 0;
    std::string data;
    if (compressed || too_long) {
      static capture::Deflater deflater;
      deflater.deflate(bytes_of(member.text), data);
    } else {
      if (deflated) {
        data += '\1';
        put_little(data, member.text.size(), 2);
        put_little(data, ~member.text.size(), 2);
      }
      data += member.text;
    }
    // The fields that a local header and the directory share: version, flags, method, date and
    // sizes.
    std::string shared;
    put_little(shared, 20, 2);
    put_little(shared, 0x0800, 2);
    put_little(shared, deflated ? 8 : 0, 2);
    put_little(shared, 0x0021'0000, 4);
    put_little(shared, capture::zip_checksum(bytes_of(member.text)), 4);
    put_little(shared, data.size(), 4);
    put_little(shared, member.text.size(), 4);
    put_little(shared, member.name.size(), 2);
    put_little(shared, 0, 2);
    directory_ += "PK\x01\x02";
    put_little(directory_, 0x0314, 2);
    directory_ += shared;
    put_little(directory_, 0, 10);
    put_little(directory_, out_.size(), 4);
    directory_ += member.name;
    out_ += zip_local;
    out_ += shared;
    out_ += member.name;
    out_ += data;
  }

  SplitMix& random_;
  std::string out_;
  std::string directory_;
};

}  // namespace biss::fuzz
