// Deflate, zlib and gzip over memory.
#include <libdeflate.h>

#include <algorithm>
#include <boost/beast/zlib/deflate_stream.hpp>
#include <cstring>
#include <new>
#include <span>

#include "wasm/libraries/gzip_header.hpp"
#include "wasm/libraries/whole_inflate.hpp"

namespace zlib = boost::beast::zlib;

struct libdeflate_decompressor {
  biss::wasm::WholeInflater inflater;
};

struct libdeflate_compressor {
  zlib::deflate_stream stream;
  int level;
};

namespace {

using Bytes = std::span<const std::uint8_t>;

std::uint32_t adler32(Bytes bytes) {
  constexpr std::uint32_t modulus = 65'521;
  constexpr std::size_t most_before_overflow = 5'552;
  std::uint32_t a = 1;
  std::uint32_t b = 0;
  while (!bytes.empty()) {
    const Bytes some = bytes.first(std::min(bytes.size(), most_before_overflow));
    bytes = bytes.subspan(some.size());
    for (const std::uint8_t byte : some) {
      a += byte;
      b += a;
    }
    a %= modulus;
    b %= modulus;
  }
  return b << 16U | a;
}

std::uint32_t little32(const std::uint8_t* at) {
  std::uint32_t value = 0;
  std::memcpy(&value, at, sizeof value);
  return value;
}

std::uint32_t big32(const std::uint8_t* at) { return __builtin_bswap32(little32(at)); }

// Where the Deflate stream of a gzip member begins; 0 where there is none.
std::size_t gzip_header_bytes(Bytes in) {
  using biss::wasm::GzipHeader;
  GzipHeader header;
  for (std::size_t i = 0; i < in.size(); ++i) {
    const GzipHeader::State state = header.take(in[i]);
    if (state == GzipHeader::State::complete) return i + 1;
    if (state == GzipHeader::State::wrong) break;
  }
  return 0;
}

// RFC 1950, 2.2.
bool is_zlib_header(Bytes in) {
  if (in.size() < 2) return false;
  const bool deflate = (in[0] & 0x0FU) == 8 && in[0] >> 4U <= 7;
  const bool dictionary = (in[1] & 0x20U) != 0;
  return deflate && !dictionary && (in[0] * 256U + in[1]) % 31 == 0;
}

}  // namespace

libdeflate_decompressor* libdeflate_alloc_decompressor() {
  return new (std::nothrow) libdeflate_decompressor;
}

void libdeflate_free_decompressor(libdeflate_decompressor* decompressor) { delete decompressor; }

libdeflate_result libdeflate_deflate_decompress_ex(libdeflate_decompressor* decompressor,
                                                   const void* in, std::size_t in_bytes, void* out,
                                                   std::size_t out_bytes, std::size_t* used,
                                                   std::size_t* made) {
  const auto found =
      decompressor->inflater.inflate({static_cast<const std::uint8_t*>(in), in_bytes},
                                     {static_cast<std::uint8_t*>(out), out_bytes});
  if (!found) return LIBDEFLATE_BAD_DATA;
  *used = found->used;
  *made = found->made;
  return LIBDEFLATE_SUCCESS;
}

libdeflate_result libdeflate_zlib_decompress_ex(libdeflate_decompressor* decompressor,
                                                const void* in, std::size_t in_bytes, void* out,
                                                std::size_t out_bytes, std::size_t* used,
                                                std::size_t* made) {
  constexpr std::size_t header = 2;
  const auto* const bytes = static_cast<const std::uint8_t*>(in);
  if (!is_zlib_header({bytes, in_bytes})) return LIBDEFLATE_BAD_DATA;
  const auto result = libdeflate_deflate_decompress_ex(
      decompressor, bytes + header, in_bytes - header, out, out_bytes, used, made);
  if (result != LIBDEFLATE_SUCCESS) return result;
  const std::size_t end = header + *used;
  if (in_bytes - end < sizeof(std::uint32_t)) return LIBDEFLATE_BAD_DATA;
  if (big32(bytes + end) != adler32({static_cast<const std::uint8_t*>(out), *made})) {
    return LIBDEFLATE_BAD_DATA;
  }
  *used = end + sizeof(std::uint32_t);
  return LIBDEFLATE_SUCCESS;
}

libdeflate_result libdeflate_gzip_decompress_ex(libdeflate_decompressor* decompressor,
                                                const void* in, std::size_t in_bytes, void* out,
                                                std::size_t out_bytes, std::size_t* used,
                                                std::size_t* made) {
  constexpr std::size_t trailer = 8;
  const auto* const bytes = static_cast<const std::uint8_t*>(in);
  const std::size_t header = gzip_header_bytes({bytes, in_bytes});
  if (header == 0) return LIBDEFLATE_BAD_DATA;
  const auto result = libdeflate_deflate_decompress_ex(
      decompressor, bytes + header, in_bytes - header, out, out_bytes, used, made);
  if (result != LIBDEFLATE_SUCCESS) return result;
  const std::size_t end = header + *used;
  if (in_bytes - end < trailer) return LIBDEFLATE_BAD_DATA;
  if (little32(bytes + end) != libdeflate_crc32(0, out, *made)) return LIBDEFLATE_BAD_DATA;
  if (little32(bytes + end + 4) != static_cast<std::uint32_t>(*made)) return LIBDEFLATE_BAD_DATA;
  *used = end + trailer;
  return LIBDEFLATE_SUCCESS;
}

libdeflate_compressor* libdeflate_alloc_compressor(int level) {
  auto* const compressor = new (std::nothrow) libdeflate_compressor;
  if (compressor != nullptr) compressor->level = level;
  return compressor;
}

void libdeflate_free_compressor(libdeflate_compressor* compressor) { delete compressor; }

// What zlib states for any level, and a reserve.
std::size_t libdeflate_deflate_compress_bound(libdeflate_compressor* /*compressor*/,
                                              std::size_t in_bytes) {
  return in_bytes + in_bytes / 8 + 64;
}

std::size_t libdeflate_deflate_compress(libdeflate_compressor* compressor, const void* in,
                                        std::size_t in_bytes, void* out, std::size_t out_bytes) {
  constexpr int window_bits = 15;
  constexpr int memory_level = 8;
  zlib::z_params step;
  step.next_in = in;
  step.avail_in = in_bytes;
  step.next_out = out;
  step.avail_out = out_bytes;
  boost::system::error_code result;
  compressor->stream.reset(compressor->level, window_bits, memory_level, zlib::Strategy::normal);
  compressor->stream.write(step, zlib::Flush::finish, result);
  return out_bytes - step.avail_out;
}
