// Text compressed for tests.
#pragma once

#include <zlib.h>
#include <zstd.h>

#include <memory>
#include <string>
#include <string_view>

namespace biss::capture {

/// How gzip is made. Level 0 stores, so that a changed byte changes the text.
struct GzipSettings {
  int level = 6;
  int window_bits = 15;
  int memory_level = 8;
};

/// One gzip member.
inline std::string gzip_of(std::string_view text, const GzipSettings& settings = {}) {
  z_stream stream{};
  deflateInit2(&stream, settings.level, Z_DEFLATED, settings.window_bits + 16,
               settings.memory_level, Z_DEFAULT_STRATEGY);
  std::string bytes(deflateBound(&stream, static_cast<uLong>(text.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  deflate(&stream, Z_FINISH);
  bytes.resize(bytes.size() - stream.avail_out);
  deflateEnd(&stream);
  return bytes;
}

/// One frame of zstd with its checksum.
inline std::string zstd_of(std::string_view text, int level = ZSTD_CLEVEL_DEFAULT) {
  static const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                            ZSTD_freeCCtx);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, level);
  std::string bytes(ZSTD_compressBound(text.size()), '\0');
  bytes.resize(ZSTD_compress2(context.get(), bytes.data(), bytes.size(), text.data(), text.size()));
  return bytes;
}

}  // namespace biss::capture
