#include "verbs/report/packed.hpp"

#include <openssl/evp.h>

#include <cstdint>
#include <span>

#include "capture/zip.hpp"

namespace biss::verbs {

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
  std::string out((bytes.size() + 2) / 3 * 4 + 1, '\0');
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data()),
                  reinterpret_cast<const unsigned char*>(bytes.data()),
                  static_cast<int>(bytes.size()));
  out.pop_back();  // the zero that it writes
  return out;
}

}  // namespace

std::string packed(std::string_view bytes) { return base64_of(gzip_of(bytes)); }

}  // namespace biss::verbs
