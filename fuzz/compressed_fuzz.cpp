// Captures compressed by gzip or zstd: hostile text inside, and damaged compressed data.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "capture/compressed.hpp"
#include "capture/open.hpp"
#include "fuzz/byte_mutator.hpp"
#include "fuzz/capture_check.hpp"
#include "fuzz/compress.hpp"
#include "fuzz/token_mutator.hpp"

namespace {

// The part that can be decompressed, up to 64 KiB.
std::string text_of(std::string_view bytes) {
  constexpr std::size_t most_bytes = 65'536;
  const auto compression = biss::capture::compression_of(bytes);
  if (compression == biss::capture::Compression::none) return {};
  const auto source = biss::capture::decompressed(biss::capture::memory_bytes(bytes), compression);
  std::string text;
  std::array<char, 4'096> block{};
  while (text.size() < most_bytes) {
    const auto got = source->read(block);
    if (!got.ok() || *got == 0) break;
    text.append(block.data(), *got);
  }
  return text;
}

void damage(std::string& bytes, biss::fuzz::SplitMix& random) {
  const std::size_t at = random() % bytes.size();
  switch (random() % 4) {
    case 0:
      bytes.resize(at + 1);
      return;
    case 1:
      bytes.erase(at, 1 + random() % 8);
      return;
    case 2:
      bytes.insert(at, 1 + random() % 8, static_cast<char>(random() % 3));
      return;
    default:
      bytes[at] ^= static_cast<char>(1U << random() % 8);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  biss::fuzz::check_reader(bytes, [](std::unique_ptr<biss::capture::ByteSource> source) {
    return biss::capture::open_capture(std::move(source), "x.vcd.gz");
  });
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  static constexpr std::array<std::string_view, 14> words{
      "#0",       "#18446744073709551615", "0!",    "1!",     "x!", "$dumpoff", "$end",
      "$comment", "time_ns,MA,SLO",        "0,1,1", "-1,0,x", "\n", "1,,",      "1e3,1,0"};
  constexpr std::size_t smallest_capture = 64;
  biss::fuzz::SplitMix random{seed};
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  std::string changed = bytes;
  if (random() % 8 == 0 && size != 0) {
    damage(changed, random);
  } else {
    std::string text = random() % 8 == 0 ? std::string() : text_of(bytes);
    if (text.size() < smallest_capture) text = biss::fuzz::text_to_compress(random());
    text = biss::fuzz::TokenMutator(std::move(text), " ,\n", words, random()).mutate();
    changed = biss::fuzz::compressed_in_parts(text, random);
    if (random() % 16 == 0) damage(changed, random);
  }
  return biss::fuzz::put_mutated(changed, bytes, data, max_size);
}
