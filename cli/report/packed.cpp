#include "cli/report/packed.hpp"

#include <algorithm>
#include <cstdint>
#include <span>

#include "capture/zip.hpp"

namespace biss::cli {

namespace {

void append_little(std::uint32_t value, std::string& out) {
  for (unsigned shift = 0; shift < 32; shift += 8) {
    out += static_cast<char>((value >> shift) & 0xFFU);
  }
}

// RFC 1952, without a name and a time.
std::string gzip_of(std::string_view bytes) {
  const std::span data(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  std::string out("\x1f\x8b\x08\x00\x00\x00\x00\x00\x00\xff", 10);
  capture::Deflater().deflate(data, out);
  append_little(capture::zip_checksum(data), out);
  append_little(static_cast<std::uint32_t>(bytes.size()), out);
  return out;
}

std::string base64_of(std::string_view bytes) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - at);
    std::uint32_t group = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      group = group << 8U | (i < count ? static_cast<std::uint8_t>(bytes[at + i]) : 0U);
    }
    for (std::size_t i = 0; i < 4; ++i) {
      out += i <= count ? digits[(group >> (18 - 6 * i)) & 63U] : '=';
    }
  }
  return out;
}

}  // namespace

std::string packed(std::string_view bytes) { return base64_of(gzip_of(bytes)); }

}  // namespace biss::cli
