// Frames whose maker computes the checksum in a different way: the rule is found, and where a
// format reads such frames, it is named.
#include "explain/checksum_variant.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "biss/crc/engines.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/format_text.hpp"

namespace biss::explain::checksum_variant_test {

constexpr unsigned position_bits = 22;
constexpr unsigned data_bits = position_bits + 2;
constexpr CrcSpec usual{.polynomial = 0x43, .width_bits = 6};

using Maker = std::function<std::uint64_t(std::uint64_t data, std::uint64_t before, bool cds)>;

std::uint64_t checksum(std::uint64_t data, unsigned bits) { return CrcBitwise(usual)(data, bits); }

std::uint64_t backwards(std::uint64_t value, unsigned bits) {
  std::uint64_t out = 0;
  for (unsigned i = 0; i < bits; ++i) out = out << 1U | (value >> i & 1U);
  return out;
}

// A position that moves, both flags inactive. CDS is 1 in every frame.
std::vector<WrongFrame> frames_of(const Maker& maker) {
  std::vector<WrongFrame> frames;
  decode::RawBits last;
  std::uint64_t before = 0;
  for (std::uint64_t i = 0; i < 60; ++i) {
    const std::uint64_t data = (10'000 + 1'237 * i) << 2U | 3U;
    decode::RawBits raw;
    raw.append(3, 2);
    raw.append(data, data_bits);
    raw.append(maker(data, before, true), 6);
    raw.append(false);
    if (i != 0) frames.push_back({raw, last});
    last = raw;
    before = data;
  }
  return frames;
}

struct Case {
  Mistake mistake{};
  std::string format{};
  Maker maker{};
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {Mistake::reversed, "pos22,nE,nW,crc6:reversed",
       [](auto data, auto, auto) { return backwards(checksum(data, data_bits), 6); }},
      {Mistake::no_flags, "pos22,nE,nW,crc6:no-flags",
       [](auto data, auto, auto) { return checksum(data >> 2U, position_bits); }},
      {Mistake::cds, "pos22,nE,nW,crc6:cds",
       [](auto data, auto, bool cds) {
         return checksum(data | std::uint64_t{cds} << data_bits, data_bits + 1);
       }},
      {Mistake::previous, "pos22,nE,nW,crc6:previous",
       [](auto, auto before, auto) { return checksum(before, data_bits); }},
      // The data come in the usual order: no format reads them with such a checksum.
      {Mistake::lsb, "",
       [](auto data, auto, auto) {
         return checksum(backwards(data >> 2U, position_bits) << 2U | (data & 3U), data_bits);
       }},
      {Mistake::other_start, "",
       [](auto data, auto, auto) { return checksum(data, data_bits) ^ 0x15U; }},
      {Mistake::constant, "", [](auto, auto, auto) { return std::uint64_t{0x2A}; }}};
  return all;
}

TEST(ChecksumVariant, EachMistakeOfAMaker_IsFoundWithTheFormatThatReadsItsFrames) {
  for (const Case& each : cases()) {
    const auto frames = frames_of(each.maker);
    const auto found = find_variant(frames, *parse_format("pos22,nE,nW,crc6"), data_bits + 6);
    ASSERT_TRUE(found) << each.format;
    EXPECT_EQ(found->mistake, each.mistake) << each.format;
    EXPECT_EQ(found->format, each.format);
    if (each.mistake >= Mistake::other_start) continue;
    const auto unknown = find_variant(frames, std::nullopt, data_bits + 6);
    ASSERT_TRUE(unknown) << each.format;
    EXPECT_EQ(unknown->mistake, each.mistake);
    EXPECT_EQ(unknown->format, each.format);
  }
}

TEST(ChecksumVariant, UsualChecksum_IsNoMistake) {
  const auto frames = frames_of([](auto data, auto, auto) { return checksum(data, data_bits); });
  EXPECT_FALSE(find_variant(frames, *parse_format("pos22,nE,nW,crc6"), data_bits + 6));
  EXPECT_FALSE(find_variant(frames, std::nullopt, data_bits + 6));
}

}  // namespace biss::explain::checksum_variant_test
