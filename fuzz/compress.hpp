// Captures compressed by gzip and zstd as seeds.
#pragma once

#include <zlib.h>
#include <zstd.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "capture/event_csv.hpp"
#include "capture/vcd.hpp"
#include "fuzz/capture_seeds.hpp"

namespace biss::fuzz {

/// One gzip member. Level 0 stores, so that a changed byte changes the text.
inline std::string gzip_of(std::string_view text, int level) {
  z_stream stream{};
  deflateInit2(&stream, level, Z_DEFLATED, 9 + 16, 1, Z_DEFAULT_STRATEGY);
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

/// One frame of zstd.
inline std::string zstd_of(std::string_view text, int level) {
  static ZSTD_CCtx* const context = ZSTD_createCCtx();
  std::string bytes(ZSTD_compressBound(text.size()), '\0');
  bytes.resize(
      ZSTD_compressCCtx(context, bytes.data(), bytes.size(), text.data(), text.size(), level));
  return bytes;
}

/// The text in one or two members of either kind.
inline std::string compressed_in_parts(std::string_view text, SplitMix& random) {
  const bool gzip = random() % 2 == 0;
  const std::size_t first = random() % 4 == 0 ? random() % (text.size() + 1) : text.size();
  std::string bytes;
  for (const std::string_view part : {text.substr(0, first), text.substr(first)}) {
    if (part.empty() && !bytes.empty()) continue;
    const int level = static_cast<int>(random() % 2);
    bytes += gzip ? gzip_of(part, level) : zstd_of(part, level);
  }
  return bytes;
}

/// A VCD or an event CSV of some cycles, compressed.
inline std::string compressed_seed(std::uint64_t seed) {
  SplitMix random{seed};
  const std::string text = seed % 2 == 0 ? seed_text<capture::VcdWriter>(seed)
                                         : seed_text<capture::EventCsvWriter>(seed);
  return compressed_in_parts(text, random);
}

}  // namespace biss::fuzz
