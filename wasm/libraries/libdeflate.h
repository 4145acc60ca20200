// The functions of libdeflate that the readers use: an inflater of our own, and the compressor of
// Boost.Beast.
#pragma once

#include <cstddef>
#include <cstdint>

struct libdeflate_decompressor;
struct libdeflate_compressor;

enum libdeflate_result {
  LIBDEFLATE_SUCCESS = 0,
  LIBDEFLATE_BAD_DATA = 1,
  LIBDEFLATE_SHORT_OUTPUT = 2,
  LIBDEFLATE_INSUFFICIENT_SPACE = 3,
};

libdeflate_decompressor* libdeflate_alloc_decompressor();
void libdeflate_free_decompressor(libdeflate_decompressor* decompressor);

/// Decompresses one stream at the front of `in`; `used` and `made` are the bytes taken and given.
libdeflate_result libdeflate_deflate_decompress_ex(libdeflate_decompressor* decompressor,
                                                   const void* in, std::size_t in_bytes, void* out,
                                                   std::size_t out_bytes, std::size_t* used,
                                                   std::size_t* made);
libdeflate_result libdeflate_zlib_decompress_ex(libdeflate_decompressor* decompressor,
                                                const void* in, std::size_t in_bytes, void* out,
                                                std::size_t out_bytes, std::size_t* used,
                                                std::size_t* made);
libdeflate_result libdeflate_gzip_decompress_ex(libdeflate_decompressor* decompressor,
                                                const void* in, std::size_t in_bytes, void* out,
                                                std::size_t out_bytes, std::size_t* used,
                                                std::size_t* made);

libdeflate_compressor* libdeflate_alloc_compressor(int level);
void libdeflate_free_compressor(libdeflate_compressor* compressor);
std::size_t libdeflate_deflate_compress_bound(libdeflate_compressor* compressor,
                                              std::size_t in_bytes);
std::size_t libdeflate_deflate_compress(libdeflate_compressor* compressor, const void* in,
                                        std::size_t in_bytes, void* out, std::size_t out_bytes);

/// CRC-32 of RFC 1952, of bytes that follow those whose CRC-32 is `before`.
std::uint32_t libdeflate_crc32(std::uint32_t before, const void* bytes, std::size_t count);
