// Captures compressed by gzip and zstd as seeds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "capture/event_csv.hpp"
#include "capture/test_compressed.hpp"
#include "capture/vcd.hpp"
#include "fuzz/capture_seeds.hpp"

namespace biss::fuzz {

/// The text in one or two members of either kind.
inline std::string compressed_in_parts(std::string_view text, SplitMix& random) {
  const bool gzip = random() % 2 == 0;
  const std::size_t first = random() % 4 == 0 ? random() % (text.size() + 1) : text.size();
  std::string bytes;
  for (const std::string_view part : {text.substr(0, first), text.substr(first)}) {
    if (part.empty() && !bytes.empty()) continue;
    const int level = static_cast<int>(random() % 2);
    bytes += gzip ? capture::gzip_of(part, {.level = level, .window_bits = 9, .memory_level = 1})
                  : capture::zstd_of(part, 1 - 6 * level);
  }
  return bytes;
}

/// A VCD or an event CSV of some cycles.
inline std::string text_to_compress(std::uint64_t seed) {
  return seed % 2 == 0 ? seed_text<capture::VcdWriter>(seed)
                       : seed_text<capture::EventCsvWriter>(seed);
}

/// The same, compressed.
inline std::string compressed_seed(std::uint64_t seed) {
  SplitMix random{seed};
  return compressed_in_parts(text_to_compress(seed), random);
}

}  // namespace biss::fuzz
