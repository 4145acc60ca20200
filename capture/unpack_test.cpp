#include "capture/unpack.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <span>
#include <string>

namespace biss::capture {
namespace unpack_test {

using namespace std::string_literals;

std::string unpacked(Packing packing, const std::string& packed, std::size_t size) {
  std::string text(size, '?');
  const std::span<std::uint8_t> into(reinterpret_cast<std::uint8_t*>(text.data()), size);
  const std::span<const std::uint8_t> from(reinterpret_cast<const std::uint8_t*>(packed.data()),
                                           packed.size());
  Inflater inflater;
  return unpack(packing, from, into, inflater) ? text : "failed";
}

TEST(Unpack, FastLz_CopiesLiteralsAndMatches) {
  // Three literals; a match of 3 at distance 3; one of 9 + 4 at distance 1.
  const std::string packed = "\2abc\x20\2\xE0\4\0"s;
  EXPECT_EQ(unpacked(Packing::fastlz, packed, 19), "abcabcccccccccccccc"s);
  EXPECT_EQ(unpacked(Packing::fastlz, packed, 18), "failed");
  EXPECT_EQ(unpacked(Packing::fastlz, packed, 20), "failed");
  for (std::size_t size = 1; size < packed.size(); ++size) {
    EXPECT_EQ(unpacked(Packing::fastlz, packed.substr(0, size), 19), "failed") << size;
  }
  EXPECT_EQ(unpacked(Packing::fastlz, "\0a\x20\1"s, 4), "failed");  // before the beginning
}

TEST(Unpack, FastLzLevel2_HasLongMatches) {
  // A literal, then 9 + 255 + 1 of them at distance 1.
  EXPECT_EQ(unpacked(Packing::fastlz, "\x20z\xE0\xFF\1\0"s, 266), std::string(266, 'z'));
  // 8200 bytes, and 3 from 8193 before: beyond what 13 bits hold.
  std::string packed = "\x23wxyz\xE0"s;
  for (int i = 0; i < 32; ++i) packed += '\xFF';
  packed += "\x1F\0"s;
  packed += "\x3F\xFF\0\1"s;
  const std::string text = unpacked(Packing::fastlz, packed, 4 + 9 + 32 * 255 + 31 + 3);
  EXPECT_EQ(text.substr(0, 6), "wxyzzz");
  EXPECT_EQ(text.substr(text.size() - 3), "zzz");
  EXPECT_EQ(unpacked(Packing::fastlz, "\x60z"s, 1), "failed");  // level 3
}

TEST(Unpack, OtherData_Fails) {
  for (const Packing packing : {Packing::zlib, Packing::gzip, Packing::lz4, Packing::fastlz}) {
    EXPECT_EQ(unpacked(packing, "", 3), "failed");
    EXPECT_EQ(unpacked(packing, "\xFF\xFF\xFF\xFF", 3), "failed");
  }
  EXPECT_EQ(unpacked(Packing::lz4,
                     "\x30"
                     "abc",
                     3),
            "abc");
  EXPECT_EQ(unpacked(Packing::lz4,
                     "\x30"
                     "abc",
                     4),
            "failed");
}

}  // namespace unpack_test
}  // namespace biss::capture
