#include "wasm/libraries/whole_inflate.hpp"

#include <gtest/gtest.h>
#include <libdeflate.h>

#include <memory>
#include <random>
#include <string>
#include <vector>

namespace biss::wasm {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr unsigned seed = 20'260'101;

struct FreeCompressor {
  void operator()(libdeflate_compressor* compressor) const {
    libdeflate_free_compressor(compressor);
  }
};
struct FreeDecompressor {
  void operator()(libdeflate_decompressor* decompressor) const {
    libdeflate_free_decompressor(decompressor);
  }
};

Bytes deflated(const Bytes& bytes, int level) {
  const std::unique_ptr<libdeflate_compressor, FreeCompressor> compressor(
      libdeflate_alloc_compressor(level));
  Bytes out(libdeflate_deflate_compress_bound(compressor.get(), bytes.size()));
  out.resize(libdeflate_deflate_compress(compressor.get(), bytes.data(), bytes.size(), out.data(),
                                         out.size()));
  return out;
}

// What the library makes of the stream.
std::optional<Inflated> by_library(const Bytes& stream, Bytes& out) {
  static const std::unique_ptr<libdeflate_decompressor, FreeDecompressor> decompressor(
      libdeflate_alloc_decompressor());
  Inflated found;
  const auto result =
      libdeflate_deflate_decompress_ex(decompressor.get(), stream.data(), stream.size(), out.data(),
                                       out.size(), &found.used, &found.made);
  if (result != LIBDEFLATE_SUCCESS) return std::nullopt;
  return found;
}

// Samples of two lines that rest and are busy, with patterns of any short period.
Bytes samples(std::size_t count, std::mt19937& random) {
  Bytes bytes;
  while (bytes.size() < count) {
    const std::size_t period = 1 + random() % 40;
    Bytes pattern(period);
    for (auto& byte : pattern) byte = static_cast<std::uint8_t>(random() & 3U);
    const std::size_t length = 1 + random() % 3'000;
    for (std::size_t i = 0; i < length; ++i) bytes.push_back(pattern[i % period]);
  }
  bytes.resize(count);
  return bytes;
}

Bytes noise(std::size_t count, std::mt19937& random, unsigned mask) {
  Bytes bytes(count);
  // Some values far more often than others: their codes have very different lengths.
  for (auto& byte : bytes)
    byte = static_cast<std::uint8_t>((random() & random() & random()) & mask);
  return bytes;
}

std::vector<Bytes> contents() {
  std::mt19937 random(seed);
  std::vector<Bytes> all{{}, {7}, Bytes(1, 0), Bytes(300'000, 0x55)};
  for (const std::size_t count : {2U, 17U, 258U, 259U, 1'000U, 65'536U, 400'000U}) {
    all.push_back(samples(count, random));
    all.push_back(noise(count, random, 0xFF));
    all.push_back(noise(count, random, 0x0F));
  }
  return all;
}

TEST(WholeInflate, StreamOfEachLevel_GivesTheBytes) {
  WholeInflater inflater;
  for (const Bytes& content : contents()) {
    for (const int level : {0, 1, 3, 6, 9, 12}) {
      Bytes stream = deflated(content, level);
      const std::size_t whole = stream.size();
      for (const std::size_t behind : {0U, 1U, 9U}) {
        stream.resize(whole + behind, 0xFF);
        Bytes out(content.size());
        const auto found = inflater.inflate(stream, out);
        ASSERT_TRUE(found) << content.size() << " bytes, level " << level;
        EXPECT_EQ(found->used, whole);
        EXPECT_EQ(found->made, content.size());
        ASSERT_EQ(out, content);
      }
    }
  }
}

TEST(WholeInflate, RoomThatIsTooSmall_GivesNothing) {
  WholeInflater inflater;
  for (const Bytes& content : contents()) {
    if (content.empty()) continue;
    const Bytes stream = deflated(content, 6);
    Bytes out(content.size() - 1);
    EXPECT_FALSE(inflater.inflate(stream, out));
  }
}

TEST(WholeInflate, StreamThatIsCut_GivesNothing) {
  std::mt19937 random(seed);
  WholeInflater inflater;
  const Bytes content = samples(5'000, random);
  const Bytes stream = deflated(content, 6);
  Bytes out(content.size());
  for (std::size_t kept = 0; kept < stream.size(); ++kept) {
    EXPECT_FALSE(inflater.inflate(std::span(stream).first(kept), out)) << kept;
  }
}

// Also with room for more than the stream made before it was damaged.
TEST(WholeInflate, StreamThatIsDamaged_IsReadAsByTheLibrary) {
  std::mt19937 random(seed);
  WholeInflater inflater;
  std::size_t read = 0;
  for (int round = 0; round < 40'000; ++round) {
    const std::size_t count = 1 + random() % 600;
    const Bytes content = round % 2 == 0 ? samples(count, random) : noise(count, random, 0xFF);
    Bytes stream = deflated(content, round % 3 == 0 ? 1 : 9);
    for (auto damages = random() % 4; damages != 0; --damages) {
      // The codes are at the front.
      const std::size_t places =
          random() % 2 == 0 ? std::min<std::size_t>(stream.size(), 60) : stream.size();
      stream[random() % places] ^= static_cast<std::uint8_t>(1U << random() % 8);
    }
    Bytes expected(round % 5 == 0 ? count : 4 * count);
    Bytes out(expected.size());
    const auto by_libdeflate = by_library(stream, expected);
    const auto found = inflater.inflate(stream, out);
    ASSERT_EQ(found.has_value(), by_libdeflate.has_value()) << "round " << round;
    if (!found) continue;
    ++read;
    ASSERT_EQ(found->used, by_libdeflate->used);
    ASSERT_EQ(found->made, by_libdeflate->made);
    out.resize(found->made);
    expected.resize(found->made);
    ASSERT_EQ(out, expected) << "round " << round;
  }
  EXPECT_GT(read, 10'000U);
  EXPECT_LT(read, 38'000U);
}

}  // namespace
}  // namespace biss::wasm
